"""A calibration from recordings and what is known of their motions."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from multiprocessing import get_context
from typing import TypeVar

import numpy as np

from radargui import __version__
from radargui.calibration.fit import Fit, fit
from radargui.calibration.known_path import KnownMotion, Trajectory
from radargui.calibration.likelihood import Likelihood, Motion, PathLikelihood, SignalLikelihood, World
from radargui.calibration.preparing import Prepared, prepare, solve_jointly
from radargui.calibration.unknowns import (
    USUAL,
    antenna_unknowns,
    fall_unknowns,
    place_unknowns,
    setup_with,
)
from radargui.calibration.verdict import FAR, MISFIT_M, fit_paths, left_out, lost_fringe, other_order, rms_m, untold
from radargui.estimation.solve.minimise import Solution
from radargui.geometry.path_length import path_lengths, place_antennas
from radargui.model.arrays import FloatArray
from radargui.model.calibration import Calibration, Origin, Residual
from radargui.model.errors import ProcessingError
from radargui.model.recording import Recording
from radargui.model.setup import Setup

Progress = Callable[[float], None]
T = TypeVar("T")
RELEASE = "tracer.release_position_m"
U_OFFSET_S = 0.02
"""Prior deviation of a free clock's offset against the best of the grid."""
OFFSETS, ZEROS = 400, 24
"""How many offsets of a clock, and zeros of a turntable, are tried at first."""
MOST_ROUNDS = 60


@dataclass(frozen=True)
class KnownRecording:
    """A recording and what is known of its motion.

    Attributes
    ----------
    recording
        Samples.
    checksum
        SHA-256 of the file.
    trajectory
        None: it is a fall.
    release_m
        Where the sphere hung before a fall, as stated.
    """

    recording: Recording
    checksum: str
    trajectory: Trajectory | None
    release_m: tuple[float, float, float]

    @property
    def rest_m(self) -> tuple[float, float, float]:
        """Where the sphere is before it moves."""
        if self.trajectory is None:
            return self.release_m
        x, y, z = self.trajectory.place(np.array([self.trajectory.begin_s]))[:, 0].tolist()
        return (x, y, z)


@dataclass(frozen=True)
class Calibrated:
    """A calibration, the setup with its values, and the fit.

    Attributes
    ----------
    calibration
        For the file.
    setup
        With the values and their u; its own where the calibration is refused.
    fit
        Unknowns and covariance of everything.
    """

    calibration: Calibration
    setup: Setup
    fit: Fit


def calibrate(
    recordings: Sequence[KnownRecording],
    setup: Setup,
    groups: Sequence[str] = USUAL,
    *,
    progress: Progress = lambda _: None,
    workers: int = 1,
    made_at: str = "",
    operator: str = "",
) -> Calibrated:
    """Find the antennas from what the tracer did.

    Parameters
    ----------
    recordings
        At least one.
    setup
        Where the antennas are said to be, with its uncertainties.
    groups
        What is free (`unknowns.GROUPS`); what is not stays where it is, and its uncertainty counts.
    progress
        Called with the share done; what it raises ends the work.
    workers
        Processes for the estimates of the recordings.
    made_at, operator
        For its origin.

    Raises
    ------
    ProcessingError
        A recording does not fit what is known of it: swapped receivers, a lost fringe, no overlap.
    """
    shares = _Shares(progress, len(recordings))
    prepared = _each(prepare, [(one.recording, _at(setup, one)) for one in recordings], workers, shares)
    world, places = _world(setup, recordings, groups)
    held = np.array([bool(one.group) and one.group not in groups for one in world.unknowns])
    motions = [
        _motion(one, ready, place, world) for one, ready, place in zip(recordings, prepared, places, strict=True)
    ]
    wavelength_m, is_plane = setup.radar.wavelength_m, setup.processing.geometry == "plane"
    by_paths = [
        PathLikelihood(ready.measured, motion, wavelength_m, is_plane)
        for ready, motion in zip(prepared, motions, strict=True)
    ]
    rough = fit_paths(world, by_paths, held, shares.round_done)
    _refuse_misfit(rough, by_paths, recordings, shares.round_done)
    before = fit_paths(world, by_paths, np.ones_like(held), shares.round_done)
    likelihoods, own = _sharpened(rough, by_paths, motions, recordings, setup, places, workers, shares)
    found = fit(world, likelihoods, held=held, start=rough, own=own, round_done=shares.round_done)
    calibration = _calibration(found, before, likelihoods, recordings, made_at, operator)
    progress(1.0)
    return Calibrated(calibration, calibrated_setup(setup, found, calibration), found)


def _sharpened(
    rough: Fit,
    by_paths: Sequence[PathLikelihood],
    motions: Sequence[Motion],
    recordings: Sequence[KnownRecording],
    setup: Setup,
    places: Sequence[str],
    workers: int,
    shares: _Shares,
) -> tuple[list[Likelihood], list[FloatArray]]:
    """Return the likelihoods by samples where a joint estimate stands, else by paths of honest weight, and starts."""
    values = rough.world.values(rough.z)
    better = setup_with(setup, rough.world.unknowns, values)
    tasks = []
    for one, place in zip(recordings, places, strict=True):
        at = tuple(values[f"{place}.{axis}"] for axis in "xyz") if place else one.rest_m
        tasks.append((one.recording, _hung(better, at)))
    solutions = _each(_try_jointly, tasks, workers, shares)
    out: list[Likelihood] = []
    own = []
    for path, motion, state, local, solution in zip(
        by_paths, motions, rough.own, rough.locals_, solutions, strict=True
    ):
        if solution is None or path.is_plane:
            # neighbours share their error: one value counts for a quarter of a fringe
            turns = np.nanmax(np.ptp(np.nan_to_num(path.measured.change_m), axis=1)) / path.wavelength_m
            crowd = max(1.0, path.measured.time_s.size / (4.0 * max(turns, 1.0)))
            u_m = float(max(rms_m(local.residual_m).max(), 1e-5) * np.sqrt(crowd))
            out.append(replace(path, measured=replace(path.measured, u_m=u_m)))
            own.append(state)
            continue
        out.append(SignalLikelihood(solution.problem, solution.state.theta, motion))
        n_own = len(motion.own)
        own.append(np.concatenate([state[:n_own], np.zeros(solution.state.theta.size)]))
    return out, own


def _try_jointly(recording: Recording, setup: Setup) -> Solution | None:
    try:
        return solve_jointly(recording, setup)
    except (ProcessingError, np.linalg.LinAlgError):
        return None


def _world(setup: Setup, recordings: Sequence[KnownRecording], groups: Sequence[str]) -> tuple[World, list[str]]:
    """Return the shared unknowns, and the name of each recording's place (empty: a known motion)."""
    unknowns = [one for one in antenna_unknowns(setup, place="transmitter" in groups) if one.group != "polarization"]
    names: dict[tuple[float, float, float], str] = {}
    places = []
    for one in recordings:
        if one.trajectory is not None:
            places.append("")
            continue
        if one.release_m not in names:
            own = one.release_m == tuple(setup.tracer.release_position_m)
            names[one.release_m] = RELEASE if own else f"place.{len(names) + 1}"
            unknowns += place_unknowns(setup, one.release_m, names[one.release_m])
        places.append(names[one.release_m])
    if names:
        unknowns += fall_unknowns(setup)
    return World(setup, tuple(unknowns)), places


def _motion(one: KnownRecording, ready: Prepared, place: str, world: World) -> Motion:
    if one.trajectory is None:
        return ready.falls(place)
    return _started(one.trajectory, ready, world.setup)


def _started(trajectory: Trajectory, ready: Prepared, setup: Setup) -> KnownMotion:
    """Return the trajectory with its clock's offset, and a turntable's zero, where they fit the paths best.

    Raises
    ------
    ProcessingError
        A shared clock under which recording and trajectory do not overlap.
    """
    time, change = ready.measured.time_s, ready.measured.change_m
    first, last = ready.onset_s, float(time[-1])
    if trajectory.path.clock == "shared":
        if trajectory.end_s <= time[0] or trajectory.begin_s >= last:
            raise ProcessingError(
                f"{ready.name}: its {time[0]:.3g} to {last:.3g} s and the {trajectory.begin_s:.3g} to "
                f"{trajectory.end_s:.3g} s of the {trajectory.words} do not overlap",
                remedy="Give the path of this recording, or leave --clock shared out.",
            )
        offsets = np.zeros(1)
    else:
        # the motion as seen may begin before or within the path; both rest outside of it
        span = trajectory.end_s - trajectory.begin_s
        offsets = first - trajectory.begin_s + np.linspace(-max(span, 0.1), 0.1, OFFSETS)
        offsets = np.append(offsets, first - trajectory.begin_s)
    unknown_zero = trajectory.has_zero and trajectory.zero_deg is None
    zeros = np.arange(ZEROS) * 360.0 / ZEROS if unknown_zero else np.array([trajectory.zero_deg or 0.0])
    antennas, stride = place_antennas(setup), max(1, time.size // 100)
    some, seen = time[::stride], change[:, ::stride]

    def misfit(offset: float, zero: float) -> float:
        place = trajectory.place(some - offset, *((zero,) if trajectory.has_zero else ()))
        away = path_lengths(place, antennas) - seen
        return float(np.nanmean((away - np.nanmean(away, axis=1, keepdims=True)) ** 2))

    offset, zero = min(((o, w) for o in offsets for w in zeros), key=lambda one: misfit(*one))
    free = trajectory.path.clock == "free"
    return KnownMotion(trajectory, float(offset), U_OFFSET_S if free else 0.0, float(zero))


def _refuse_misfit(
    rough: Fit,
    by_paths: Sequence[PathLikelihood],
    recordings: Sequence[KnownRecording],
    round_done: Callable[[], None],
) -> None:
    """Say why paths do not fit what is known; nothing where they do.

    Raises
    ------
    ProcessingError
        A lost fringe, swapped receivers, a mirror image, or another motion.
    """
    worst = max(float(np.nanmax(rms_m(one.residual_m))) for one in rough.locals_)
    antennas = np.array([bool(one.key) for one in rough.world.unknowns])
    if worst < MISFIT_M and np.abs(rough.z[antennas]).max(initial=0.0) < FAR:
        return
    slip = lost_fringe(rough, by_paths)
    if slip is not None:
        number, receiver, time_s = slip
        raise ProcessingError(
            f"{recordings[number].recording.name}: receiver {receiver + 1} lost a fringe near {time_s:.3f} s: its path "
            "steps by a whole wavelength there",
            remedy="Leave this recording out.",
        )
    better = other_order(rough, by_paths, round_done)
    if better is not None:
        raise ProcessingError(
            f"the recordings do not fit the setup, but they do where {better[0]}",
            remedy="Correct the wiring, or the order and azimuths of the receivers in the setup.",
        )
    if worst >= MISFIT_M:
        number = int(np.argmax([np.nanmax(rms_m(one.residual_m)) for one in rough.locals_]))
        known = recordings[number].trajectory
        raise ProcessingError(
            f"{recordings[number].recording.name}: its paths are {1e3 * worst:.1f} mm off what is known of its motion "
            f"({'fall' if known is None else known.words}), whatever the antennas",
            reasons=("it belongs to another path file", "the antennas are farther off than the setup's u says"),
        )


def _calibration(
    found: Fit,
    before: Fit,
    likelihoods: Sequence[Likelihood],
    recordings: Sequence[KnownRecording],
    made_at: str,
    operator: str,
) -> Calibration:
    unknowns = found.world.unknowns
    kept = [n for n, one in enumerate(unknowns) if not found.held[n] and (one.key or one.name.startswith(RELEASE))]
    u = np.array([unknowns[n].u for n in kept])
    mean = np.array([unknowns[n].value for n in kept])
    covariance = np.outer(u, u) * found.covariance()[np.ix_(kept, kept)]
    words, condition_number = untold(found)
    shrunk = np.sqrt(np.diag(covariance)) / u
    antennas = np.array([bool(unknowns[n].key) for n in kept])
    verdict, reason = "good", "every combination of the values is told better by the recordings than by the setup"
    if words:
        verdict = "usable"
        reason = f"what the recordings cannot tell keeps the setup's uncertainty: {'; '.join(words)}"
    if not (shrunk[antennas] < 0.7).any():
        verdict, reason = (
            "refused",
            (
                "the path is too short or too simple to tell any antenna better than the setup does (condition number "
                f"{condition_number:.3g})"
            ),
        )
    residuals = []
    alone = left_out(found, likelihoods)
    for one, now, then, other in zip(recordings, found.locals_, before.locals_, alone, strict=True):
        for n, (a, b, c) in enumerate(zip(rms_m(now.residual_m), rms_m(then.residual_m), other, strict=True), 1):
            residuals.append(Residual(one.recording.name, n, float(a), float(b), float(c)))
    names = tuple(unknowns[n].name for n in kept)
    known = tuple("fall" if one.trajectory is None else one.trajectory.words for one in recordings)
    files = {one.recording.name: one.checksum for one in recordings}
    far = [unknowns[n].name for n in kept if abs(found.z[n]) > 3.0]
    notes = (f"condition number {condition_number:.3g}",) + (
        (f"farther from the setup's value than 3 of its u: {', '.join(far)}",) if far else ()
    )
    return Calibration(
        names, mean, mean + u * found.z[kept], u, covariance, words, tuple(residuals), verdict, reason,
        Origin(made_at, operator, __version__, files, known), notes,
    )  # fmt: skip


def calibrated_setup(setup: Setup, found: Fit, calibration: Calibration) -> Setup:
    """Return the setup with the values found and their u; unchanged where the calibration is refused."""
    if calibration.verdict == "refused":
        return setup
    values = dict(zip(calibration.names, calibration.values.tolist(), strict=True))
    u = dict(zip(calibration.names, np.sqrt(np.diag(calibration.covariance)).tolist(), strict=True))
    setup = setup_with(setup, found.world.unknowns, values)
    sender = setup.transmitter
    apart = [u[name] for name in u if name.startswith("transmitter.")]
    if apart:
        sender = sender.model_copy(update={"u_distance_m": max(apart)})
    receivers = []
    for n, one in enumerate(setup.receiver, 1):
        own = {f"u_{key}": u[f"receiver.{n}.{key}"] for key in ("tilt_deg", "azimuth_deg", "distance_m")
               if f"receiver.{n}.{key}" in u}  # fmt: skip
        receivers.append(one.model_copy(update=own))
    tracer = setup.tracer
    if f"{RELEASE}.x" in values:
        place = tuple(values[f"{RELEASE}.{axis}"] for axis in "xyz")
        u_place = max(u[f"{RELEASE}.{axis}"] for axis in "xyz")
        tracer = tracer.model_copy(update={"release_position_m": place, "u_release_m": u_place})
    return setup.model_copy(update={"transmitter": sender, "receiver": tuple(receivers), "tracer": tracer})


def _at(setup: Setup, one: KnownRecording) -> Setup:
    return _hung(setup, one.rest_m)


def _hung(setup: Setup, place: Sequence[float]) -> Setup:
    """Return the setup with the sphere hanging at a place."""
    return setup.model_copy(update={"tracer": setup.tracer.model_copy(update={"release_position_m": tuple(place)})})


class _Shares:
    """Progress of the parts: two estimates a recording, and rounds of the fits, of which nobody knows how many.

    Parameters
    ----------
    report
        Given the share done.
    count
        Recordings.
    """

    def __init__(self, report: Progress, count: int) -> None:
        self._report, self._count, self._done, self._rounds = report, count, 0, 0

    def one_done(self) -> None:
        """A recording was estimated."""
        self._done += 1
        self._tell()

    def round_done(self) -> None:
        """A step of a fit was made."""
        self._rounds += 1
        self._tell()

    def _tell(self) -> None:
        self._report(0.7 * self._done / (2 * self._count) + 0.3 * self._rounds / (self._rounds + MOST_ROUNDS))


def _each(
    work: Callable[[Recording, Setup], T], tasks: Sequence[tuple[Recording, Setup]], workers: int, shares: _Shares
) -> list[T]:
    """Do the work on each recording, in processes where there are workers for it."""
    out = []
    if workers < 2 or len(tasks) < 2:
        for one in tasks:
            out.append(work(*one))
            shares.one_done()
        return out
    with ProcessPoolExecutor(min(workers, len(tasks)), mp_context=get_context("spawn")) as pool:
        running = [pool.submit(work, *one) for one in tasks]
        try:
            for future in running:
                out.append(future.result())
                shares.one_done()
        finally:
            pool.shutdown(wait=True, cancel_futures=True)
    return out
