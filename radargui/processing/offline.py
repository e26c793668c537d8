"""A whole recording to its result."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from radargui.model.bounce import Bounces
from radargui.model.errors import ProcessingError
from radargui.model.front_end import FrontEndPrior
from radargui.model.recording import Recording
from radargui.model.result import RunResult
from radargui.model.segment import Segment
from radargui.model.setup import Setup
from radargui.model.track import Track
from radargui.motion.segment import find_segment
from radargui.processing.calibration_uncertainty import calibration_uncertainty
from radargui.processing.locate import LEAST_RECEIVERS
from radargui.processing.long_recording import shortened
from radargui.processing.road import Road
from radargui.processing.step_by_step import corrected_by_steps, step_by_step
from radargui.processing.stretch import stretches
from radargui.processing.whole import Whole
from radargui.restitution.bounces import find_bounces
from radargui.restitution.cross_check import disagreements

ESTIMATES = ("adaptive", "joint")

Progress = Callable[[float], None]
Standing = Callable[[RunResult], None]

STOPPED = "the joint correction was stopped before it ended: the adaptive one stands"

NO_REST = (
    "there is no rest before the motion: the track is laid so that it begins at the release position, "
    "which is an assumption, and no coefficient rests on it"
)
NO_REST_AFTER_GAP = "the motion begins right after lost samples: where the sphere was then is not known"


def process(
    recording: Recording,
    setup: Setup,
    progress: Progress | None = None,
    standing: Standing | None = None,
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
    standing
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
    _check(recording, setup)
    recording = shortened(recording)
    tell = progress or (lambda _: None)
    warnings = _warnings_before(recording, setup)
    stretch, segment = _stretch_with_motion(recording)
    if segment is None:
        return RunResult(
            recording, setup, "no_motion", "the voltages do not move more than their noise", warnings=tuple(warnings)
        )
    tell(0.1)

    def result_of(road: Road) -> RunResult:
        return _result(recording, setup, stretch, segment, road, warnings)

    stands = None if standing is None else lambda road: standing(replace(result_of(road), preliminary=True))
    road = _road(_part(recording, stretch), segment, setup, lambda done: tell(0.1 + 0.8 * done), stands, front_ends)
    tell(0.9)
    return result_of(road)


def steps_of(result: RunResult) -> tuple[object, ...]:
    """Return what the correction of a result found on its way (`CorrectedIQ.steps`), found again in its samples."""
    recording, segment, corrected = result.recording, result.segment, result.corrected
    if corrected is None or segment is None or corrected.method in ESTIMATES:
        return ()
    stretch = next(one for one in stretches(recording) if one.start <= segment.first < one.stop)
    inside = segment.counted_from(stretch.start)
    found = corrected_by_steps(_part(recording, stretch), inside, corrected.method, lambda _: None)
    return Whole(recording, stretch).corrected(found).steps


def cut_short(result: RunResult) -> RunResult:
    """Return a preliminary result as it is kept where the joint correction was stopped."""
    return replace(result, warnings=(STOPPED, *result.warnings))


def _result(
    recording: Recording, setup: Setup, stretch: slice, segment: Segment, road: Road, before: list[str]
) -> RunResult:
    """Return what a road gave, with bounces, verdicts and warnings; those of `before` come first."""
    rate_hz = recording.digitisation.sample_rate_hz
    corrected, paths, track = road.corrected, road.paths, road.track
    warnings = [*before, *road.warnings]
    rejected = [
        f"receiver {channel.name}: {channel.reason}" for channel in corrected.channels if channel.verdict == "rejected"
    ]
    if track is not None and not segment.has_rest:
        warnings.append(NO_REST_AFTER_GAP if stretch.start else NO_REST)
        if stretch.start:
            track = _unknown(track)
    bounces, calibration = Bounces(), None
    if track is not None and not rejected:
        bounces = _bounces_of(track, segment, setup, rate_hz) if road.bounces is None else road.bounces
        if segment.has_rest:
            calibration = calibration_uncertainty(paths, setup, segment, _bounces_of, rate_hz, road.shift)
        else:
            bounces = _unsupported(bounces)
        warnings += disagreements(bounces)
    if stretch != slice(0, recording.n_samples):
        whole = Whole(recording, stretch)
        corrected, paths, segment = whole.corrected(corrected), whole.paths(paths), whole.segment(segment)
        track = None if track is None else whole.track(track)
    warnings += [
        f"receiver {channel.name} is {channel.verdict}: {channel.reason}"
        for channel in corrected.channels
        if channel.verdict == "usable"
    ]
    return RunResult(
        recording,
        setup,
        status="rejected" if rejected else "ok",
        reason="; ".join(rejected),
        segment=segment,
        corrected=corrected,
        paths=paths,
        track=track,
        bounces=bounces,
        calibration_uncertainty=calibration,
        warnings=tuple(warnings),
        front_end_prior=road.front_end_prior,
    )


def _part(recording: Recording, stretch: slice) -> Recording:
    """Return the recording of a gapless stretch, at its own times."""
    if stretch == slice(0, recording.n_samples):
        return recording
    return replace(
        recording,
        raw=recording.raw[:, stretch],
        gaps=(),
        file_time_s=recording.time_s()[stretch],
        trigger_index=None,
        excerpt=None,
    )


def _road(
    recording: Recording,
    segment: Segment,
    setup: Setup,
    tell: Progress,
    standing: Callable[[Road], None] | None,
    front_ends: FrontEndPrior | None,
) -> Road:
    """Take the road of the chosen correction; where an estimate cannot be made the published procedure stands."""
    method = setup.processing.correction
    if method not in ESTIMATES:
        return step_by_step(recording, segment, setup, method, tell)
    # only who asks for an estimate pays for loading it
    from radargui.processing.estimated import estimated

    try:
        return estimated(recording, segment, setup, method, tell, standing, front_ends)
    except ProcessingError as error:
        road = step_by_step(recording, segment, setup, "published", tell)
        why = error.message.rstrip(".")
        return replace(road, warnings=(f"the {method} correction cannot be made ({why}): the published one was used",))


def _bounces_of(track: Track, segment: Segment, setup: Setup, rate_hz: float) -> Bounces:
    given = "normal" in setup.floor.model_fields_set
    return find_bounces(track, segment, setup.floor.normal if given else None, rate_hz)


def _check(recording: Recording, setup: Setup) -> None:
    if recording.n_receivers != setup.n_receivers or len(recording.digitisation.channel_names) % 2:
        names = ", ".join(recording.digitisation.channel_names)
        raise ProcessingError(
            f"{recording.name} has {len(recording.digitisation.channel_names)} channels ({names}), the setup has "
            f"{setup.n_receivers} receivers, which need {2 * setup.n_receivers}",
            remedy="Give a setup with as many receivers as the recording has IQ pairs.",
        )
    if recording.n_samples == 0:
        raise ProcessingError(f"{recording.name} holds no samples", reasons=["the recording ended before it began"])


def _stretch_with_motion(recording: Recording) -> tuple[slice, Segment | None]:
    """Return the gapless stretch to use, and the motion within it.

    One with a rest before the motion comes first, for there it is known where the sphere was; then the longest motion.
    """
    volts = recording.volts()
    moving = [
        (stretch, segment)
        for stretch in stretches(recording)
        if (segment := find_segment(volts[:, stretch], recording.digitisation.sample_rate_hz)) is not None
    ]
    if not moving:
        return slice(0, recording.n_samples), None
    return max(moving, key=lambda found: (found[1].has_rest, found[1].last - found[1].first))


def _warnings_before(recording: Recording, setup: Setup) -> list[str]:
    warnings = []
    if recording.excerpt is not None:
        warnings.append(recording.excerpt.reason)
    if recording.gaps:
        lost, many = sum(gap.count for gap in recording.gaps), len(recording.gaps)
        warnings.append(
            f"{lost} samples of each channel were lost in {many} gap{'s' if many > 1 else ''}: only one stretch "
            "between gaps is used, nothing is computed across a gap"
        )
    if setup.n_receivers >= LEAST_RECEIVERS and "release_position_m" not in setup.tracer.model_fields_set:
        place = ", ".join(f"{x:g}" for x in setup.tracer.release_position_m)
        warnings.append(f"the setup gives no tracer.release_position_m: ({place}) m is assumed")
    return warnings


def _unknown(track: Track) -> Track:
    nowhere = np.full_like(track.position_m, np.nan)
    return replace(track, position_m=nowhere, u_position_m=nowhere, valid=np.zeros_like(track.valid))


def _unsupported(bounces: Bounces) -> Bounces:
    """Return the impacts as not valid and no g: where the sphere was at the start is assumed, not known."""
    return Bounces(tuple(replace(impact, valid=False) for impact in bounces.impacts), None)
