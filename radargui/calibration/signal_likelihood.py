"""The likelihood of a recording by its samples, with all mismatch marginalised.

Derivatives of amplitudes by places of antennas and tracer: the range factor, and what a sphere scatters. If everything
is turned about the vertical together no path changes; the polarised sphere alone shows such a turn.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from radargui.calibration.likelihood import (
    STEP,
    Begun,
    Likelihood,
    Local,
    MotionModel,
    World,
    cost_of,
    local_at,
    misfit_of,
    motion_slopes,
)
from radargui.estimation.forward.parameters import polarisation_places
from radargui.estimation.forward.signal_model import ModelInputs, Waves, log_ways, reflections
from radargui.estimation.forward.signal_slopes import receiver_slopes, ways_slopes
from radargui.estimation.forward.sphere import signals_of
from radargui.estimation.forward.thinned import Thinned
from radargui.estimation.solve.changed_problem import mirrors_changed
from radargui.estimation.solve.prior_deviations import reestimated
from radargui.estimation.solve.priors import Prior
from radargui.estimation.solve.problem import JointProblem, huber, node_offsets, signals_at
from radargui.model.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from radargui.model.errors import SolveError
from radargui.physics.mirrors import MirrorPlane
from radargui.physics.path_length import Antennas, range_factor

PLACE_STEP_M = 1e-5
"""Of differences in one direction: fields change over centimetres, so slopes are off by 1e-3 at most."""
EACH = 4
"""Of so many bins one is looked at, a sixth of a fringe: directions and what is scattered change over centimetres."""


@dataclass(frozen=True)
class AmplitudeSlopes:
    """Slopes of G_ab over G_00, shape (n_receivers, 1 + n_mirrors, 1 + n_mirrors, n_bins).

    G_ab is the wave over the ways a and b divided by the direct wave at rest, without the phases of paths and without
    reflections: range factor times F_ab / F_rest.

    Attributes
    ----------
    by_unknown
        Slopes by shared unknowns, by number, in prior deviations.
    by_place, by_rest
        Slopes by x, y, z of the place, and of the place at rest, 1/m.
    """

    by_unknown: dict[int, ComplexArray]
    by_place: tuple[ComplexArray, ...]
    by_rest: tuple[ComplexArray, ...]

    def of_channels(self, receiver: int, pairs: ComplexArray) -> tuple[dict[int, FloatArray], FloatArray, FloatArray]:
        """Return the slopes of a receiver's channels by unknowns, place and rest, (2, n_bins), (3, 2, n_bins) twice.

        Parameters
        ----------
        receiver
            Number.
        pairs
            The wave over each pair of ways as if all scattered like the straight one, (..., ..., 2, n_bins).
        """

        def shown(slope: ComplexArray) -> FloatArray:
            return np.asarray((pairs * slope[receiver][:, :, None]).real.sum(axis=(0, 1)))

        by_unknown = {number: shown(slope) for number, slope in self.by_unknown.items()}
        by_place, by_rest = (np.array([shown(one) for one in axes]) for axes in (self.by_place, self.by_rest))
        return by_unknown, by_place, by_rest


def amplitude_slopes(
    world: World, z: FloatArray, problem: JointProblem, theta: FloatArray, place_m: FloatArray
) -> AmplitudeSlopes:
    """Return the slopes at a state.

    Parameters
    ----------
    world, z
        Shared unknowns.
    problem, theta
        With the antennas of the state; mismatch.
    place_m
        At the bins, shape (3, n_bins).
    """
    rest_m, antennas = problem.inputs.release_m, problem.inputs.antennas
    angle, unknown = theta[polarisation_places(problem.layout)], problem.layout.plane_unknowns(theta)

    def received(place: FloatArray, antennas: Antennas, n_planes: int = len(problem.inputs.planes)) -> ComplexArray:
        # the direct way's range for all: by how much a mirrored one is longer `log_ways` knows
        near = range_factor(place, antennas, rest_m)[:, None, None]
        if problem.sphere is None:
            return np.asarray(near * np.ones((1, 1 + n_planes, 1 + n_planes, 1), complex))
        basis = problem.sphere.seen_by(antennas).basis(
            place, antennas, problem.inputs.planes[:n_planes], unknown[:n_planes]
        )
        return near * signals_of(basis, float(angle[0]), angle[1:])

    def resting(rest: FloatArray, antennas: Antennas) -> ComplexArray:
        # all is measured against the direct wave at rest: what mirrors add there is the reflections' own phase
        return received(rest[:, None], antennas, 0)

    # within a sixth of a fringe no direction changes by more than 1e-4
    thinned = Thinned(place_m.shape[1], EACH)
    place_m = place_m[:, thinned.bins]
    here, at_rest = received(place_m, antennas), resting(rest_m, antennas)

    def slope(ahead: ComplexArray, step: float) -> ComplexArray:
        return thinned((ahead - here) / (step * here[:, :1, :1]))

    by_unknown = {}
    for numbers in _together(world):
        ahead = np.zeros_like(z)
        # receivers move each its own rows: one step for the tilts of all
        ahead[list(numbers.values())] = STEP
        there = world.antennas(z + ahead)
        moved = slope(received(place_m, there) * (at_rest / resting(rest_m, there)), STEP)
        for receiver, number in numbers.items():
            if receiver is None:
                by_unknown[number] = moved
            else:
                by_unknown[number] = np.zeros_like(moved)
                by_unknown[number][receiver] = moved[receiver]
    steps = PLACE_STEP_M * np.eye(3)
    by_place = [slope(received(place_m + one[:, None], antennas), PLACE_STEP_M) for one in steps]
    # the place at rest is in the divisor alone: its slope needs the field there and nowhere else
    straight = thinned(here / here[:, :1, :1])
    by_rest = [straight * (at_rest / resting(rest_m + one, antennas) - 1.0) / PLACE_STEP_M for one in steps]
    return AmplitudeSlopes(by_unknown, tuple(by_place), tuple(by_rest))


def _together(world: World) -> list[dict[int | None, int]]:
    """Return the unknowns of the antennas' places by receiver, those together that move different ones; None: all."""
    out: dict[str, dict[int | None, int]] = {}
    for number, one in enumerate(world.unknowns):
        place, _, name = one.key.partition(".")
        if one.key and one.group != "polarization":
            receiver = int(place[9:-1]) - 1 if place.startswith("receiver") else None
            out.setdefault(one.key if receiver is None else name, {})[receiver] = number
    return list(out.values())


@dataclass(frozen=True)
class ReceiverRows:
    """The derivatives of a receiver's channels.

    Attributes
    ----------
    index
        Places among the shared and own unknowns, shape (n,).
    rows
        Slopes in prior deviations, shape (2, n_bins, n).
    along
        Derivatives by the phase, shape (2, n_bins).
    """

    index: IntArray
    rows: FloatArray
    along: FloatArray


@dataclass(frozen=True)
class SampledState:
    """A recording's samples at a state.

    Attributes
    ----------
    problem, theta
        With the antennas of the state; global parameters.
    place_m, node_m
        At the bins, (3, n_bins), and at their nodes, (3, n_channels, 2, n_bins).
    residual, sigma, weight
        Model less data, shape (n_channels, n_bins), zero where a bin does not count; the standard deviation of each;
        robust weights over variance.
    """

    problem: JointProblem
    theta: FloatArray
    place_m: FloatArray
    node_m: FloatArray
    residual: FloatArray
    sigma: FloatArray
    weight: FloatArray
    use: BoolArray
    loss: float
    slopes: FloatArray
    ties: tuple[FloatArray, FloatArray]
    excess: FloatArray
    waves: Waves


@dataclass(frozen=True)
class SignalLikelihood(Likelihood):
    """The likelihood of a recording by its bins: the equations of the joint estimate with the known motion inserted.

    Its own unknowns are those of the motion and all mismatch (theta of the joint estimate, in prior deviations from
    `theta`).

    Attributes
    ----------
    problem
        Problem of the joint estimate (`preparing.sample_problem`); its spline and its equation of flight are not used.
    theta
        Where the mismatch starts.
    motion
        What is known.
    """

    problem: JointProblem
    theta: FloatArray
    motion: MotionModel

    @property
    def start(self) -> FloatArray:
        """The motion at its prior mean, the mismatch at `theta`."""
        return np.zeros(len(self.motion.own) + self.theta.size)

    @property
    def n_motion(self) -> int:
        """How many of its own unknowns are the motion's."""
        return len(self.motion.own)

    def theta_at(self, own: FloatArray) -> FloatArray:
        """Return the mismatch where its own unknowns are."""
        return self.theta + self.problem.prior.sd * own[self.n_motion :]

    def sampled(self, world: World, z: FloatArray, own: FloatArray) -> SampledState:
        """Return samples, model and weights at a state."""
        problem, theta = self.problem, self.theta_at(own)
        series, slopes, tied, by_ties = motion_slopes(self.motion, world, z, own[: self.n_motion], problem.bins.time_s)
        antennas, angles = world.antennas(z), world.polarisations(z)
        if problem.sphere is not None:
            if angles.size:
                theta[polarisation_places(problem.layout)] = angles
            problem = replace(problem, sphere=problem.sphere.seen_by(antennas))
        # phases count from where it rests now: a place that moves would turn those of all mirrors otherwise
        inputs = replace(problem.inputs, antennas=antennas, release_m=series[0][:, 0])
        problem = replace(problem, inputs=inputs).at_places(series[0], theta)
        # a multiplexer takes the channels one after another: the sphere is elsewhere for each
        later = node_offsets(problem)
        place, velocity, acceleration = series[:, :, None, None]
        node_m = place + later * (velocity + later / 2.0 * acceleration)
        signals, excess, waves = signals_at(problem, theta, node_m)
        sigma = problem.bins.sigma * np.repeat(problem.noise_scale, 2)[:, None]
        # beside an impact and after the last flight nothing is known, and nothing is asked
        use = problem.use & self.motion.known(problem.bins.time_s)
        residual = (np.concatenate([one.value for one in signals]) - problem.bins.value) * use
        losses, weight = huber(residual / sigma)
        loss = float(losses.sum())
        return SampledState(
            problem, theta, series[0], node_m, residual, sigma, weight * use / sigma**2, use, loss, slopes,
            (tied, by_ties), excess, waves,
        )  # fmt: skip

    def rows(self, world: World, z: FloatArray, at: SampledState) -> list[ReceiverRows]:
        """Return what each receiver's channels change with."""
        slopes = amplitude_slopes(world, z, at.problem, at.theta, at.place_m)
        return [self._rows(world, z, at, n, slopes) for n in range(at.problem.n_receivers)]

    def _rows(self, world: World, z: FloatArray, at: SampledState, n: int, amplitudes: AmplitudeSlopes) -> ReceiverRows:
        problem, theta, layout, n_shared = at.problem, at.theta, at.problem.layout, len(z)
        pair, receiver, sd = slice(2 * n, 2 * n + 2), layout.receivers[n], problem.prior.sd
        lin = receiver_slopes(at.node_m[:, pair], theta, layout, problem.inputs, n, at.excess[pair], at.waves.of(n))
        thinned = Thinned(problem.bins.n_bins, EACH)
        # directions change over centimetres: they are those of a bin's middle for both its channels and nodes
        place_m = at.place_m[:, None, None, thinned.bins]
        plain = log_ways(place_m, theta, layout, problem.inputs, n)

        def ways(place: FloatArray, other: ModelInputs, step: float) -> ComplexArray:
            return (log_ways(place, theta, layout, other, n) - plain) / step

        pairs = reflections(theta, layout, receiver)[:, :, None, None] * at.waves.of(n).mean
        by_unknown, by_place, by_rest = amplitudes.of_channels(n, pairs)
        steps, inputs = PLACE_STEP_M * np.eye(3), problem.inputs
        by_ways = [ways(place_m + ahead[:, None, None, None], inputs, PLACE_STEP_M) for ahead in steps]
        by_ways += [ways(place_m, replace(inputs, release_m=inputs.release_m + ahead), PLACE_STEP_M) for ahead in steps]
        own_place = ("transmitter", f"receiver[{n + 1}]")
        antennas = [
            k for k, one in enumerate(world.unknowns) if one.key.startswith(own_place) and one.group != "polarization"
        ]
        for k in antennas:
            other = replace(inputs, antennas=world.antennas(z + STEP * (np.arange(n_shared) == k)))
            by_ways.append(ways(place_m, other, STEP))
        shown = ways_slopes(at.waves.of(n), thinned(np.array(by_ways)))
        by_place, by_rest = by_place + shown[:3], by_rest + shown[3:6]
        known = np.einsum("xcn,xnk->cnk", by_place, at.slopes) + np.einsum("xcn,xk->cnk", by_rest, at.slopes[:, 0])
        turning = np.empty(0)
        if problem.sphere is not None and world.polarisations(z).size:
            # what all recordings share is no recording's own
            of_transmitter = layout.polarization.start - layout.shared.start
            both = [of_transmitter, receiver.polarization.start - receiver.first + lin.n_shared]
            turning = np.moveaxis(lin.columns[:, :, both], 2, 0)
            lin.columns[:, :, both] = 0.0
        for k, slope in zip(antennas, shown[6:], strict=True):
            known[:, :, k] += slope + by_unknown[k]
        for k, one in enumerate(world.unknowns):
            if len(turning) and one.group == "polarization" and one.key.startswith(own_place):
                known[:, :, k] += turning[int(one.key[0] == "r")] * np.radians(one.u)
        first = n_shared + self.n_motion
        columns = [known, lin.columns * np.concatenate([sd[layout.shared], sd[receiver.without_drift]])]
        places = [np.arange(first), *(first + np.arange(s.start, s.stop) for s in (
            layout.shared, receiver.without_drift
        ))]  # fmt: skip
        if layout.sizes.drift:
            # a drift is one channel's own: the other's rows are zero
            drift = problem.inputs.drift[pair]
            for c, own_drift in enumerate((receiver.drift_i, receiver.drift_q)):
                apart = np.zeros_like(drift)
                apart[c] = drift[c] * sd[own_drift]
                columns.append(apart)
                places.append(first + np.arange(own_drift.start, own_drift.stop))
        along = lin.columns[:, :, receiver.phase - receiver.first + lin.n_shared]
        return ReceiverRows(np.concatenate(places), np.concatenate(columns, axis=2), along)

    def begun(self, world: World, z: FloatArray, own: FloatArray) -> Begun:
        """Return its cost at a state, and the function that computes the rest, which takes three times as long."""
        at = self.sampled(world, z, own)
        cost = cost_of(at.loss, at.ties[0], self._pull(own))
        return Begun(cost, lambda: self.local(at, self.rows(world, z, at), z.size, own))

    def _pull(self, own: FloatArray) -> FloatArray:
        # the breaks of its spline are not asked: they stay, and so do angles that all recordings share
        prior = self.problem.prior
        return np.concatenate([own[: self.n_motion], (self.theta_at(own) - prior.mean) / prior.sd])

    def local(self, at: SampledState, parts: list[ReceiverRows], n_shared: int, own: FloatArray) -> Local:
        """Return the normal equations of what the channels change with."""
        problem, n_all = at.problem, n_shared + own.size
        normal, slope = np.zeros((n_all, n_all)), np.zeros(n_all)
        residual_m = np.full((problem.n_receivers, problem.bins.n_bins), np.nan)
        for n, one in enumerate(parts):
            pair = slice(2 * n, 2 * n + 2)
            # a matrix by its own transpose stays symmetric, and BLAS does half of it only
            root = np.sqrt(at.weight[pair])
            flat = (one.rows * root[:, :, None]).reshape(-1, one.index.size)
            normal[np.ix_(one.index, one.index)] += flat.T @ flat
            slope[one.index] += flat.T @ (root * at.residual[pair]).ravel()
            # along the circle: what of the residual a path would explain
            along = one.along * problem.inputs.wavenumber
            power = np.maximum((along**2).sum(axis=0), 1e-12)
            residual_m[n] = np.where(at.use, -(along * at.residual[pair]).sum(axis=0) / power, np.nan)
        scaled = at.residual / at.sigma
        misfit = np.array([misfit_of(scaled[2 * n : 2 * n + 2, at.use]) for n in range(problem.n_receivers)])
        return local_at(at.loss, normal, slope, n_shared, at.ties, self._pull(own), residual_m, misfit)

    def renewed(self, own: FloatArray, local: Local) -> tuple[SignalLikelihood, FloatArray]:
        """Return it with the deviations of maps and mirrors re-estimated and the noise scaled, and its own unknowns.

        As the joint estimate does between its rounds (method 4, Priors).

        Raises
        ------
        SolveError
            The state is no minimum, so that nothing can be re-estimated.
        """
        old, theta = self.problem.prior, self.theta_at(own)
        try:
            variance = np.diag(np.linalg.inv(local.inner))[self.n_motion :] * old.sd**2
        except np.linalg.LinAlgError as error:
            raise SolveError("A recording's own unknowns are not determined.") from error
        # never below the white noise that was measured: a good fit by chance makes no sample better
        scale = np.maximum(self.problem.noise_scale * np.sqrt(np.maximum(local.misfit, 1e-3)), 1.0)
        if not (np.isfinite(variance).all() and np.isfinite(theta).all() and np.isfinite(scale).all()):
            raise SolveError("A recording's samples are far from any motion as stated.")
        prior = reestimated(old, theta, np.maximum(variance, 0.0))
        return self.with_problem(replace(self.problem, prior=prior, noise_scale=scale), theta, own)

    def scaled(self, misfit: FloatArray, least: float) -> SignalLikelihood:
        """Return it with the noise of each receiver as its misfit says, shape (n_receivers,).

        It is never below the white noise, nor below a share of its former value.
        """
        scale = self.problem.noise_scale * np.maximum(np.sqrt(np.maximum(misfit, 1e-3)), least)
        return replace(self, problem=replace(self.problem, noise_scale=np.maximum(scale, 1.0)))

    def with_problem(
        self, problem: JointProblem, theta: FloatArray, own: FloatArray
    ) -> tuple[SignalLikelihood, FloatArray]:
        """Return it with another problem that starts at theta, and its own unknowns there."""
        state = np.concatenate([own[: self.n_motion], np.zeros(theta.size)])
        return replace(self, problem=problem, theta=theta), state

    def with_mirrors(self, planes: Sequence[MirrorPlane], own: FloatArray) -> tuple[SignalLikelihood, FloatArray]:
        """Return it with more mirrors, which reflect nothing yet, and its own unknowns."""
        every = (*self.problem.inputs.planes, *planes)
        return self.with_problem(*mirrors_changed(self.problem, self.theta_at(own), every), own)

    def with_prior(self, prior: Prior, own: FloatArray) -> tuple[SignalLikelihood, FloatArray]:
        """Return it with another prior, and its own unknowns."""
        return self.with_problem(replace(self.problem, prior=prior), self.theta_at(own), own)

    def log_widths(self) -> float:
        """Return the noise scales' part of the log evidence (`minimise.log_evidence`)."""
        return 2.0 * int(self.problem.use.sum()) * float(np.log(self.problem.noise_scale).sum())
