"""Compute the linearised evidence of one more wall at places of a grid, all else marginalised."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import bsr_matrix, csr_matrix, hstack, vstack

from radargui.estimation.forward.lobes import axis_of, off_axis, strength_change
from radargui.estimation.forward.parameters import polarisation_places
from radargui.estimation.forward.signal_model import ModelInputs, Waves, waves_at
from radargui.estimation.forward.signal_slopes import receiver_slopes
from radargui.estimation.solve.assemble import assemble
from radargui.estimation.solve.changed_problem import positions_at_bins, stiff_equation_sd
from radargui.estimation.solve.lobe_prior import main_lobes
from radargui.estimation.solve.minimise import Solution
from radargui.estimation.solve.priors import Prior
from radargui.estimation.solve.problem import JointProblem
from radargui.model.arrays import ComplexArray, FloatArray, pieces
from radargui.physics.mirrors import WALL, MirrorPlane, distances, turned
from radargui.physics.path_length import Antennas


@dataclass(frozen=True, slots=True)
class WallSettings:
    """Where walls are sought and when one is kept. Chosen by hand on seeded scenes; the accuracy benchmark is the test.

    Attributes
    ----------
    azimuths, distances_m
        Grid around the middle of the motion: azimuths 9 degrees apart, from which a wall converges, and distances in
        geometric steps to 1 m. A wall beyond the grid would be replaced by a false one.
    fine_deg, nearest_m
        Grid of a calibration around a wall that was found; least distance of a wall.
    u_shift_share, min_u_shift_m
        Deviation of a wall's shift: a share of its distance (half a step of the grid), at least a wavelength.
    tried, first_steps
        Number of local maxima that are begun, and of steps taken from each: the true wall may be the ninth (decision
        35).
    carried, carried_again
        Number of the best of these that are converged, in the first and in later searches.
    stiff_bias, stiff_log_amplitude, stiff_steps
        Largest deviations of the maps while the grid is evaluated, those of maps with nothing left to explain; and the
        number of steps in which a motion follows.
    reflection, u_azimuth_rad
        Deviations of T and R on the grid (walls of a few per cent), and of a wall's azimuth (a step of the grid is 0.16
        rad).
    rounds, searches, worthwhile
        Rounds of each trial; largest number of searches; least growth of ln E for another search.
    promising
        A coarse search continues if it gains this in ln E, a thorough one if it loses less than `convincing`.
    max_behind
        A trial is given up if it is so far behind the best in ln E, after its first minimum and after each round: no
        trial of twelve scenes caught up more than 30 from the first round on, but the right wall of another was 156
        behind.
    level, last_rounds
        Trials less than `level` behind the best in ln E continue for `last_rounds` before one is taken.
    beyond_doubt
        A wall that gains so much is not searched again before it is moved.
    convincing
        Least gain in ln E of a wall that is kept, because many are tried; it includes the cost of the reflection's
        prior.
    """

    azimuths: int = 40
    distances_m: tuple[float, ...] = (0.08, 0.115, 0.165, 0.235, 0.34, 0.485, 0.695, 1.0)
    fine_deg: tuple[float, ...] = (-16.0, -12.0, -8.0, -4.0, 0.0, 4.0, 8.0, 12.0, 16.0)
    u_shift_share: float = 0.2
    min_u_shift_m: float = 0.03
    nearest_m: float = 0.05
    tried: int = 12
    first_steps: int = 3
    carried: int = 4
    carried_again: int = 2
    stiff_bias: float = 0.003
    stiff_log_amplitude: float = 0.07
    stiff_steps: int = 12
    reflection: float = 0.03
    u_azimuth_rad: float = 0.15
    rounds: int = 3
    searches: int = 2
    worthwhile: float = 2.0
    promising: float = 3.0
    max_behind: tuple[float, float, float] = (1000.0, 200.0, 60.0)
    level: float = 15.0
    last_rounds: int = 4
    beyond_doubt: float = 50.0
    convincing: float = 10.0


WALLS = WallSettings()
TOGETHER = 20  # places looked at together, which count as a round of convergence: calls cost more than the cache saves


def wall_grid(settings: WallSettings = WALLS) -> tuple[FloatArray, FloatArray]:
    """Return azimuths (rad) and distances (m) of the first search."""
    return np.linspace(0.0, 2.0 * np.pi, settings.azimuths, endpoint=False), np.array(settings.distances_m)


def tangents(normal: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return two directions across a unit vector, shapes (3,), from which a wall's azimuth is counted."""
    first = np.cross(normal, np.array([0.0, 1.0, 0.0]))
    first /= np.linalg.norm(first)
    return first, np.cross(normal, first)


def wall_towards(image_m: FloatArray, normal: FloatArray) -> tuple[float, float]:
    """Return azimuth (rad) and distance (m) of an upright wall from a point, by that point's image against it, (3,)."""
    first, second = tangents(normal)
    # an image is as far behind the wall as the point is before it
    return float(np.arctan2(image_m @ second, image_m @ first)), 0.5 * float(np.linalg.norm(image_m))


def upright_planes(
    middle_m: FloatArray,
    normal: FloatArray,
    azimuth_rad: FloatArray,
    distance_m: FloatArray,
    settings: WallSettings = WALLS,
) -> list[MirrorPlane]:
    """Return planes along the floor's normal around the middle of the motion, (3,) each, azimuth by azimuth."""
    first, second = tangents(normal)
    out = []
    for angle in azimuth_rad:
        outward = np.cos(angle) * first + np.sin(angle) * second
        for away in distance_m:
            # half a step of the grid: convergence may go on to the neighbour, not beyond
            u_shift = max(settings.u_shift_share * float(away), settings.min_u_shift_m)
            foot = middle_m + away * outward
            out.append(MirrorPlane(foot, -outward, WALL, settings.u_azimuth_rad, u_shift_m=u_shift))
    return out


def linearised_gains(
    solution: Solution, planes: list[MirrorPlane], round_done: Callable[[], None], settings: WallSettings = WALLS
) -> FloatArray:
    """Return the linearised log evidence of each plane as one more wall, shape (n_planes,)."""
    search, gains = LinearisedSearch(solution, settings), []
    for part in pieces(len(planes), TOGETHER):
        round_done()
        gains.append(search.gains(planes[part]))
    return np.concatenate(gains)


class LinearisedSearch:
    """The residuals that a new mirror would explain with everything else marginalised, prepared once for a solution."""

    def __init__(self, solution: Solution, settings: WallSettings) -> None:
        self.solution, self.reflection, problem = solution, settings.reflection, solution.problem
        # at the state of the loose maps, with the curvature of stiff ones: what they have taken shows as slope
        stiff = replace(stiffened(problem, settings), equation_sd=stiff_equation_sd(solution))
        assembled = assemble(stiff, solution.state, solution.at)
        self.normal = assembled.factor()
        self.half_slope = self.normal.half_solve(assembled.slope[:, None])
        self.n_bins = problem.bins.n_bins
        motion = solution.at.series.rows().of_place
        breaks = solution.at.spline.break_slopes(problem.bins.time_s, solution.state.coefficients)
        moved = csr_matrix(hstack([motion, breaks]))
        self.n_motion = motion.shape[1]
        # once a solution, for hundreds of places
        self.receivers = [_Receiver.of(solution, moved, n) for n in range(problem.n_receivers)]
        self.place_m = positions_at_bins(solution)

    def gains(self, planes: list[MirrorPlane]) -> FloatArray:
        """Return g^T A^-1 g / 2 - ln det(A sd^2) / 2, A the Schur complement of T and R, g their slope; (n_planes,)."""
        slope, a, _ = self.marginal(planes)
        return evidence_of(slope, a, self.reflection)

    def marginal(self, planes: list[MirrorPlane]) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return g and A of the n T and R, and what half solves leave of their coupling to motion and parameters.

        Shapes (n_planes, n), (n_planes, n, n) and (n_half, n_planes n), see `FactoredNormal.half_solve`.
        """
        problem = self.solution.problem
        n_new, n_planes, layout = 2 + 2 * problem.n_receivers, len(planes), problem.layout
        # T and R are linear in the signal: their evidence needs one solve a place, no iteration
        slope, curvature = np.zeros((n_planes, n_new)), np.zeros((n_planes, n_new, n_new))
        coupling = np.zeros((self.n_motion + layout.size, n_planes, n_new))
        to_motion, to_global = coupling[: self.n_motion], coupling[self.n_motion :]
        inputs, images = problem.inputs, images_of(problem.inputs.antennas, planes)
        scattered = scattered_over(problem, self.solution.state.theta, self.place_m, planes)
        for number, (receiver, own) in enumerate(zip(self.receivers, layout.receivers, strict=True)):
            j = receiver.direct.columns(
                (images[0], images[1 + number]), None if scattered is None else [leg[:, number] for leg in scattered]
            )
            weighed = (j * receiver.weight).reshape(4 * n_planes, -1)
            # T is the transmitter's and every receiver shows it, R is each receiver's own
            columns = np.r_[0:2, 2 + 2 * number : 4 + 2 * number]
            slope[:, columns] += (weighed @ receiver.misfit.ravel()).reshape(n_planes, 4)
            flat = weighed.reshape(n_planes, 4, -1)
            curvature[:, columns[:, None], columns] += flat @ j.reshape(flat.shape).transpose(0, 2, 1)
            turned_round = np.ascontiguousarray(weighed.T)
            moved = (receiver.moved @ turned_round).reshape(-1, n_planes, 4)
            coupled = [(to_motion, moved[: self.n_motion]), (to_global[layout.breaks], moved[self.n_motion :])]
            for places, by in ((own.without_drift, receiver.by_own), (layout.shared, receiver.by_shared)):
                coupled.append((to_global[places], (by.T @ turned_round).reshape(-1, n_planes, 4)))
            for channel, places in enumerate((own.drift_i, own.drift_q)):
                of_channel = turned_round[channel * self.n_bins : (channel + 1) * self.n_bins]
                drift = (inputs.drift[2 * number + channel].T @ of_channel).reshape(-1, n_planes, 4)
                coupled.append((to_global[places], drift))
            for out, by_planes in coupled:
                # slices, not lists of places: these would be copied there and back
                out[:, :, :2] += by_planes[:, :, :2]
                out[:, :, 2 + 2 * number : 4 + 2 * number] = by_planes[:, :, 2:]
        # Schur complement: the motion and all global parameters taken out
        half = self.normal.half_solve(coupling.reshape(len(coupling), -1))
        slope = slope - (half.T @ self.half_slope).reshape(n_planes, n_new)
        columns = half.reshape(-1, n_planes, n_new).transpose(1, 2, 0)
        a = curvature + np.eye(n_new) / self.reflection**2 - columns @ columns.transpose(0, 2, 1)
        return slope, a, half


def evidence_of(slope: FloatArray, a: FloatArray, reflection: float) -> FloatArray:
    """Return g^T A^-1 g / 2 - ln det(A sd^2) / 2 of slopes g, (n_planes, n), and A with its prior, (n_planes, n, n)."""
    n_new = slope.shape[1]
    sign, log_determinant = np.linalg.slogdet(a)
    # rounding can take the last digit of a reflection that the motion explains entirely
    a = np.where((sign > 0.0)[:, None, None], a, np.eye(n_new))
    explained = np.einsum("pk,pk->p", slope, np.linalg.solve(a, slope[:, :, None])[:, :, 0])
    gain = 0.5 * explained - 0.5 * log_determinant - n_new * np.log(reflection)
    return np.where(sign > 0.0, gain, -np.inf)


def scattered_over(
    problem: JointProblem, theta: FloatArray, place_m: FloatArray, planes: list[MirrorPlane]
) -> tuple[ComplexArray, ComplexArray] | None:
    """Return the factors M of what the sphere scatters over trial planes; None where it counts as a point.

    By the images of transmitter and receivers, (n_planes, n_receivers, n_bins) each.

    Parameters
    ----------
    problem, theta
        With its sphere and the antennas' angles.
    place_m
        At the bins, shape (3, n_bins).
    planes
        To try.
    """
    if problem.sphere is None:
        return None
    angles = theta[polarisation_places(problem.layout)]
    return problem.sphere.over_mirrors(place_m, problem.inputs.antennas, planes, angles)


@dataclass(frozen=True)
class DirectWave:
    """The direct wave of a receiver, from which a mirrored one is computed.

    Attributes
    ----------
    place_m, length_m
        Places, (3, n_bins), and their distances from transmitter and receiver, (2, n_bins).
    antenna_m
        Transmitter and receiver, shape (2, 3).
    main_lobes
        Exponents of their main lobes, shape (2,).
    lobe
        ln strength towards the places, against the release, shape (2, n_bins).
    release_m, wavenumber
        As of `ModelInputs`.
    field
        As the channels show it (`Waves.mean`), shape (2, n_bins).
    """

    place_m: FloatArray
    length_m: FloatArray
    antenna_m: FloatArray
    main_lobes: FloatArray
    lobe: FloatArray
    release_m: FloatArray
    wavenumber: float
    field: ComplexArray

    @staticmethod
    def of(node_m: FloatArray, waves: Waves, inputs: ModelInputs, main_lobes: FloatArray) -> DirectWave:
        """Return the direct wave at a receiver's nodes, (3, 2, 2, n_bins), with the exponents of both lobes, (2,)."""
        # what a detour adds changes by a fringe where the way does so, too: one place a bin will do
        antenna_m, place_m = waves.antenna_m[:, 0], node_m.mean(axis=(1, 2))
        length_m = distances(place_m, antenna_m)
        q, q_rest = off_axis(axis_of(antenna_m), antenna_m, place_m, length_m, inputs.release_m)
        lobe = np.stack([strength_change(*one) for one in zip(main_lobes, q, q_rest, strict=True)])
        k, field = inputs.wavenumber, waves.mean[0, 0]
        return DirectWave(place_m, length_m, antenna_m, main_lobes, lobe, inputs.release_m, k, field)

    def columns(self, images_m: tuple[FloatArray, FloatArray], scattered: Sequence[ComplexArray] | None) -> FloatArray:
        """Return slopes of the channels by real and imaginary part of T, then of R, (n_planes, 4, 2, n_bins).

        Parameters
        ----------
        images_m
            Of transmitter and receiver, (n_planes, 3) each.
        scattered
            What the sphere scatters that way (`scattered_over`), (n_planes, n_bins) each; None for a point.
        """
        z = [
            self._over(image, leg) * (1.0 if scattered is None else scattered[leg][:, None])
            for leg, image in enumerate(images_m)
        ]
        return np.stack([part for one in z for part in (one.real, -one.imag)], axis=1)

    def _over(self, image_m: FloatArray, leg: int) -> ComplexArray:
        direct, away = self.length_m[leg], distances(self.place_m, image_m)
        antenna = self.antenna_m[leg]
        rest = np.linalg.norm(self.release_m - image_m, axis=1) - np.linalg.norm(self.release_m - antenna)
        # the image looks where its antenna does in the mirror; its lobe is that of an ordinary antenna
        axis, normal = axis_of(antenna), axis_of(antenna - image_m)
        turned_axis = axis - 2.0 * (normal @ axis)[:, None] * normal
        q, q_rest = off_axis(turned_axis, image_m, self.place_m, away, self.release_m)
        share = np.exp(strength_change(self.main_lobes[leg], q, q_rest) - self.lobe[leg]) * direct / away
        ratio = share * turned(self.wavenumber * (away - direct - rest[:, None]))
        return np.asarray(self.field * ratio[:, None])


def images_of(antennas: Antennas, planes: list[MirrorPlane]) -> FloatArray:
    """Return the images of the transmitter and of each receiver, shape (1 + n_receivers, n_planes, 3)."""
    points = np.array([antennas.transmitter_m, *antennas.receivers_m])[:, None]
    foot, normal = np.array([(plane.foot_m, plane.normal) for plane in planes]).swapaxes(0, 1)
    return np.asarray(points - 2.0 * ((points - foot) * normal).sum(axis=-1, keepdims=True) * normal)


@dataclass(frozen=True)
class _Receiver:
    """One receiver at a solution: the direct wave, and the unknowns that a mirrored one couples to.

    Attributes
    ----------
    direct
        Its direct wave.
    weight, misfit
        Shape (2, n_bins).
    by_own, by_shared
        Slopes, (2 n_bins, n).
    moved
        Both channels' slopes with respect to motion and breaks, transposed, (n_motion + n_breaks, 2 n_bins).
    """

    direct: DirectWave
    weight: FloatArray
    misfit: FloatArray
    by_own: FloatArray
    by_shared: FloatArray
    moved: csr_matrix

    @staticmethod
    def of(solution: Solution, moved: csr_matrix, number: int) -> _Receiver:
        problem, at, theta = solution.problem, solution.at, solution.state.theta
        layout, inputs, pair = problem.layout, problem.inputs, slice(2 * number, 2 * number + 2)
        node_m, n_bins = at.node_m[:, pair], problem.bins.n_bins
        waves = waves_at(node_m, theta, layout, inputs, number)
        slopes = receiver_slopes(node_m, theta, layout, inputs, number, at.excess[pair], waves)
        every = np.arange(n_bins + 1)
        by_motion = [
            bsr_matrix((own.T[:, None].copy(), every[:-1], every), shape=(n_bins, 3 * n_bins)).tocsr() @ moved
            for own in slopes.by_position
        ]
        return _Receiver(
            DirectWave.of(node_m, waves, inputs, main_lobes(layout, theta)[[0, 1 + number]]),
            # robust weights of the last step: an impulse must not find a wall
            at.weight[pair],
            at.signals[number].value - problem.bins.value[pair],
            slopes.by_own.reshape(2 * n_bins, -1),
            slopes.by_shared.reshape(2 * n_bins, -1),
            csr_matrix(vstack(by_motion).T),
        )


def stiffened(problem: JointProblem, settings: WallSettings = WALLS) -> JointProblem:
    """Return the problem with maps as stiff as if nothing were left to explain.

    Maps that have grown to explain a wall would hide that wall.
    """
    sd = problem.prior.sd.copy()
    for own in problem.layout.receivers:
        for places in (own.bias_i, own.bias_q):
            sd[places] = np.minimum(sd[places], settings.stiff_bias)
        sd[own.amplitude_map] = np.minimum(sd[own.amplitude_map], settings.stiff_log_amplitude)
    prior = Prior(problem.prior.mean, sd, problem.prior.groups)
    return replace(problem, prior=prior)
