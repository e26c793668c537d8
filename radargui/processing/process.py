"""A whole recording to its result, step by step (method 2 to 6).

Several motions in one record, each from its rest: a drop, the hand that carries the sphere back, the next drop. The way
of the corrections of each receiver by itself: its phase, its path lengths, the place of the body.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from radargui.correction.correct import correct
from radargui.model.arrays import FloatArray
from radargui.model.channel_quality import unexplained_of
from radargui.model.errors import ProcessingError, worded
from radargui.model.finding import Finding, warn, why_of
from radargui.model.front_end import FrontEndPrior
from radargui.model.gravity import expected_gravity_m_s2
from radargui.model.recording import Recording
from radargui.model.result import CorrectedIQ, PathLengths, Quality, RunResult
from radargui.model.setup import Setup
from radargui.model.setup_pool import SetupPrior
from radargui.model.uncertainty_budget import BudgetLine
from radargui.physics.path_length import MIN_RECEIVERS
from radargui.processing.checks.evidence import Evidence, Part
from radargui.processing.checks.run import findings_before, findings_of
from radargui.processing.continuity import checked, is_alone, known_where, lay_down
from radargui.processing.impacts_of_track import impacts_of_track
from radargui.processing.long_recording import shortened
from radargui.processing.measured_motion import MeasuredMotion, Progress, Report, locate_body, nothing_measured
from radargui.processing.whole import Whole
from radargui.restitution.cross_check import found_tilt, walls_met
from radargui.restitution.impact_plane import judged_by_floor
from radargui.signals.conditioned import Conditioned
from radargui.signals.motions import motions_of
from radargui.signals.stretch import NoMotion
from radargui.system.cores import one_blas_thread

if TYPE_CHECKING:
    # only who asks for flights pays for loading them
    from radargui.processing.by_flights import MeasuredDrop

    _Flown = tuple[Part, MeasuredDrop | Finding | None]

ESTIMATES = ("adaptive", "joint", "flights")
BY_FLIGHTS = ("joint", "flights")
"""Which of them measure a drop by its flights first."""
_OF_CIRCLES = (
    "arc_too_short",
    "channel_dead",
    "channel_off",
    "pair_not_in_quadrature",
    "pair_of_two_motions",
    "pair_without_phase",
    "phase_reversed",
    "phase_sign_wrong",
    "several_frequencies",
)
"""What is said of a receiver whose I and Q run on no circle."""
_OF_WIRES = (
    *(code for code in _OF_CIRCLES if code.startswith(("pair", "phase", "several"))),
    "mixer_impossible",
    "no_single_body",
    "echo_of_another",
    "phase_led_astray",
)
"""Which of this, and of motions, a floor that reflects strongly does as well."""

OnPreliminary = Callable[[RunResult], None]

LANDED_DEAD = "landed_dead"
"""Code of the finding that a fall has no rebound: no correction tells an e of it then."""
STOPPED = warn("joint_stopped")
_MAX_ESTIMATES = 3
"""Each without what the one before could not explain: a contact that opens again and again does so for the rest of the
record, too."""
_OF_FLIGHTS = 0.1
"""Share of the bar that flights take before the joint estimate: 1 to 3 s of 10 to 20."""


def process(
    recording: Recording,
    setup: Setup,
    progress: Callable[[float], None] | None = None,
    on_preliminary: OnPreliminary | None = None,
    front_ends: FrontEndPrior | None = None,
    others: SetupPrior | None = None,
) -> RunResult:
    """Turn the samples of one run into path lengths, track, bounces and g.

    Parameters
    ----------
    recording
        Raw samples; as many IQ pairs as the setup has receivers.
    setup
        Geometry, correction, release position.
    progress
        Called with the share done, 0 to 1, which never runs back; what it raises, as `CancelledError`, ends the work.
    on_preliminary
        Given the preliminary result, of a drop by its flights, else by the adaptive correction, while the joint one is
        being computed.
    front_ends
        What other runs say about the front ends, prior of the joint correction; None: nothing, the run speaks for
        itself.
    others
        What other runs say of antennas, release and wavelength, as `front_ends`; not used where the setup says so, or
        where a receiver is left out.

    Returns
    -------
    RunResult
        status ok, no_motion or rejected; arrays have one column a stored sample, NaN where unknown. Of a long
        recording its `recording` is the excerpt around a motion, to which all arrays belong.

    Raises
    ------
    ProcessingError
        The recording does not fit the setup, or holds no samples, or fewer drops than the setup asks for.
    """
    with one_blas_thread():
        done = Progress(progress)
        # an hour of rest says nothing that its last seconds do not
        recording = shortened(recording)
        setup.demand_pairs(recording)
        motions = motions_of(recording, setup)
        # an answer, not a failure: a plate that hangs still is measured too
        if isinstance(motions, NoMotion):
            findings = (motions.finding, *findings_before(recording, setup))
            return RunResult(recording, setup, "no_motion", findings=findings)
        done.reach(0.1)
        # a dead, doubled or exchanged channel is no receiver: its neighbours must not be corrected together with it
        part = Part(setup, motions.together, motions.together.faults)

        def fly(part: Part, former: MeasuredDrop | Finding | None) -> _Flown:
            # flights that explain all receivers tell more of them than circles, which a strong floor bends
            whole = replace(part, faults=tuple(None if one and one.code in _OF_CIRCLES else one for one in part.faults))
            return _flown(whole, lambda part: _drop(part, done, front_ends, former))

        def by_circles(part: Part) -> tuple[Part, MeasuredMotion]:
            return part, _measure(recording, part, done, on_preliminary, front_ends, others)

        drop: MeasuredDrop | Finding | None = None
        part, flown = _asked_drop(part, (Part(setup, one, one.faults) for one in motions.apart), fly)

        def another_size(part: Part, drop: MeasuredDrop, motion: MeasuredMotion) -> Finding | None:
            """Return that the sphere's diameter is likely wrong, where something else would be blamed."""
            if (other := drop.other_diameter(part.setup, motion)) is None:
                return None
            if named := drop.wrong_diameter(other, part.setup, motion):
                return named
            of_size = replace(part, whole_setup=other.setup)
            again = _drop(of_size, done, front_ends, None)
            measured = _of_drop(recording, of_size, again, done, None, front_ends, others)
            if measured is None or measured.estimate is None:
                return None
            from radargui.processing.by_estimate import wrong_diameter

            return wrong_diameter(motion, measured, other.by_m, part.setup)

        def by_flights(part: Part) -> tuple[Part, MeasuredMotion]:
            nonlocal drop, flown
            (whole, drop), flown = flown or fly(part, drop), None
            motion = _of_drop(recording, whole, drop, done, on_preliminary, front_ends, others)
            part, motion = (whole, motion) if motion else by_circles(_over_strong_floor(part, drop))
            if isinstance(drop, Finding):
                motion = motion.said(warn("no_flights", cause=drop))
            elif drop is not None and not motion.unexplained:
                motion = motion.said(drop.landed_dead)
                motion = motion.contradicted(another_size(whole, drop, motion))
                if floor := drop.strong_floor:
                    motion = motion.blamed(_OF_WIRES, floor)
            return part, motion

        part, motion = _explained(part, by_flights)
        # one at a time may reject another: without a bad receiver its neighbours are judged anew
        while failed := _left_out(part, motion):
            part, motion = _explained(part.without(failed), by_circles)
        done.reach(0.97)
        return _result(recording, part, motion)


def _over_strong_floor(part: Part, drop: MeasuredDrop | Finding | None) -> Part:
    """Return the part with faults of wires blamed on a floor that reflects strongly, where the flights met one."""
    floor = None if drop is None or isinstance(drop, Finding) else drop.strong_floor
    if floor is None:
        return part
    return replace(part, faults=tuple(floor if one and one.code in _OF_WIRES else one for one in part.faults))


def _explained(part: Part, measure: Callable[[Part], tuple[Part, MeasuredMotion]]) -> tuple[Part, MeasuredMotion]:
    """Measure the motion, anew without each stretch of a receiver that no motion explains.

    Where there is no end of such stretches, or nothing stands without them but circles, their receivers are rejected: a
    phase that was led astray for milliseconds may have lost a fringe, and a round circle says nothing of that.
    """
    for _ in range(_MAX_ESTIMATES):
        used, motion = measure(part)
        if not motion.unexplained:
            break
        # what bent the motion may have hidden another one
        used = used.without_stretches(motion.unexplained)
        part = replace(part, whole=used.whole, left_out=used.left_out)
    if motion.unexplained or (motion.estimate is None and motion.corrected.method != "flights"):
        for number, why in unexplained_of(used.left_out).items():
            motion = motion.refused(why, np.array(used.receivers) == number)
    return used, motion


def _measure(
    recording: Recording,
    part: Part,
    progress: Progress,
    on_preliminary: OnPreliminary | None,
    front_ends: FrontEndPrior | None,
    others: SetupPrior | None,
) -> MeasuredMotion:
    """Measure the motion by the chosen correction: of joint, adaptive and published the first that can be made."""
    conditioned, setup = part.conditioned, part.setup
    method = setup.processing.correction
    if method == "flights":
        # nothing could be followed so: what circles tell is left
        method, setup = "adaptive", part.with_correction("adaptive").setup
    if not part.receivers:
        return nothing_measured(conditioned, method)
    if part.is_too_small:
        # the run is rejected: of the others only their quality is reported, and in a moment
        return measure_by_receiver(conditioned, setup, "ellipse", progress.attempt())
    if method not in ESTIMATES:
        return measure_by_receiver(conditioned, setup, method, progress.attempt())
    # only who asks for an estimate pays for loading it
    from radargui.processing.by_estimate import measure_by_estimate

    def preliminary(motion: MeasuredMotion) -> None:
        if on_preliminary is not None:
            on_preliminary(replace(_result(recording, part, motion), preliminary=True))

    prior = None if front_ends is None else part.prior(front_ends)
    try:
        # the unknowns of fewer receivers are others
        known = others if setup.processing.pool_setup and not any(part.faults) else None
        return measure_by_estimate(conditioned, setup, progress, preliminary, prior, known)
    except ProcessingError as error:
        # it needs no model of the motion but fringes
        motion = measure_by_receiver(conditioned, setup, "published", progress.attempt())
        return replace(motion, findings=(warn("estimate_impossible", method=method, cause=why_of(error)),))


def _flown(part: Part, measure: Callable[[Part], MeasuredDrop | Finding | None]) -> _Flown:
    """Measure a drop, first as if no channel were open: flights that explain all channels say that none is.

    Over a floor of metal waves stand: where one shows in Q alone, I looks as if its contact were open.
    """
    if part.whole.opened.any():
        drop = measure(part.closed)
        if drop is not None and not isinstance(drop, Finding) and drop.is_explained:
            return part.closed, drop
    return part, measure(part)


def _asked_drop(
    part: Part, motions: Iterator[Part], fly: Callable[[Part, MeasuredDrop | Finding | None], _Flown]
) -> tuple[Part, _Flown | None]:
    """Return the drop of several motions that the setup asks for, and its flights; all and none where none is a drop.

    The sphere fell from the release in it, so that its path is counted from there. Other motions are a hand's.

    Raises
    ------
    ProcessingError
        There are fewer drops than that.
    """
    processing, found = part.setup.processing, 0
    if processing.correction in BY_FLIGHTS:
        for one in motions:
            flown = fly(one, None)
            found += flown[1] is not None and not isinstance(flown[1], Finding)
            if found == processing.drop:
                return one, flown
        if processing.drop > 1:
            raise worded(ProcessingError, "no_such_drop", drop=processing.drop, found=found)
    return part, None


def _drop(
    part: Part, progress: Progress, front_ends: FrontEndPrior | None, former: MeasuredDrop | Finding | None
) -> MeasuredDrop | Finding | None:
    """Measure a drop by its flights, with all receivers; `former` is what was found before stretches were left out.

    None where another correction is wanted or needed; why not where flights are and nothing can be followed so.
    """
    method = part.setup.processing.correction
    if method not in BY_FLIGHTS:
        return None
    # only who asks for them pays for loading them
    from radargui.processing.by_flights import measure_by_flights

    prior = None if front_ends is None else part.prior(front_ends)
    is_first = method == "joint"
    # a channel that is off says nothing, whatever the others fly
    if fault := next(filter(None, part.faults), None):
        return None if is_first else fault
    report = progress.attempt(_OF_FLIGHTS) if is_first else progress.attempt()
    begun = None if former is None or isinstance(former, Finding) else former.estimate.start
    try:
        return measure_by_flights(part.conditioned, part.setup, report, prior, begun)
    except ProcessingError as error:
        return None if is_first else why_of(error)


def _of_drop(
    recording: Recording,
    part: Part,
    drop: MeasuredDrop | Finding | None,
    progress: Progress,
    on_preliminary: OnPreliminary | None,
    front_ends: FrontEndPrior | None,
    others: SetupPrior | None,
) -> MeasuredMotion | None:
    """Return what a drop's flights measured, or the joint estimate begun from them; None where circles have to tell."""
    if drop is None or isinstance(drop, Finding):
        return None
    if part.setup.processing.correction == "flights" or drop.motion.unexplained:
        return drop.motion
    prior = None if front_ends is None else part.prior(front_ends)
    if on_preliminary is not None and drop.is_followed:
        on_preliminary(replace(_result(recording, part, drop.motion), preliminary=True))
    from radargui.processing.by_estimate import measure_drop

    known = others if part.setup.processing.pool_setup else None
    return measure_drop(drop, part.conditioned, part.setup, progress, prior, known)


def _left_out(part: Part, motion: MeasuredMotion) -> dict[int, Finding]:
    """Return why receivers are left out that the correction rejected, where enough others remain; else nothing.

    A correction of each receiver by itself that fails in one says little good of it in the others: they may leave the
    circle by a third and be `usable`. Unless all of them are good the run is refused.
    """
    channels = motion.corrected.channels
    if motion.corrected.method not in ESTIMATES and any(one.verdict == "usable" for one in channels):
        return {}
    rows = zip(part.receivers, channels, strict=True)
    failed = {number: own.finding for number, own in rows if own.finding and own.verdict == "rejected"}
    return failed if len(part.receivers) - len(failed) >= MIN_RECEIVERS else {}


def _result(recording: Recording, part: Part, motion: MeasuredMotion) -> RunResult:
    """Return what was measured in all samples of the recording, with impacts, their uncertainties and findings."""
    conditioned, corrected = part.conditioned, motion.corrected
    whole = Whole(recording, conditioned, part.receivers)
    evidence = Evidence(recording, part, motion, whole.channels(corrected, part.faults), motion.track)
    is_refused, paths, track = evidence.is_refused, motion.paths, motion.track
    setup_posterior = motion.setup_posterior
    if is_refused:
        # rejected means rejected: no sample of it is called valid
        paths = replace(paths, valid=np.zeros_like(paths.valid))
        track = None if track is None else replace(track, valid=np.zeros_like(track.valid))
    if track is not None and not conditioned.segment.has_rest and part.begins_after_gap:
        track = known_where(track, np.zeros_like(track.valid))
    if track is not None and not is_refused:
        impacts = impacts_of_track(
            track,
            motion.paths,
            conditioned.segment,
            part.setup,
            conditioned.sample_rate_hz,
            motion.bounces,
            motion.changes,
        )
        track, bounces, budget = impacts.track, impacts.bounces, impacts.budget
        if any(one.code == LANDED_DEAD for one in motion.findings):
            # what flies a millimetre high, if at all, is within what any model of the floor leaves
            bounces, budget = replace(bounces, impacts=(), velocities=None), budget and replace(budget, e=BudgetLine())
        if impacts.cause is not None:
            evidence = replace(evidence, motion=motion.contradicted(impacts.cause))
        setup_posterior = setup_posterior or impacts.setup_posterior
        # the joint estimate's errors belong to the place: what mirrors do turns by one radian within this
        alike_m = None if motion.bounces is None else part.setup.radar.wavelength_m / (4.0 * np.pi)
        by_conic, g_m_s2 = corrected.method in ("ellipse", "none"), expected_gravity_m_s2(part.setup.site)
        bounces, floor = judged_by_floor(bounces, track, g_m_s2, alike_m, by_conic=by_conic)
        evidence = replace(evidence, track=track, bounces=bounces, budget=budget, floor=floor)
        corrected = replace(corrected, decisions=(*corrected.decisions, *found_tilt(bounces), *walls_met(bounces)))
    return RunResult(
        recording,
        part.whole_setup,
        status="rejected" if is_refused else "ok",
        segment=whole.segment(conditioned.segment),
        corrected=partial(whole.corrected, corrected, evidence.channels),
        paths=partial(whole.paths, paths),
        track=None if track is None else partial(whole.track, track),
        bounces=evidence.bounces,
        motion=None if is_refused else motion.motion,
        uncertainty_budget=evidence.budget,
        setup_posterior=setup_posterior,
        setup_likelihood=None if is_refused or any(part.faults) else motion.setup_likelihood,
        setup_prior=motion.setup_prior,
        findings=findings_of(evidence),
        front_end_prior=motion.front_end_prior,
        reported_quality=Quality(motion.corrected.method, evidence.channels),
    )


def steps_of(result: RunResult) -> tuple[object, ...]:
    """Return what the correction of a result found on its way (`CorrectedIQ.steps`), found again in its samples."""
    corrected = result.corrected
    if corrected is None or corrected.method in ESTIMATES:
        return ()
    motions = motions_of(result.recording, result.setup)
    if isinstance(motions, NoMotion):
        return ()
    part = Part(result.setup, motions.together, motions.together.faults)
    whole = Whole(result.recording, part.conditioned, part.receivers)
    again, _ = correct(part.conditioned, corrected.method)
    return whole.steps(again.steps)


def cut_short(result: RunResult) -> RunResult:
    """Return a preliminary result as it is kept where the joint correction was stopped."""
    return replace(result, findings=(STOPPED, *result.findings))


def measure_by_receiver(conditioned: Conditioned, setup: Setup, method: str, progress: Report) -> MeasuredMotion:
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
