"""Prepare a recording: its paths, and its likelihood by samples once the motion is nearly known.

Falls as known motions: gravity is known, and all impacts lie on one floor.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from scipy.ndimage import uniform_filter1d

from radargui.calibration import unknowns as named
from radargui.calibration.known_path import KnownMotion, Trajectory
from radargui.calibration.likelihood import Measured, MotionModel
from radargui.calibration.unknowns import Unknown
from radargui.estimation.adaptive.estimate import estimate_adaptive
from radargui.estimation.adaptive.found import adaptive_rounds
from radargui.estimation.forward.bins import BinnedData, Multiplexer, bin_by_fringe, pool
from radargui.estimation.forward.parameters import ReceiverConstants
from radargui.estimation.forward.slow_noise import measure_drift
from radargui.estimation.forward.sphere import polarised_sphere
from radargui.estimation.motion_estimate import MotionEstimate
from radargui.estimation.signals import ScaledSignals, scaled_signals
from radargui.estimation.solve.initial_problem import first_motion, initial_problem
from radargui.estimation.solve.problem import Start
from radargui.model.arrays import BoolArray, ComplexArray, FloatArray
from radargui.model.errors import ProcessingError, SolveError, worded
from radargui.model.gravity import drag_of_sphere, expected_gravity_m_s2
from radargui.model.recording import Recording
from radargui.model.setup import Setup
from radargui.motion.flights import Flights
from radargui.motion.impacts import find_track_impacts
from radargui.physics.mirrors import FLOOR, MirrorPlane
from radargui.physics.path_length import MIN_RECEIVERS, path_lengths, place_antennas
from radargui.signals.condition import condition
from radargui.signals.conditioned import Conditioned
from radargui.signals.stretch import NoMotion

MIN_FLIGHT_S, MAX_FLIGHTS = 0.08, 4
"""Flights that are used: shorter ones say little of gravity, later ones no more than the first."""
RELEASE_S, MARGIN_S = 0.010, 0.001
"""What is left out after the onset, for a release is no clean cut, and beside an impact, which takes its time."""
U_ONSET_S, U_START_M_S, U_IMPACT_S, U_VELOCITY_M_S = 0.003, 0.02, 0.005, 0.3
"""Prior deviations: of the release's instant and speed (a finger's), of impacts and of the velocities after them."""
U_CONTACT_M = 2e-5
"""How well an impact lies on the floor's plane: roughness, and how far a sphere presses in."""
LEAN_DEG = 1e-3
"""Half the step of differences by which way gravity leans."""


@dataclass(frozen=True)
class Falls:
    """Rest, first fall, and the flights after it up to a time.

    Attributes
    ----------
    place
        Name of the place where the sphere hangs (`place_unknowns`).
    onset_s, impact_s
        First guesses; impacts end all flights but the last.
    after_m_s
        Velocities after the impacts, first guesses, shape (n_impacts, 3).
    end_s
        End of the last flight.
    slow_m_s
        v1 of the sphere's drag k (|v| + v1) v.
    """

    place: str
    onset_s: float
    impact_s: FloatArray
    after_m_s: FloatArray
    end_s: float
    slow_m_s: float = 0.0

    @property
    def own(self) -> tuple[Unknown, ...]:
        """Unknowns of this recording alone."""
        out = [Unknown("onset_s", self.onset_s, U_ONSET_S)]
        out += [Unknown(f"start.{axis}_m_s", 0.0, U_START_M_S) for axis in "xyz"]
        for n, (time, *velocity) in enumerate(np.column_stack([self.impact_s, self.after_m_s]).tolist(), 1):
            out.append(Unknown(f"impact.{n}_s", time, U_IMPACT_S))
            out += [
                Unknown(f"after.{n}.{axis}_m_s", v, U_VELOCITY_M_S) for axis, v in zip("xyz", velocity, strict=True)
            ]
        return tuple(out)

    @property
    def uses(self) -> tuple[str, ...]:
        """Names of the shared unknowns that it depends on."""
        places = tuple(f"{self.place}.{axis}" for axis in "xyz")
        fall = (named.GRAVITY, named.GRAVITY_X, named.GRAVITY_Y, named.DRAG)
        return (*places, *fall, named.HEIGHT, named.FLOOR_X, named.FLOOR_Y)

    def known(self, time_s: FloatArray) -> BoolArray:
        """Return whether the motion is known at times, shape (n,), as first guessed."""
        # by first guesses: which samples count must not change from step to step of the fit
        known = (time_s < self.onset_s - U_ONSET_S) | (time_s > self.onset_s + RELEASE_S)
        for impact in self.impact_s:
            known &= np.abs(time_s - impact) > MARGIN_S
        return np.asarray(known & (time_s < self.end_s - MARGIN_S))

    def at(self, time_s: FloatArray, shared: Mapping[str, float], own: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return place, velocity and acceleration at times, shape (3, 3, n), and what the impacts are off the floor.

        The distances from the floor are in standard deviations, shape (n_impacts,).

        Raises
        ------
        SolveError
            The unknowns describe no fall.
        """
        flights, frame = self._flights(shared, own)
        # after its last flight it counts as at rest: what it does there is not asked, and must not be far away
        is_flying = (time_s >= flights.onset_s) & (time_s <= self.end_s)
        place = frame @ flights.position_m(np.append(np.minimum(time_s, self.end_s), flights.impact_s))
        place += np.array([[shared[f"{self.place}.{axis}"]] for axis in "xyz"])
        velocity = frame @ flights.velocity_at(time_s)
        drag = flights.drag_1_m * (np.sqrt((velocity**2).sum(axis=0)) + self.slow_m_s) * velocity
        acceleration = -flights.g_m_s2 * frame[:, 2:] - drag
        series = np.stack(
            [place[:, : time_s.size], *(np.where(is_flying, one, 0.0) for one in (velocity, acceleration))]
        )
        return series, (self._above(shared) @ place[:, time_s.size :] - shared[named.HEIGHT]) / U_CONTACT_M

    def slopes(self, time_s: FloatArray, shared: Mapping[str, float], own: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return derivatives of places and ties by what it `uses`, then by its own, (n, 3, n_times) and (n, n_ties)."""
        (flights, frame), n_times = self._flights(shared, own), time_s.size
        layout, impacts = flights.layout, flights.impact_s
        _, by = flights.position_and_slopes(np.append(np.minimum(time_s, self.end_s), impacts))
        # an impact takes along the instant at which the sphere is at its floor
        for n, velocity in enumerate(flights.velocity_m_s[1:]):
            by[layout.impacts.start + n, :, n_times + n] += velocity
        by = frame @ by
        turned = [np.tensordot(frame, by[layout.velocity(n)], axes=1) for n in range(layout.n_flights)]
        moments = [by[[layout.onset]], *by[layout.impacts][:, None]]
        of_own = [part for pair in zip(moments, turned, strict=True) for part in pair]
        leaning = []
        for name in (named.GRAVITY_X, named.GRAVITY_Y):
            there = [self._flights({**shared, name: shared[name] + step}, own) for step in (-LEAN_DEG, LEAN_DEG)]
            low, high = (
                other @ one.position_m(np.append(np.minimum(time_s, self.end_s), impacts)) for one, other in there
            )
            leaning.append((high - low) / (2.0 * LEAN_DEG))
        still = np.zeros((3, *by.shape[1:]))
        of_fall = [by[layout.gravity], *leaning, by[layout.drag], *still]
        slopes = np.concatenate([np.broadcast_to(np.eye(3)[:, :, None], still.shape), of_fall, *of_own])
        hit = self.at(impacts, shared, own)[0][0]
        ties = np.einsum("x,kxn->kn", self._above(shared), slopes[:, :, n_times:])
        # the floor's height and its two slopes stand last of what is shared
        ties[7:10] = np.stack([-np.ones(impacts.size), *np.radians(hit[:2])])
        return slopes[:, :, :n_times], ties / U_CONTACT_M

    @staticmethod
    def _above(shared: Mapping[str, float]) -> FloatArray:
        # a floor whose normal leans to x falls off towards x
        return np.array([np.radians(shared[named.FLOOR_X]), np.radians(shared[named.FLOOR_Y]), 1.0])

    def _flights(self, shared: Mapping[str, float], own: FloatArray) -> tuple[Flights, FloatArray]:
        """Return the flights from the place, gravity along -z, and what turns them to where gravity leans, (3, 3)."""
        # two small leanings: the direction's length is one but for their fourth powers
        x, y = np.radians([shared[named.GRAVITY_X], shared[named.GRAVITY_Y]])
        up = np.array([-np.sin(x), -np.sin(y), np.cos(np.hypot(x, y))])
        first = np.array([up[2], 0.0, -up[0]]) / np.hypot(up[0], up[2])
        frame = np.stack([first, np.cross(up, first), up], axis=1)
        begin_s, velocity = np.append(own[0], own[4::4]), np.append(own[1:], 0.0).reshape(-1, 4)[:, :3]
        if not (np.diff(begin_s, append=self.end_s) > 0.0).all() or not np.isfinite(own).all():
            raise SolveError("Impacts out of their order are no fall.")
        g, drag = shared[named.GRAVITY], shared[named.DRAG]
        return Flights(float(own[0]), np.zeros(3), g, drag, self.slow_m_s, velocity @ frame, begin_s[1:]), frame


MAX_POINTS = 300
"""Of a recording's paths: what they have in common from sample to sample makes more of them worth no more."""
U_PATH_M = 3e-4
"""Of each of them, while the samples themselves do not decide: what floor and walls leave in a receiver's circle."""
POOLED_S = 0.002
"""Means in which a known motion is looked for: at 0.5 m/s a tenth of a fringe."""
FAR_FROM_G, MIN_VALUES = 0.25, 20
"""Relative deviation from g and number of values with which a flight is none: 3 degrees and 2 cm make 0.1."""
U_OFFSET_S = 0.01
"""Prior deviation of a free clock's offset against the best of the grid."""
OFFSETS, ZEROS, COARSE = 400, 24, 500
"""How many offsets of a clock, and zeros of a turntable, are tried at first, and on how many means."""
STILL = 9
"""Means of `POOLED_S` over which a phase is averaged at the least: 18 ms."""
FALL_BIAS_M, KNOWN_BIAS_M, FLOOR_BELOW_M = 0.09, 0.04, 0.01
"""Correlation length of the bias maps, and how far below the lowest place a floor is sought (method 4). A motion that
goes sideways sees the mirrored antennas' lobes from all sides, which the mirrors' factors, functions of height, do not
follow: shorter maps must, where the motion is known."""


U_FLOOR_M, U_FAR_FLOOR_M = 0.03, 0.15
"""Prior deviation of the floor's place, and where neither a fall nor the setup tells it."""


@dataclass(frozen=True)
class Prepared:
    """A recording with its paths and a first guess of its motion."""

    signals: ScaledSignals
    measured: Measured
    motion: MotionModel


def _conditioned(recording: Recording, setup: Setup) -> Conditioned:
    conditioned = condition(recording, setup)
    if isinstance(conditioned, NoMotion):
        raise ProcessingError(f"{recording.name}: {conditioned.finding.text}")
    return conditioned


def prepare_fall(recording: Recording, setup: Setup, place: str) -> Prepared:
    """Measure the paths of a fall, each receiver by itself, so that a wrong geometry hardly matters.

    The joint estimate would bend them: free flights and image theory do not fit wrong antennas, and it would invent
    walls instead (10 mm of path at 3 degrees).

    Parameters
    ----------
    recording, setup
        As for `processing.process`.
    place
        Name of the place where the sphere hung.

    Raises
    ------
    ProcessingError
        Nothing falls.
    """
    rounds = adaptive_rounds(_conditioned(recording, setup), setup)
    estimate = estimate_adaptive(rounds)
    gravity_m_s2 = expected_gravity_m_s2(setup.site)
    impact_s, after_m_s, end_s = _flights(estimate, gravity_m_s2)
    if end_s - estimate.onset_s < MIN_FLIGHT_S:
        by_receivers = impacts_of_most(
            estimate.time_s, estimate.change_m, estimate.onset_s, rounds.signals.rate_hz, gravity_m_s2
        )
        impact_s, after_m_s, end_s = _flights(replace(estimate, impact_s=by_receivers), gravity_m_s2)
    if end_s - estimate.onset_s < MIN_FLIGHT_S:
        raise worded(ProcessingError, "no_fall", name=recording.name, least_ms=1e3 * MIN_FLIGHT_S)
    slow_m_s = drag_of_sphere(setup.tracer.diameter_m, setup.tracer.density_kg_m3, setup.air.gas).slow_m_s
    motion = Falls(place, estimate.onset_s, impact_s, after_m_s, end_s, slow_m_s)
    change = np.where(estimate.valid, estimate.change_m, np.nan)
    return Prepared(rounds.signals, _thinned(estimate.time_s, change), motion)


def impacts_of_most(
    time_s: FloatArray, change_m: FloatArray, onset_s: float, rate_hz: float, gravity_m_s2: float
) -> FloatArray:
    """Return the impacts that two receivers' paths show by themselves, shape (n_impacts,).

    A height would not do: a fringe that one receiver loses for some milliseconds at the impact hides what the others
    show.

    Parameters
    ----------
    time_s, change_m
        Shapes (n,) and (n_receivers, n).
    onset_s, rate_hz
        When it begins to fall, and how many values a second.
    gravity_m_s2
        g of the place.
    """
    begun, later = np.searchsorted(time_s, [onset_s, onset_s + MIN_FLIGHT_S]).clip(max=time_s.size - 1)
    found = []
    for path in change_m:
        # a fall makes the path longer or shorter, as the antennas hang above or below
        height = -0.5 * np.sign(path[later] - path[begun]) * path
        found.append(find_track_impacts(time_s, height, np.isfinite(height), rate_hz, gravity_m_s2))
    out: list[float] = []
    for moment in np.sort(np.concatenate(found)):
        near = [float(np.median(one[here])) for one in found if (here := np.abs(one - moment) < U_IMPACT_S).any()]
        # a lost fringe makes a kink in one receiver's path alone
        if len(near) > 1 and (not out or np.median(near) - out[-1] > U_IMPACT_S):
            out.append(float(np.median(near)))
    return np.array(out)


def _thinned(time_s: FloatArray, change_m: FloatArray) -> Measured:
    stride = max(1, time_s.size // MAX_POINTS)
    return Measured(time_s[::stride], change_m[:, ::stride], U_PATH_M)


def _flights(estimate: MotionEstimate, gravity_m_s2: float) -> tuple[FloatArray, FloatArray, float]:
    """Return impacts, velocities after them and the end of the last flight that is used."""
    edges = [estimate.onset_s, *estimate.impact_s[:MAX_FLIGHTS]]
    place, velocities, end = estimate.position_m, [], estimate.onset_s
    for begin, stop in pairwise(edges):
        if place is None or stop - begin < MIN_FLIGHT_S:
            break
        here = (estimate.time_s > begin + 0.003) & (estimate.time_s < stop - 0.003)
        here &= np.isfinite(place).all(axis=0)
        if here.sum() < MIN_VALUES:
            break
        curve = np.polyfit(estimate.time_s[here] - begin, place[:, here].T, 2)
        # an impact that was not found makes two flights one, and that no parabola
        if abs(2.0 * curve[0, 2] / gravity_m_s2 + 1.0) > FAR_FROM_G:
            break
        velocities.append(curve[1])
        end = float(stop)
    return np.array(edges[1 : len(velocities)]), np.array(velocities[1:]).reshape(-1, 3), end


def prepare_known(recording: Recording, setup: Setup, trajectory: Trajectory) -> Prepared:
    """Find a known motion in a recording, and measure the paths against it.

    The phase that the motion should have is subtracted. The rest turns slowly, so that no fringe is lost where a circle
    alone would lose some.

    Parameters
    ----------
    recording, setup
        As for `processing.process`.
    trajectory
        In its own time.

    Raises
    ------
    ProcessingError
        Nothing moves, or recording and trajectory share a clock and do not overlap.
    """
    signals = scaled_signals(_conditioned(recording, setup))
    time, pairs = _pooled(signals)
    antennas, k = place_antennas(setup), 2.0 * np.pi / setup.radar.wavelength_m

    def phase(offset: float, zero: float, at: FloatArray) -> FloatArray:
        extra = (zero,) if trajectory.has_zero else ()
        return np.asarray(k * path_lengths(trajectory.place(at - offset, *extra), antennas))

    some = slice(None, None, max(1, time.size // COARSE))

    def unexplained(offset: float, zero: float) -> float:
        turned = phase(offset, zero, time[some])
        return sum(_circle(row, pair[:, some])[1] for row, pair in zip(turned, pairs, strict=True))

    free = trajectory.path.clock == "free"
    first = signals.onset_s - trajectory.begin_s
    if not free:
        refuse_apart(recording.name, float(time[0]), float(time[-1]), trajectory)
        offsets = np.zeros(1)
    else:
        # it may begin before the recording does, and its first moments may be too slow to be seen
        span = trajectory.end_s - trajectory.begin_s
        offsets = np.append(first + np.linspace(-span, min(span, time[-1] - first), OFFSETS), first)
    any_zero = trajectory.has_zero and trajectory.zero_deg is None
    zeros = np.arange(ZEROS) * 360.0 / ZEROS if any_zero else np.array([trajectory.zero_deg or 0.0])
    offset, zero = min(((o, z) for o in offsets for z in zeros), key=lambda one: unexplained(*one))
    if free:
        # the grid is coarse against a fringe of a fast motion: a finer look around the best
        step = float(np.ptp(offsets)) / OFFSETS
        offset = min(np.append(offset + np.linspace(-step, step, 41), offset), key=lambda o: unexplained(o, zero))
    motion = KnownMotion(trajectory, float(offset), U_OFFSET_S if free else 0.0, float(zero))
    turned = phase(offset, zero, time)
    change = np.array([against(row, pair)[1] for row, pair in zip(turned, pairs, strict=True)]) / k
    return Prepared(signals, _thinned(time, change), motion)


def against(foretold_rad: FloatArray, pair: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the phase of I and Q, (2, n), against one that is nearly right, (n,): means over a fringe, and values.

    After the predicted phase is subtracted, the rest turns slowly. The wave over floor and walls turns against it, once
    a fringe, and may be the larger one where a lobe makes the circle small. So turns are counted on means over whole
    fringes, in which that wave cancels; the rest is measured against these.
    """
    even = known = foretold_rad
    for _ in range(3):
        basis, _ = _circle(known, pair)
        i, q = np.linalg.solve(basis[1:].T, pair - basis[0][:, None])
        left = (i + 1j * q) * np.exp(-1j * foretold_rad)
        turns = np.unwrap(np.angle(_over_a_fringe(left, foretold_rad)))
        near = uniform_filter1d(left, STILL, mode="nearest") * np.exp(-1j * turns)
        even = foretold_rad + turns
        known = even + np.angle(near)
    return even, known


def measured_again(ready: Prepared, setup: Setup, values: dict[str, float], own: FloatArray) -> Prepared:
    """Return a known motion with its paths measured against those of a fit, as means over whole fringes.

    The better the predicted paths, the less such means smear; they are free of what bends a fringe.

    Parameters
    ----------
    ready
        The recording; a fall keeps its paths.
    setup, values, own
        As for `sample_problem`.
    """
    if not isinstance(ready.motion, KnownMotion):
        return ready
    time, pairs = _pooled(ready.signals)
    k = 2.0 * np.pi / setup.radar.wavelength_m
    phases = k * path_lengths(ready.motion.at(time, values, own)[0][0], place_antennas(setup))
    change = np.array([against(row, pair)[0] for row, pair in zip(phases, pairs, strict=True)]) / k
    return replace(ready, measured=_thinned(time, change))


def _pooled(signals: ScaledSignals) -> tuple[FloatArray, FloatArray]:
    """Return times, (n,), and means of I and Q, (n_receivers, 2, n)."""
    pooled = pool(signals, POOLED_S)
    return pooled.time_s, pooled.value.reshape(signals.n_receivers, 2, -1)


def _over_a_fringe(value: ComplexArray, phase_rad: FloatArray) -> ComplexArray:
    """Return means over half a turn of a phase to either side, and no less than `STILL` values, all shapes (n,)."""
    step = np.abs(np.gradient(phase_rad))
    way = np.cumsum(step)
    first, last = np.searchsorted(way, [way - np.pi, way + np.pi])
    number, half = np.arange(way.size), STILL // 2
    first, last = np.minimum(first, number - half).clip(0), np.maximum(last, number + half + 1).clip(max=way.size)
    # each piece of the turn counts alike, however fast it is gone through
    weight = step + 1e-3
    total = [np.concatenate([[0.0], np.cumsum(one)]) for one in (weight * value, weight)]
    return np.asarray((total[0][last] - total[0][first]) / (total[1][last] - total[1][first]))


def refuse_apart(name: str, first_s: float, last_s: float, trajectory: Trajectory) -> None:
    """Make sure that a recording and a trajectory on the same clock overlap.

    Raises
    ------
    ProcessingError
        They do not overlap.
    """
    if trajectory.end_s <= first_s or trajectory.begin_s >= last_s:
        facts = {"name": name, "first_s": first_s, "last_s": last_s, "path": trajectory}
        raise worded(ProcessingError, "no_overlap", **facts)


def _circle(phase_rad: FloatArray, pair: FloatArray) -> tuple[FloatArray, float]:
    """Fit I and Q, (2, n), by constants, cosine and sine of a phase; return coefficients (3, 2) and what is left."""
    rows = np.stack([np.ones_like(phase_rad), np.cos(phase_rad), np.sin(phase_rad)], axis=1)
    found = np.linalg.lstsq(rows, pair.T, rcond=None)[0]
    return np.asarray(found), float(((pair.T - rows @ found) ** 2).sum())


def sample_problem(ready: Prepared, setup: Setup, values: dict[str, float], own: FloatArray) -> Start | None:
    """Return the joint problem of the samples around a motion that is nearly known; None where it begins in motion.

    The problem has a floor that reflects, and maps; walls are described by the maps.

    Parameters
    ----------
    ready
        The recording.
    setup
        The setup with the antennas found so far.
    values, own
        Shared unknowns by name, and the motion's own (`likelihood.MotionModel`).
    """
    signals, motion = ready.signals, ready.motion
    # phases count from the rest, and fewer receivers bear no mirrors and no place
    if not signals.has_rest or signals.n_receivers < MIN_RECEIVERS:
        return None
    antennas, wavelength_m = place_antennas(setup), setup.radar.wavelength_m

    def place(time_s: FloatArray) -> FloatArray:
        return np.asarray(motion.at(time_s, values, own)[0][0])

    grid = signals.time_s[:: max(1, signals.time_s.size // 4000)]
    turns_hz = np.abs(np.gradient(path_lengths(place(grid), antennas), grid, axis=1)).max(axis=0) / wavelength_m
    # onset and velocity at the start come first, then impact and velocity by turns (`Falls.own`)
    breaks = own[4::4] if isinstance(motion, Falls) else np.empty(0)
    bins = bin_by_fringe(signals, grid, turns_hz, signals.rest_end_s, breaks)
    drift = measure_drift(signals, signals.rest_end_s)
    bins = drift.widen(bins)
    here = place(bins.time_s)
    multiplexer = None if signals.before is None else Multiplexer(signals.before, 1.0 / signals.rate_hz)
    # the release is where the motion as known begins
    data = BinnedData(
        bins, antennas, here[:, 0], wavelength_m, bins.last_s < signals.rest_end_s, signals.delay_s, signals.onset_s,
        expected_gravity_m_s2(setup.site), polarised_sphere(setup), multiplexer, drift.uncorrelated(bins),
        walls=setup.container.walls,
    )  # fmt: skip
    used = motion.known(bins.time_s)
    k = 2.0 * np.pi / wavelength_m
    turned = k * (path_lengths(here, antennas) - path_lengths(here[:, :1], antennas))
    pairs = zip(turned, bins.value.reshape(signals.n_receivers, 2, -1), strict=True)
    constants = [_constants(_circle(row[used], pair[:, used])[0]) for row, pair in pairs]
    normal = np.asarray(setup.floor.normal)
    lowest = here[:, int(np.argmin(np.where(used, normal @ here, np.inf)))]
    if setup.floor.height_m is not None:
        lowest = lowest * [1.0, 1.0, 0.0] + [0.0, 0.0, setup.floor.height_m]
    # a sphere that falls comes down on it; where another motion takes place nobody knows but the setup
    is_stated = setup.floor.height_m is not None or isinstance(motion, Falls)
    floor = MirrorPlane(
        lowest - FLOOR_BELOW_M * normal, normal, FLOOR, u_shift_m=U_FLOOR_M if is_stated else U_FAR_FLOOR_M
    )
    spline = first_motion(data, here, signals.rest_end_s, breaks)
    length_m = FALL_BIAS_M if isinstance(motion, Falls) else KNOWN_BIAS_M
    return initial_problem(data, spline, constants, (floor,), length_m)


def _constants(circle: FloatArray) -> ReceiverConstants:
    """Return a receiver's constants from the coefficients of 1, cos and sin of the phase, shape (3, 2) for I and Q.

    I = A cos(phi + phi_0), Q = g A sin(phi + phi_0 + eps).
    """
    (offset_i, offset_q), (ci, cq), (si, sq) = circle
    # I: ci = A cos phi0, si = -A sin phi0; Q: cq = g A sin(phi0 + eps), sq = g A cos(phi0 + eps)
    amplitude, phase = np.hypot(ci, si), np.arctan2(-si, ci)
    error = (np.arctan2(cq, sq) - phase + np.pi) % (2.0 * np.pi) - np.pi
    gain = np.log(max(np.hypot(cq, sq), 1e-6) / max(amplitude, 1e-6))
    return ReceiverConstants(
        float(phase), float(np.log(max(amplitude, 1e-3))), float(offset_i), float(offset_q),
        float(np.clip(gain, -0.3, 0.3)), float(np.clip(error, -0.3, 0.3)),
    )  # fmt: skip
