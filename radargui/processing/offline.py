"""A whole recording to its result."""

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache, partial

import numpy as np
from threadpoolctl import ThreadpoolController

from radargui.conditioning.condition import condition
from radargui.conditioning.conditioned import Conditioned
from radargui.conditioning.stretch import NoMotion
from radargui.correction.correct import correct
from radargui.geometry.path_length import LEAST_RECEIVERS
from radargui.model.arrays import FloatArray
from radargui.model.calibrated_setup import edited_since
from radargui.model.errors import ProcessingError, worded
from radargui.model.front_end import FrontEndPrior
from radargui.model.gravity import drag_of_sphere_1_m
from radargui.model.recording import Recording
from radargui.model.result import Bounces, CorrectedIQ, PathLengths, Quality, RunResult, Segment, Track
from radargui.model.setup import Setup
from radargui.processing.continuity import checked, is_alone, known_where, lay_down
from radargui.processing.locate import locate_body
from radargui.processing.long_recording import shortened
from radargui.processing.measured_motion import MeasuredMotion, nothing_measured
from radargui.processing.part import Part
from radargui.processing.setup_doubts import contradicted, misplaced, unlikely, wired_wrongly, without_room
from radargui.processing.uncertainty_budget import changes_of_track, with_budget
from radargui.processing.whole import Whole
from radargui.restitution.bent_flights import without_guess, without_places
from radargui.restitution.bounces import find_bounces
from radargui.restitution.cross_check import disagreements, floor_and_wall, found_tilt, walls_met
from radargui.restitution.impact_plane import judged_by_floor
from radargui.restitution.site_gravity import with_missed_gravity
from radargui.restitution.stopped_fall import braked_without_impact

ESTIMATES = ("adaptive", "joint")

Progress = Callable[[float], None]
OnPreliminary = Callable[[RunResult], None]

STOPPED = "the joint correction was stopped before it ended: the adaptive one stands"

BRAKED = (
    "the flights are braked more than a metal sphere is (drag k = {drag:.2g} 1/m): e and g are uncertain by what that "
    "makes of them; give the sphere's density (density_kg_m3), or use the joint correction, which finds k"
)
NO_REST = (
    "there is no rest before the motion: the track is laid so that it begins at the release position, "
    "which is an assumption, and no coefficient rests on it"
)
PLANE = (
    "plane geometry takes the antennas as infinitely far away: no uncertainty has what that does to position, e and g"
)
NOWHERE = "the receivers stand so that their path lengths tell no position: set them apart, or correct their places"
NO_REST_AFTER_GAP = "the motion begins right after lost samples: where the sphere was then is not known"


def process(
    recording: Recording,
    setup: Setup,
    progress: Progress | None = None,
    on_preliminary: OnPreliminary | None = None,
    front_ends: FrontEndPrior | None = None,
) -> RunResult:
    """Turn the samples of one run into path lengths, track, bounces and g.

    Parameters
    ----------
    recording
        Raw samples; as many IQ pairs as the setup has receivers.
    setup
        Geometry, correction, release position.
    progress
        Called with the share done, 0 to 1; what it raises, as `CancelledError`, ends the work.
    on_preliminary
        Given the preliminary result of the adaptive correction while the joint one is being computed.
    front_ends
        What other runs say about the front ends, prior of the joint correction; None: nothing, the run speaks for
        itself.

    Returns
    -------
    RunResult
        status ok, no_motion or rejected; arrays have one column a stored sample, NaN where unknown. Of a long
        recording its `recording` is the excerpt around a motion, to which all arrays belong.

    Raises
    ------
    ProcessingError
        The recording does not fit the setup, or holds no samples.
    """
    # the matrices are many and small: threads of the linear algebra cost several times what they save
    with _linear_algebra().limit(limits=1, user_api="blas"):
        _check(recording, setup)
        # an hour of rest says nothing that its last seconds do not
        recording = shortened(recording)
        report = progress or (lambda _: None)
        warnings = _warnings_before(recording, setup)
        conditioned = condition(recording, setup)
        # an answer, not a failure: a plate that hangs still is measured too
        if isinstance(conditioned, NoMotion):
            return RunResult(recording, setup, "no_motion", conditioned.reason, warnings=tuple(warnings))
        no_room = without_room(conditioned, recording.digitisation)
        warnings += no_room
        report(0.1)
        # a dead, doubled or exchanged channel is no receiver: its neighbours must not be corrected together with it
        faults, clock = wired_wrongly(conditioned, setup)
        warnings += [clock] if clock else []
        part = Part(setup, conditioned, faults, has_room=not no_room)
        motion = _measure(recording, part, report, on_preliminary, front_ends, warnings)
        # one at a time may reject another: without a bad receiver its neighbours are judged anew
        while failed := _left_out(part, motion):
            part = part.without(failed)
            motion = _measure(recording, part, report, on_preliminary, front_ends, warnings)
        report(0.9)
        return _result(recording, part, motion, warnings)


@cache
def _linear_algebra() -> ThreadpoolController:
    """Return what sets the number of threads of the libraries that are loaded; to find these takes milliseconds."""
    return ThreadpoolController()


def steps_of(result: RunResult) -> tuple[object, ...]:
    """Return what the correction of a result found on its way (`CorrectedIQ.steps`), found again in its samples."""
    corrected = result.corrected
    if corrected is None or corrected.method in ESTIMATES:
        return ()
    conditioned = condition(result.recording, result.setup)
    if isinstance(conditioned, NoMotion):
        return ()
    part = Part(result.setup, conditioned, wired_wrongly(conditioned, result.setup)[0])
    whole = Whole(result.recording, part.conditioned, part.receivers)
    again, _ = correct(part.conditioned, corrected.method)
    return whole.steps(again.steps)


def cut_short(result: RunResult) -> RunResult:
    """Return a preliminary result as it is kept where the joint correction was stopped."""
    return replace(result, warnings=(STOPPED, *result.warnings))


def _result(recording: Recording, part: Part, motion: MeasuredMotion, before: list[str]) -> RunResult:
    """Return what was measured, with bounces, verdicts and warnings; those of `before` come first."""
    setup, conditioned = part.setup, part.conditioned
    rate_hz, segment = conditioned.sample_rate_hz, conditioned.segment
    whole = Whole(recording, conditioned, part.receivers)
    channels, paths, track = whole.channels(motion.corrected, part.faults), motion.paths, motion.track
    warnings = [*before, *motion.warnings]
    # every rejected receiver refuses the run, for the track needs all of them, unless it goes on without
    reasons = {k: c.reason for k, c in enumerate(channels) if c.verdict == "rejected"}
    # what is no receiver first: without it, its neighbours are hard to judge
    left_out = {number: reasons.pop(number) for number, fault in enumerate(part.faults) if fault}
    if part.goes_on_without:
        warnings += [f"receiver {k + 1}: {reason}: the others go on without it" for k, reason in left_out.items()]
        left_out = {}
    rejected = said_once(left_out | reasons)
    if rejected:
        # rejected means rejected: no sample of it is called valid
        paths = replace(paths, valid=np.zeros_like(paths.valid))
        track = None if track is None else replace(track, valid=np.zeros_like(track.valid))
    if track is not None and not rejected and track.geometry == "plane":
        warnings.append(PLANE)
    known = paths.valid.all(axis=0)
    if track is not None and known.any() and not (known & np.isfinite(track.u_position_m)).any():
        warnings.append(NOWHERE)
    if track is not None and not segment.has_rest:
        # with a gap before it even the release is no assumption that one could make
        after_gap = conditioned.samples.start > 0
        warnings.append(NO_REST_AFTER_GAP if after_gap else NO_REST)
        if after_gap:
            track = known_where(track, np.zeros_like(track.valid))
    bounces, budget, corrected = Bounces(), None, motion.corrected
    if track is not None and not rejected:
        # the joint estimate knows the speeds at an impact from all samples; a track has them from its flights
        bounces = motion.bounces or _bounces_of(track, segment, setup, rate_hz)
        # without a rest the zero of L is assumed: no uncertainty of a calibration means anything then
        if segment.has_rest:
            changes = motion.changes
            if changes is None:
                changes = changes_of_track(motion.paths, bounces, setup, segment)
            if motion.bounces is None:
                bounces = with_missed_gravity(bounces, setup, math.hypot(*(one.g_m_s2 for one in changes)))
            track, bounces, budget = with_budget(track, bounces, changes, segment, setup)
        else:
            # where the sphere was at the start is assumed, not known: no e, and no g
            bounces = Bounces(tuple(replace(impact, valid=False) for impact in bounces.impacts))
        alike_m = None if motion.bounces is None else setup.radar.wavelength_m / (4.0 * np.pi)
        bounces, floor = judged_by_floor(bounces, track, alike_m, by_conic=corrected.method in ("ellipse", "none"))
        elsewhere = contradicted(setup, rate_hz, track, bounces, budget)
        # a cause that is named takes the place of the guess
        if misplaced(setup):
            warnings = without_places(warnings)
        if elsewhere or misplaced(setup) or not part.has_room:
            warnings = without_guess(warnings)
        warnings += elsewhere
        warnings += disagreements(bounces) + floor_and_wall(bounces) + floor + braked_without_impact(bounces, track)
        if bounces.braked_1_m is not None:
            warnings.append(BRAKED.format(drag=bounces.braked_1_m))
        corrected = replace(corrected, decisions=(*corrected.decisions, *found_tilt(bounces), *walls_met(bounces)))
    usable = {number: channel.reason for number, channel in enumerate(channels) if channel.verdict == "usable"}
    warnings += said_once(usable, "usable")
    return RunResult(
        recording,
        part.whole_setup,
        status="rejected" if rejected else "ok",
        reason="; ".join(rejected),
        segment=whole.segment(segment),
        corrected=partial(whole.corrected, corrected, channels),
        paths=partial(whole.paths, paths),
        track=None if track is None else partial(whole.track, track),
        bounces=bounces,
        uncertainty_budget=budget,
        warnings=tuple(warnings),
        front_end_prior=motion.front_end_prior,
        reported_quality=Quality(motion.corrected.method, channels),
    )


def said_once(reasons: Mapping[int, str], verdict: str = "") -> list[str]:
    """Return each reason once, with the receivers, counted from 0, that have it, and what they are by it."""
    said = []
    for why in dict.fromkeys(reasons.values()):
        *others, last = (str(number + 1) for number, one in reasons.items() if one == why)
        who, are = (f"receivers {', '.join(others)} and {last}", "are") if others else (f"receiver {last}", "is")
        said.append(f"{who} {are} {verdict}: {why}" if verdict else f"{who}: {why}")
    return said


def _left_out(part: Part, motion: MeasuredMotion) -> dict[int, str]:
    """Return why receivers are left out that the correction rejected, where enough others remain; else nothing.

    A correction of each receiver by itself that fails in one says little good of it in the others: they may leave the
    circle by a third and be `usable`. Unless all of them are good the run is refused.
    """
    verdicts = {channel.verdict for channel in motion.corrected.channels}
    if motion.corrected.method not in ("adaptive", "joint") and "usable" in verdicts:
        return {}
    channels = zip(part.receivers, motion.corrected.channels, strict=True)
    faults = {number: channel.reason for number, channel in channels if channel.verdict == "rejected"}
    return faults if len(part.receivers) - len(faults) >= LEAST_RECEIVERS else {}


def _measure(
    recording: Recording,
    part: Part,
    report: Progress,
    on_preliminary: OnPreliminary | None,
    front_ends: FrontEndPrior | None,
    warnings: list[str],
) -> MeasuredMotion:
    """Measure the motion by the chosen correction; where an estimate cannot be made the published procedure stands."""
    conditioned, setup = part.conditioned, part.setup
    method = setup.processing.correction
    if not part.receivers:
        return nothing_measured(conditioned, method)
    if part.is_too_small:
        # the run is rejected: of the others only their quality is reported, and in a moment
        return measure_by_receiver(conditioned, setup, "ellipse", report)

    def progress(done: float) -> None:
        report(0.1 + 0.8 * done)

    def preliminary(motion: MeasuredMotion) -> None:
        if on_preliminary is not None:
            on_preliminary(replace(_result(recording, part, motion, warnings), preliminary=True))

    if method not in ESTIMATES:
        return measure_by_receiver(conditioned, setup, method, progress)
    # only who asks for an estimate pays for loading it
    from radargui.processing.by_estimate import measure_by_estimate

    prior = None if front_ends is None else part.prior(front_ends)
    try:
        return measure_by_estimate(conditioned, setup, progress, preliminary, prior)
    except ProcessingError as error:
        # it needs no model of the motion but fringes
        motion = measure_by_receiver(conditioned, setup, "published", progress)
        why = error.message.rstrip(".")
        sentence = f"the {method} correction cannot be made ({why}): the published one was used"
        return replace(motion, warnings=(sentence,))


def _bounces_of(track: Track, segment: Segment, setup: Setup, rate_hz: float) -> Bounces:
    # a normal that is a default is no statement about this floor
    given = "normal" in setup.floor.model_fields_set
    normal = setup.floor.normal if given else None
    drag_1_m = drag_of_sphere_1_m(setup.tracer.diameter_m, setup.tracer.density_kg_m3)
    is_known = setup.tracer.density_kg_m3 is not None
    return find_bounces(track, segment, normal, rate_hz, setup.floor.u_tilt_deg, drag_1_m, is_drag_known=is_known)


def _check(recording: Recording, setup: Setup) -> None:
    # a pair too many or too few would give every receiver another one's geometry
    if recording.n_receivers != setup.n_receivers or len(recording.digitisation.channel_names) % 2:
        names = ", ".join(recording.digitisation.channel_names)
        n, n_channels = setup.n_receivers, recording.digitisation.n_channels
        facts = {"n_channels": n_channels, "names": names, "receivers": n, "needed": 2 * n}
        raise worded(ProcessingError, "pairs_to_process", name=recording.name, **facts)
    if recording.n_samples == 0:
        raise ProcessingError(f"{recording.name} holds no samples", reasons=["the recording ended before it began"])


def _warnings_before(recording: Recording, setup: Setup) -> list[str]:
    warnings = []
    if recording.excerpt is not None:
        warnings.append(recording.excerpt.reason)
    if recording.raw.dtype != np.int16:
        # taken for clipped further on: neither is a voltage
        for name, row in zip(recording.digitisation.channel_names, recording.raw, strict=True):
            if missing := int(row.size - np.isfinite(row).sum()):
                samples = "all samples are" if missing == row.size else f"{missing} of {row.size} samples are"
                warnings.append(f"{name}: {samples} no numbers, and left out")
    if recording.gaps:
        lost, many = sum(gap.count for gap in recording.gaps), len(recording.gaps)
        warnings.append(
            f"{lost} samples of each channel were lost in {many} gap{'s' if many > 1 else ''}: only one stretch "
            "between gaps is used, nothing is computed across a gap"
        )
    # only changes of path are measured: the release position is where the track is laid
    if setup.n_receivers >= LEAST_RECEIVERS and "release_position_m" not in setup.tracer.model_fields_set:
        place = ", ".join(f"{x:g}" for x in setup.tracer.release_position_m)
        warnings.append(f"the setup gives no tracer.release_position_m: ({place}) m is assumed")
    warnings += unlikely(setup)
    if edited := edited_since(setup):
        warnings.append(edited)
    return warnings


def measure_by_receiver(
    conditioned: Conditioned, setup: Setup, method: str, progress: Callable[[float], None]
) -> MeasuredMotion:
    """Return corrected IQ, path lengths and track by the published, the ellipse or no correction.

    Parameters
    ----------
    conditioned
        Signals, motion, noise.
    setup
        Geometry, wavelength, release position.
    method
        published, ellipse or none.
    progress
        Called with the share done, 0 to 1.
    """
    corrected, phase = correct(conditioned, method, lambda done: progress(0.7 * done))
    paths = demodulate(corrected, phase, conditioned, setup.radar.wavelength_m)
    progress(0.8)
    paths, track = locate_body(paths, setup)
    return checked(MeasuredMotion(corrected, paths, track), conditioned, setup.radar.wavelength_m)


def demodulate(
    corrected: CorrectedIQ, phase_rad: FloatArray, conditioned: Conditioned, wavelength_m: float
) -> PathLengths:
    """Return dL_i = phase_i wavelength / (2 pi), 0 in the mean at rest (Rech & Huang 2019, eq. 1).

    Without a rest the first valid sample is 0. Of one or two receivers `checked` does it, piece by piece.

    Parameters
    ----------
    corrected
        Corrected IQ of all receivers, the wiring's sign applied: moving away raises every phase.
    phase_rad
        Unwrapped, shape (n_receivers, n_samples); NaN where not valid.
    conditioned
        What it was corrected from: rest, rate.
    wavelength_m
        Of the transmitted wave.
    """
    if not is_alone(conditioned):
        # only changes of L are observable: the rest before the motion is their zero (method 1)
        rest = slice(conditioned.segment.rest_first, conditioned.segment.rest_last)
        phase_rad = lay_down(phase_rad, corrected.valid, np.zeros(conditioned.n_samples, dtype=np.intp), rest)
    per_rad = wavelength_m / (2.0 * np.pi)
    change_m, u_m = phase_rad * per_rad, corrected.u_phase_rad * per_rad
    return PathLengths(corrected.time_s, phase_rad, change_m, u_m, corrected.valid)
