"""A calibration from recordings and what is known of their motions."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from radargui import __version__
from radargui.calibration.fit import Fit, fit
from radargui.calibration.known_path import Trajectory
from radargui.calibration.likelihood import Likelihood, PathLikelihood, World
from radargui.calibration.preparing import Prepared, prepare_fall, prepare_known, sample_problem
from radargui.calibration.shares import Progress, Shares, crew, working
from radargui.calibration.signal_likelihood import SignalLikelihood
from radargui.calibration.unknowns import (
    POLARISATION,
    USUAL,
    antenna_unknowns,
    fall_unknowns,
    place_unknowns,
    setup_with,
    with_polarisations,
)
from radargui.calibration.verdict import (
    FAR,
    GAIN,
    LEFT_M,
    LOOSE,
    MISFIT_M,
    MOST_COMPARED,
    Slip,
    fit_paths,
    left_out,
    other_orders,
    put_right,
    rms_m,
    undecidable,
    untold,
)
from radargui.calibration.wall_search import approach, with_walls
from radargui.model.arrays import FloatArray
from radargui.model.calibration import Calibration, Origin, Residual
from radargui.model.errors import ProcessingError
from radargui.model.recording import Recording
from radargui.model.setup import Setup

RELEASE = "tracer.release_position_m"
CONTRADICTION = 3.0
"""Birge ratio beyond which u would have to be widened so much that it means nothing: circles beside strong walls had
4.9 and were up to 4 of the widened u off, sound ones 1.2 to 2.3. Chosen by hand."""
MOST_SLIPS = 2
"""Lost fringes a recording that are put right: one with more is none to calibrate by."""
FEW_STEPS = 12
"""Of a fit that is only compared with others."""


@dataclass(frozen=True)
class KnownRecording:
    """A recording and what is known of its motion.

    Attributes
    ----------
    recording
        Samples.
    name
        For people, each its own.
    checksum
        SHA-256 of the file.
    trajectory
        None: it is a fall.
    release_m
        Where the sphere hung before a fall, as stated.
    """

    recording: Recording
    name: str
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
        A recording does not fit what is known of it: swapped receivers, a mirror image, no overlap.
    """
    shares = Shares(progress, len(recordings))
    with working(min(workers, len(recordings)), shares.look):
        found = _calibrated(recordings, setup, groups, shares, (made_at, operator))
    progress(1.0)
    return found


def _calibrated(
    recordings: Sequence[KnownRecording], setup: Setup, groups: Sequence[str], shares: Shares, origin: tuple[str, str]
) -> Calibrated:
    polarised = "polarization" in groups
    setup = with_polarisations(setup) if polarised else setup
    world, places = _world(setup, recordings, place="transmitter" in groups, polarised=polarised)
    held = np.array([bool(one.group) and one.group not in groups for one in world.unknowns])
    tasks = [(one, _hung(setup, one.rest_m), place) for one, place in zip(recordings, places, strict=True)]
    prepared = crew().each(_prepare, tasks, shares.one_done)
    wavelength_m, is_plane = setup.radar.wavelength_m, setup.processing.geometry == "plane"
    by_paths = [PathLikelihood(ready.measured, ready.motion, wavelength_m, is_plane) for ready in prepared]
    rough = fit_paths(world, by_paths, held, shares.round_done)
    slips: list[Slip] = []
    while len(slips) <= MOST_SLIPS * len(recordings):
        by_paths, more = put_right(rough, by_paths)
        if not more:
            break
        slips += more
        rough = fit_paths(world, by_paths, held, shares.round_done)
    _refuse_misfit(rough, recordings, prepared, shares.round_done)
    before = fit_paths(world, by_paths, np.array([bool(one.key) for one in world.unknowns]), shares.round_done)
    likelihoods, own = _sharpened(rough, by_paths, prepared, setup)
    settled = approach(world, likelihoods, rough, own, shares.round_done)
    settled = with_walls(settled, np.asarray(setup.floor.normal), shares.round_done)
    found = fit(
        world, settled.likelihoods, held=held, start=settled.found, own=settled.found.own, round_done=shares.round_done
    )
    if not np.isfinite(found.information()[0]).all():
        raise ProcessingError(
            "the samples do not agree with what is known of the motions, whatever the antennas",
            reasons=("a wall or another body bends the paths", "one recording alone tells too little"),
            remedy="Give more recordings, from other places.",
        )
    _refuse_above(LEFT_M, found, recordings)
    calibration = _calibration(found, before, settled.likelihoods, recordings, *origin)
    lost = tuple(
        f"{recordings[number].name}: receiver {receiver + 1} lost a fringe near {time_s:.3f} s, put right"
        for number, receiver, time_s in slips
    )
    alike = tuple(f"these motions cannot tell whether {words}" for words in undecidable(rough, by_paths))
    calibration = replace(calibration, notes=calibration.notes + lost + alike)
    return Calibrated(calibration, calibrated_setup(setup, found, calibration), found)


def _prepare(one: KnownRecording, setup: Setup, place: str) -> Prepared:
    if one.trajectory is None:
        return prepare_fall(one.recording, setup, place)
    return prepare_known(one.recording, setup, one.trajectory)


def _sharpened(
    rough: Fit, by_paths: Sequence[PathLikelihood], prepared: Sequence[Prepared], setup: Setup
) -> tuple[list[Likelihood], list[FloatArray]]:
    """Return the likelihoods by samples where there is a rest, else by paths of honest weight, and starts."""
    values = rough.world.values(rough.z)
    better = setup_with(setup, rough.world.unknowns, values)
    out: list[Likelihood] = []
    starts = []
    for path, ready, state, local in zip(by_paths, prepared, rough.own, rough.locals_, strict=True):
        unknowns = ready.motion.own
        shift = state[: len(unknowns)]
        own = np.array([one.value + one.u * float(z) for one, z in zip(unknowns, shift, strict=True)])
        begun = None if path.is_plane else sample_problem(ready, better, values, own)
        if begun is None:
            # neighbours share their error: one value counts for a quarter of a fringe
            turns = float(
                np.nanmax(np.nanmax(path.measured.change_m, axis=1) - np.nanmin(path.measured.change_m, axis=1))
            )
            crowd = max(1.0, path.measured.time_s.size / (4.0 * max(turns / path.wavelength_m, 1.0)))
            u_m = float(max(rms_m(local.residual_m).max(), 1e-5) * np.sqrt(crowd))
            out.append(replace(path, measured=replace(path.measured, u_m=u_m)))
            starts.append(state)
            continue
        out.append(SignalLikelihood(begun.problem, begun.state.theta, ready.motion))
        starts.append(np.concatenate([shift, np.zeros(begun.state.theta.size)]))
    return out, starts


def _world(
    setup: Setup, recordings: Sequence[KnownRecording], *, place: bool = False, polarised: bool = False
) -> tuple[World, list[str]]:
    """Return the shared unknowns, and the name of each recording's place (empty: a known motion)."""
    unknowns = antenna_unknowns(setup, place=place, polarised=polarised)
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


def _refuse_misfit(
    rough: Fit, recordings: Sequence[KnownRecording], prepared: Sequence[Prepared], round_done: Callable[[], None]
) -> None:
    """Say why paths do not fit what is known; nothing where they do.

    Raises
    ------
    ProcessingError
        Swapped receivers, a mirror image, or another motion.
    """
    worst = max(float(np.nanmax(rms_m(one.residual_m))) for one in rough.locals_)
    antennas = np.array([bool(one.key) for one in rough.world.unknowns])
    if worst < MISFIT_M and np.abs(rough.z[antennas]).max(initial=0.0) < FAR:
        return
    stride = max(1, len(recordings) // MOST_COMPARED)
    some = list(zip(recordings, prepared, strict=True))[::stride][:MOST_COMPARED]

    def cost(setup: Setup) -> float:
        world, _ = _world(setup, [one for one, _ in some])
        # a known motion's paths were measured against the phases of the antennas as they were said to be
        ready = [
            was if one.trajectory is None else prepare_known(one.recording, _hung(setup, one.rest_m), one.trajectory)
            for one, was in some
        ]
        paths = [PathLikelihood(one.measured, one.motion, setup.radar.wavelength_m) for one in ready]
        held = np.zeros(len(world.unknowns), dtype=bool)
        return fit_paths(world, paths, held, round_done, LOOSE[:2], FEW_STEPS).cost

    setup = rough.world.setup
    plain, tried = cost(setup), [(cost(other), words) for words, other in other_orders(setup)]
    least, words = min(tried)
    if least < plain - GAIN:
        raise ProcessingError(
            f"the recordings do not fit the setup, but they do where {words}",
            remedy="Correct the wiring, or the order and azimuths of the receivers in the setup.",
        )
    _refuse_above(MISFIT_M, rough, recordings)


def _refuse_above(most_m: float, found: Fit, recordings: Sequence[KnownRecording]) -> None:
    """Say which recording is no motion as stated; nothing where all are."""
    rms = [float(np.nanmax(rms_m(one.residual_m))) for one in found.locals_]
    number = int(np.argmax(rms))
    if rms[number] >= most_m:
        known = recordings[number].trajectory
        raise ProcessingError(
            f"{recordings[number].name}: its paths are {1e3 * rms[number]:.1f} mm off what is known of its motion "
            f"({'fall' if known is None else known.words}), whatever the antennas",
            reasons=(
                "it was pushed as it left" if known is None else "it belongs to another path file",
                "a wall or another body bends its paths",
                "the antennas are farther off than the setup's u says",
            ),
            remedy="Leave this recording out, or state larger u.",
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
    if found.birge() > CONTRADICTION:
        verdict = "refused"
        reason = (
            f"the recordings contradict each other {found.birge():.1f} times more than each says of itself: a wall "
            "close to the motion reflects, or a motion was not as stated"
        )
    far = [unknowns[n].name for n in kept if abs(found.z[n]) > FAR]
    if far:
        verdict = "refused"
        reason = (
            f"{', '.join(far)} would be more than {FAR:g} of its u away from the setup: that u is too small, or a wall "
            "or another motion than stated bends the paths"
        )
    residuals = []
    alone = left_out(found, likelihoods)
    for one, now, then, other in zip(recordings, found.locals_, before.locals_, alone, strict=True):
        for n, (a, b, c) in enumerate(zip(rms_m(now.residual_m), rms_m(then.residual_m), other, strict=True), 1):
            residuals.append(Residual(one.name, n, float(a), float(b), float(c)))
    names = tuple(unknowns[n].name for n in kept)
    known = tuple("fall" if one.trajectory is None else one.trajectory.words for one in recordings)
    files = {one.name: one.checksum for one in recordings}
    notes = (f"condition number {condition_number:.3g}", f"u widened by {found.birge():.2f} (Birge ratio)")
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
    apart = [u[name] for name in u if name.startswith(("transmitter.distance", "transmitter.position"))]
    if apart:
        sender = sender.model_copy(update={"u_distance_m": max(apart)})
    if f"transmitter.{POLARISATION}" in u:
        sender = sender.model_copy(update={f"u_{POLARISATION}": u[f"transmitter.{POLARISATION}"]})
    receivers = []
    for n, one in enumerate(setup.receiver, 1):
        own = {f"u_{key}": u[f"receiver.{n}.{key}"] for key in ("tilt_deg", "azimuth_deg", "distance_m", POLARISATION)
               if f"receiver.{n}.{key}" in u}  # fmt: skip
        receivers.append(one.model_copy(update=own))
    tracer = setup.tracer
    if f"{RELEASE}.x" in values:
        place = tuple(values[f"{RELEASE}.{axis}"] for axis in "xyz")
        u_place = max(u[f"{RELEASE}.{axis}"] for axis in "xyz")
        tracer = tracer.model_copy(update={"release_position_m": place, "u_release_m": u_place})
    return setup.model_copy(update={"transmitter": sender, "receiver": tuple(receivers), "tracer": tracer})


def _hung(setup: Setup, place: Sequence[float]) -> Setup:
    """Return the setup with the sphere hanging at a place."""
    return setup.model_copy(update={"tracer": setup.tracer.model_copy(update={"release_position_m": tuple(place)})})
