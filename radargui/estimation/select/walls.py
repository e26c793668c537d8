"""Walls that reflect: searched over azimuth and distance where the misfit asks for them (method 4, Walls)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import solve_triangular
from scipy.sparse import csr_matrix, eye_array, kron

from radargui.estimation.forward.mirrors import WALL, MirrorPlane, detour_ratio
from radargui.estimation.forward.parameters import polarisation_places
from radargui.estimation.forward.signal_model import FrontEndState, field_at_nodes
from radargui.estimation.forward.signal_slopes import receiver_slopes
from radargui.estimation.select.converge import converge
from radargui.estimation.solve.changed_problem import carried_places, positions_at_bins, problem_with_mirrors
from radargui.estimation.solve.minimise import Solution, log_evidence
from radargui.estimation.solve.priors import Prior
from radargui.estimation.solve.problem import JointProblem, State, assemble, linearise
from radargui.model.arrays import ComplexArray, FloatArray


@dataclass(frozen=True, slots=True)
class WallSettings:
    """Where walls are sought and when one is kept. Chosen by hand on seeded scenes; the accuracy benchmark is the test.

    Attributes
    ----------
    azimuths, distances_m
        Grid around the middle of the motion: 9 degrees apart, within what one converges from, and geometric steps from
        the field of view to 1 m. Where the grid ends before the wall a false one is taken: 0.5 mm for a wall at 35 cm
        on a grid to 20 cm.
    fine_deg, fine_share, nearest_m
        Grid around a wall that was found, distances as shares of its own; no wall is nearer than the last.
    u_shift_share, least_u_shift_m
        Deviation of a wall's shift as a share of its distance, half a step of the grid, and its least: a wavelength.
    carried, carried_again
        Local maxima that are converged in the first and in later searches: the linearised ranking is not reliable.
    stiff_bias, stiff_log_amplitude
        Most that the maps' deviations may be while the grid is looked at: what they are with nothing left to explain.
    reflection
        Deviation of T and R on the grid: walls of a few per cent are sought.
    u_azimuth_rad
        Of a wall's azimuth: a grid step is 0.16 rad.
    rounds
        Of convergence of each trial.
    searches, worthwhile
        At most so many, as long as ln E grows by so much.
    promising
        A coarse look goes on where it gains this in ln E.
    convincing
        A wall is kept at this gain in ln E, since many are tried; what the prior of its reflection costs is in it.
    """

    azimuths: int = 40
    distances_m: tuple[float, ...] = (0.08, 0.115, 0.165, 0.235, 0.34, 0.485, 0.695, 1.0)
    fine_deg: tuple[float, ...] = (-16.0, -12.0, -8.0, -4.0, 0.0, 4.0, 8.0, 12.0, 16.0)
    fine_share: tuple[float, ...] = (0.8, 0.865, 0.93, 1.0, 1.075, 1.16, 1.25)
    u_shift_share: float = 0.2
    least_u_shift_m: float = 0.03
    nearest_m: float = 0.05
    carried: int = 4
    carried_again: int = 2
    stiff_bias: float = 0.003
    stiff_log_amplitude: float = 0.07
    reflection: float = 0.03
    u_azimuth_rad: float = 0.15
    rounds: int = 3
    searches: int = 4
    worthwhile: float = 2.0
    promising: float = 3.0
    convincing: float = 10.0


WALLS = WallSettings()
_THIN = 8  # bins, a third of a fringe: what the sphere scatters over a wall changes over decimetres


@dataclass(frozen=True)
class WallTrial:
    """A converged solution with one more wall and what it gains in log evidence."""

    solution: Solution
    gain: float


@dataclass(frozen=True)
class WallSearch:
    """What was found.

    Attributes
    ----------
    tried
        Converged solutions with one more wall, the best first.
    """

    tried: tuple[WallTrial, ...]

    @property
    def gain(self) -> float:
        """What the best wall gains, -inf where none was tried."""
        return self.tried[0].gain if self.tried else -np.inf


def search_wall(
    solution: Solution,
    normal: FloatArray,
    round_done: Callable[[], None],
    *,
    thorough: bool,
    settings: WallSettings = WALLS,
) -> WallSearch:
    """Search one more wall over azimuth and distance.

    Every wall of a grid gets its linearised evidence with everything else marginalised; the best few are converged,
    because the linearised ranking is not reliable. The search is repeated, finer, around what was found, as long as
    that gains: a motion bent by a wall that is not in the model hides where the wall stands.

    Parameters
    ----------
    solution
        The model without the wall, converged.
    normal
        Upward normal of the floor, shape (3,).
    round_done
        Called once a round; may raise to cancel.
    thorough
        False: converge fewer, and stop after the coarse search unless it finds something.
    settings
        Grid and limits.
    """
    # distances count from the middle of the motion: there a wall's detour turns as the search believes
    mirrors, middle = solution.problem.inputs.planes, positions_at_bins(solution).mean(axis=1)
    azimuth, distance = wall_grid(settings)
    # evidence moves while priors are re-estimated: the model without the wall goes through the same rounds
    without = log_evidence(converge(problem_with_mirrors(solution, mirrors), settings.rounds, round_done))
    base, tried = solution, WallSearch(())
    for number in range(settings.searches):
        planes = upright_planes(middle, normal, azimuth, distance, settings)
        gains = linearised_gains(base, planes, round_done, settings).reshape(azimuth.size, -1)
        most = settings.carried if thorough and number == 0 else settings.carried_again
        # maxima, not the best places: neighbours of one maximum converge to the same wall
        numbers = _peaks(gains, around=number == 0)[:most]
        trials = [
            converge(problem_with_mirrors(base, (*mirrors, planes[k])), settings.rounds, round_done) for k in numbers
        ]
        before, more = tried.gain, [WallTrial(trial, log_evidence(trial) - without) for trial in trials]
        tried = WallSearch(tuple(sorted([*tried.tried, *more], key=lambda one: -one.gain)))
        if tried.gain < before + settings.worthwhile or not (thorough or tried.gain > settings.promising):
            break
        best = tried.tried[0].solution
        # what the wall has straightened stays straight: from there its place shows better than from the bent motion
        base = _without_last_mirror(best, solution.problem)
        found = _place_of_last(best, middle, normal)
        azimuth = found[0] + np.radians(settings.fine_deg)
        distance = np.maximum(found[1] * np.array(settings.fine_share), settings.nearest_m)
    return tried


def wall_grid(settings: WallSettings = WALLS) -> tuple[FloatArray, FloatArray]:
    """Return azimuths (rad) and distances (m) of the first search."""
    return np.linspace(0.0, 2.0 * np.pi, settings.azimuths, endpoint=False), np.array(settings.distances_m)


def linearised_gains(
    solution: Solution, planes: list[MirrorPlane], round_done: Callable[[], None], settings: WallSettings = WALLS
) -> FloatArray:
    """Return the linearised log evidence of each plane as one more wall, shape (n_planes,)."""
    search, gains = _LinearisedSearch(solution, settings), []
    for number, plane in enumerate(planes):
        if number % 20 == 0:
            round_done()
        gains.append(search.gain(plane))
    return np.array(gains)


def _without_last_mirror(solution: Solution, problem: JointProblem) -> Solution:
    """Return a solution's state in the problem that lacks its last mirror: not a minimum, a place to search from."""
    place, there = carried_places(problem.layout, solution.problem.layout)
    # with the bias maps of a problem without the wall: those of the other have shrunk
    theta = np.zeros(problem.layout.size)
    theta[place] = solution.state.theta[there]
    state = State(solution.state.coefficients, theta)
    bare = replace(problem, spline=solution.problem.spline)
    at = linearise(bare, state)
    return Solution(bare, state, at, assemble(bare, state, at).factor(), False)


def _tangents(normal: FloatArray) -> tuple[FloatArray, FloatArray]:
    first = np.cross(normal, np.array([0.0, 1.0, 0.0]))
    first /= np.linalg.norm(first)
    return first, np.cross(normal, first)


def upright_planes(
    middle_m: FloatArray,
    normal: FloatArray,
    azimuth_rad: FloatArray,
    distance_m: FloatArray,
    settings: WallSettings = WALLS,
) -> list[MirrorPlane]:
    """Return planes along the floor's normal around the middle of the motion, azimuth by azimuth."""
    first, second = _tangents(normal)
    out = []
    for angle in azimuth_rad:
        outward = np.cos(angle) * first + np.sin(angle) * second
        for away in distance_m:
            # half a step of the grid: convergence may go on to the neighbour, not beyond
            u_shift = max(settings.u_shift_share * float(away), settings.least_u_shift_m)
            foot = middle_m + away * outward
            out.append(MirrorPlane(foot, -outward, WALL, settings.u_azimuth_rad, u_shift_m=u_shift))
    return out


def _place_of_last(solution: Solution, middle_m: FloatArray, normal: FloatArray) -> tuple[float, float]:
    """Return azimuth and distance of a solution's last mirror."""
    problem = solution.problem
    unknown = problem.layout.plane_unknowns(solution.state.theta)[-1]
    outward = problem.inputs.planes[-1].image(middle_m, unknown) - middle_m
    first, second = _tangents(normal)
    return float(np.arctan2(outward @ second, outward @ first)), 0.5 * float(np.linalg.norm(outward))


class _LinearisedSearch:
    """What a new mirror would explain of the residuals with everything else marginalised, computed once a solution."""

    def __init__(self, solution: Solution, settings: WallSettings) -> None:
        self.solution, self.reflection, problem = solution, settings.reflection, solution.problem
        # at the state of the loose maps, with the curvature of stiff ones: what they have taken shows as slope
        stiff = _stiffened(problem, settings)
        assembled = assemble(stiff, solution.state, solution.at)
        self.normal = assembled.factor()
        self.half_slope = self.normal.motion.half_solve(assembled.slope_motion[:, None])
        self.lower_slope = solve_triangular(
            self.normal.schur[0],
            assembled.slope_global[:, None] - self.normal.half.T @ self.half_slope,
            lower=True,
            check_finite=False,
        )
        self.n_bins, self.n_receivers = problem.bins.n_bins, problem.n_receivers
        self.motion = csr_matrix(kron(solution.at.design, eye_array(3), format="csr")).T
        self.breaks = solution.at.spline.break_slopes(problem.bins.time_s, solution.state.coefficients).T
        theta, layout, inputs = solution.state.theta, problem.layout, problem.inputs
        self.nodes = [solution.at.node_m[:, 2 * n : 2 * n + 2] for n in range(self.n_receivers)]
        spheres = [inputs.sphere_factors(theta, layout, n) for n in range(self.n_receivers)]
        self.fields = [field_at_nodes(node, theta, layout, inputs, n, spheres[n]) for n, node in enumerate(self.nodes)]
        self.place = positions_at_bins(solution)
        # once a solution, for hundreds of places
        self.slopes = [
            receiver_slopes(node, theta, layout, inputs, n, solution.at.excess[2 * n : 2 * n + 2])
            for n, node in enumerate(self.nodes)
        ]

    def gain(self, plane: MirrorPlane) -> float:
        """Return g^T A^-1 g / 2 - ln det(A sd^2) / 2, A the Schur complement of T and R, g their slope."""
        n_new = 2 + 2 * self.n_receivers
        problem, at = self.solution.problem, self.solution.at
        old, inputs = problem.layout, problem.inputs
        # T and R are linear in the signal: their evidence needs one solve a place, no iteration
        slope, curvature = np.zeros(n_new), np.zeros((n_new, n_new))
        to_global = np.zeros((old.size, n_new))
        pulled = np.zeros((self.n_bins, 3, n_new))
        shared, scattered = old.shared, self._scattered(plane)
        for receiver, before in enumerate(self.slopes):
            own = old.receivers[receiver]
            front_end, j = FrontEndState.of(self.solution.state.theta, own), np.zeros((2, self.n_bins, n_new))
            antennas = inputs.antennas.transmitter_m, inputs.antennas.receivers_m[receiver]
            for first, antenna, body in zip((0, 2 + 2 * receiver), antennas, scattered[receiver], strict=True):
                ratio = detour_ratio(
                    self.nodes[receiver], antenna, plane, np.zeros(3), inputs.release_m, inputs.wavenumber
                )
                z = (self.fields[receiver] * ratio).mean(axis=1) * body
                j[:, :, first], j[:, :, first + 1] = front_end.channels(z), front_end.channels(1j * z)
            # robust weights of the last step: an impulse must not find a wall
            pair = slice(2 * receiver, 2 * receiver + 2)
            weighed = at.weight[pair][:, :, None] * j
            misfit = at.signals[receiver].value - problem.bins.value[pair]
            slope += np.einsum("pnk,pn->k", weighed, misfit)
            flat = weighed.reshape(2 * self.n_bins, n_new)
            curvature += flat.T @ j.reshape(2 * self.n_bins, n_new)
            to_global[own.without_drift] += before.by_own.reshape(2 * self.n_bins, -1).T @ flat
            to_global[own.drift_i] += inputs.drift.T @ weighed[0]
            to_global[own.drift_q] += inputs.drift.T @ weighed[1]
            to_global[shared] += before.by_shared.reshape(2 * self.n_bins, -1).T @ flat
            for part in range(2):
                pulled += before.by_position[part].T[:, :, None] * weighed[part][:, None, :]
        pull = pulled.reshape(3 * self.n_bins, n_new)
        to_global[old.breaks] = self.breaks @ pull
        normal = self.normal
        # Schur complement: the motion, then all global parameters, taken out
        half = normal.motion.half_solve(self.motion @ pull)
        lower = solve_triangular(normal.schur[0], to_global - normal.half.T @ half, lower=True, check_finite=False)
        a = curvature - half.T @ half - lower.T @ lower + np.eye(n_new) / self.reflection**2
        slope = slope - (half.T @ self.half_slope + lower.T @ self.lower_slope)[:, 0]
        # rounding can take the last digit of a reflection that the motion explains entirely
        sign, log_determinant = np.linalg.slogdet(a)
        if sign <= 0:
            return -np.inf
        return float(0.5 * slope @ np.linalg.solve(a, slope) - 0.5 * log_determinant - n_new * np.log(self.reflection))

    def _scattered(self, plane: MirrorPlane) -> list[tuple[ComplexArray | float, ComplexArray | float]]:
        """Return M of the paths over a plane, by the transmitter's and by each receiver's image; one for a point."""
        problem = self.solution.problem
        if problem.sphere is None:
            return [(1.0, 1.0)] * self.n_receivers
        # Mie sums are the dearest part of a place
        thin = np.unique(np.append(np.arange(0, self.n_bins, _THIN), self.n_bins - 1))
        angles = self.solution.state.theta[polarisation_places(problem.layout)]
        ratios = problem.sphere.over_mirror(self.place[:, thin], problem.inputs.antennas, plane, angles)
        every = np.arange(self.n_bins)
        return [(np.interp(every, thin, a), np.interp(every, thin, b)) for a, b in ratios]


def _stiffened(problem: JointProblem, settings: WallSettings) -> JointProblem:
    """Return the problem with maps as stiff as if nothing were left to explain.

    Maps that have grown to explain a wall would hide it.
    """
    sd = problem.prior.sd.copy()
    for own in problem.layout.receivers:
        for places in (own.bias_i, own.bias_q):
            sd[places] = np.minimum(sd[places], settings.stiff_bias)
        sd[own.amplitude_map] = np.minimum(sd[own.amplitude_map], settings.stiff_log_amplitude)
    prior = Prior(problem.prior.mean, sd, problem.prior.groups)
    return replace(problem, prior=prior)


def _peaks(table: FloatArray, *, around: bool) -> list[int]:
    """Return the flat indices of the local maxima, the highest first.

    Parameters
    ----------
    table
        Shape (n_azimuths, n_distances).
    around
        Whether the azimuths go round.
    """
    wide = (
        np.pad(table, ((1, 1), (0, 0)), mode="wrap")
        if around
        else np.pad(table, ((1, 1), (0, 0)), constant_values=-np.inf)
    )
    high = np.pad(table, ((0, 0), (1, 1)), constant_values=-np.inf)
    beside = np.maximum(np.maximum(wide[:-2], wide[2:]), np.maximum(high[:, :-2], high[:, 2:]))
    top, gain = ((table >= beside) & np.isfinite(table)).ravel(), table.ravel()
    return [int(k) for k in np.argsort(np.where(top, gain, -np.inf))[::-1] if top[k]]
