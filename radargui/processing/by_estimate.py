"""The way of the estimates: adaptive, in the Doppler band where that knows more, and joint falling back on it.

Method 2.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from radargui.conditioning.conditioned import Conditioned
from radargui.correction.quality import LIMITS
from radargui.estimation.adaptive.estimate import estimate_adaptive
from radargui.estimation.adaptive.found import AdaptiveRounds, adaptive_rounds
from radargui.estimation.hardware import disagreement, knows_more
from radargui.estimation.joint import JointEstimate, estimate_joint
from radargui.estimation.motion_estimate import MotionEstimate
from radargui.estimation.readout.unexplained import (
    UnexplainedError,
    UnexplainedStretch,
    unexplained_of,
    unexplained_stretches,
)
from radargui.estimation.select.budget import LooseMapsError, NoSingleBodyError
from radargui.geometry.path_length import LEAST_RECEIVERS
from radargui.model.arrays import BoolArray, FloatArray
from radargui.model.errors import ProcessingError, SolveError
from radargui.model.front_end import FrontEnd, FrontEndPrior
from radargui.model.gravity import NOMINAL_GRAVITY_M_S2
from radargui.model.result import CorrectedIQ, PathLengths, Track
from radargui.model.setup import Setup
from radargui.processing.continuity import checked
from radargui.processing.doubts import (
    LOOSE_MAPS,
    NOTHING,
    doubt,
    hardly_known,
    is_fringe_sure,
    is_unknown,
    turned_polarisation,
)
from radargui.processing.drifting_rest import drifting_rest
from radargui.processing.in_band import measure_in_band
from radargui.processing.locate import locate, locate_body
from radargui.processing.measured_motion import MeasuredMotion
from radargui.restitution.bent_flights import CONTRADICTED, COUNTED, NAMED
from radargui.restitution.input_changes import joint_changes, setup_responses
from radargui.restitution.joint_bounces import joint_bounces
from radargui.restitution.settings import TRACKS

_FALL_MARGIN = 0.1  # of the fall left out at both ends
ENDED_EARLY = (
    "the search for walls was ended before it had looked everywhere: the signals ask for more than the model has, and "
    "what the models before it say counts in full in the uncertainty"
)
NO_SINGLE_BODY = (
    "no motion of one body describes it together with the others: swapped cables, antennas elsewhere than the setup "
    "says, a wrong sample rate, a lost fringe, or a second target"
)

UNSURE_FRINGE = (
    "the position is not known well enough to tell which fringe it is, and the motion goes to and fro too quickly for "
    "the spectra to tell: let it go farther, or raise the signal"
)


def measure_by_estimate(
    conditioned: Conditioned,
    setup: Setup,
    progress: Callable[[float], None],
    on_preliminary: Callable[[MeasuredMotion], None],
    prior: FrontEndPrior | None,
    left_out: tuple[UnexplainedStretch, ...] = (),
) -> MeasuredMotion:
    """Return corrected IQ, path lengths and track by the joint or the adaptive estimate, as the setup wants.

    Where the joint estimate does not fit the signal the adaptive one stands, and a warning says so. Fewer receivers
    than it needs are no fault of the run: only who named the joint correction in the setup is warned.

    Parameters
    ----------
    conditioned
        Signals, motion, rest, noise.
    setup
        Correction, geometry, release position, floor.
    progress
        Called with the share done, 0 to 1; what it raises ends the work.
    on_preliminary
        Given what the adaptive estimate says before the joint one is begun.
    prior
        What is known about the front ends, as they are wired. The joint estimate is made without it, and again with it
        where the run by itself does not contradict it and knows much less: short drops.
    left_out
        Stretches that are not used: a first joint estimate could not explain them.

    Raises
    ------
    ProcessingError
        Neither estimate can be made.
    """
    method = setup.processing.correction
    if conditioned.n_receivers < LEAST_RECEIVERS:
        asked = method == "joint" and "correction" in setup.processing.model_fields_set
        alone = measure_in_band(conditioned, setup.radar.wavelength_m, lambda own: _by_circles(own, setup))
        return _with_reason(alone, "it needs three receivers" if asked else "")
    for stretch in left_out:
        conditioned = conditioned.without(stretch.receiver, stretch.begin_s, stretch.end_s)
    rounds = adaptive_rounds(conditioned, setup)
    # always: it starts the joint estimate, and stands where that does not
    estimate = estimate_adaptive(rounds)
    if method != "joint":
        return _at_rest(_motion_of(estimate, conditioned, setup), _drifts(estimate, conditioned, setup))
    adaptive = _motion_of(estimate, conditioned, setup, is_tested=True)
    # a long search in a signal without an echo ends in a misfit: said at once instead
    if _is_hopeless(estimate, adaptive):
        return adaptive
    # the operator has a result soon, and the joint one replaces it
    on_preliminary(adaptive)
    try:
        joint, why, tried = _try_joint_with(prior, setup, rounds, progress)
    except NoSingleBodyError as error:
        if isinstance(error, UnexplainedError) and not left_out:
            again = measure_by_estimate(conditioned, setup, progress, on_preliminary, prior, error.stretches)
            return _with_left_out(again, error.stretches)
        if isinstance(error, LooseMapsError):
            return _without(adaptive, error.misfit < np.inf, LOOSE_MAPS.format(what="offsets change"))
        wrong = _misfits(error.misfit, estimate)
        if wrong.any():
            return _without(adaptive, wrong)
        joint, why, tried = None, error.message, None
    if joint is None:
        # nothing has tested it
        return _with_reason(_motion_of(estimate, conditioned, setup), why)
    motion = _judged(_motion_of(joint, conditioned, setup), joint, adaptive, setup)
    if motion.corrected.method != "joint":
        return motion
    return _at_rest(_with_prior(motion, tried, why), _drifts(estimate, conditioned, setup))


def _drifts(adaptive: MotionEstimate, conditioned: Conditioned, setup: Setup) -> str:
    """Return what is said of a rest before a fall in which all paths change alike."""
    if not (conditioned.segment.has_rest and _falls(adaptive)):
        return ""
    i, q, valid = adaptive.i, adaptive.q, adaptive.valid
    return drifting_rest(adaptive.time_s, i + 1j * q, valid, conditioned.segment, setup.radar.wavelength_m)


def _at_rest(motion: MeasuredMotion, drifts: str) -> MeasuredMotion:
    return replace(motion, warnings=(*motion.warnings, drifts)) if drifts else motion


def _misfits(misfit: FloatArray, estimate: MotionEstimate) -> BoolArray:
    """Return which receivers neither the motion of one body nor, where it tells, their own circle describes."""
    wrong = misfit > LIMITS.most_misfit
    # a round circle is believed where the places fall: elsewhere mirrors bend it as they like, its u is of noise
    return np.asarray(wrong & (estimate.chi_square > LIMITS.most_misfit) if _falls(estimate) else wrong)


def _judged(motion: MeasuredMotion, joint: JointEstimate, adaptive: MeasuredMotion, setup: Setup) -> MeasuredMotion:
    """Return what the joint estimate measured; rejected where it leaves open which fringe it is, or what reflects."""
    if motion.track is not None and is_unknown(motion.track, joint.onset_s, setup.radar.wavelength_m):
        return _refused(adaptive, motion, NO_SINGLE_BODY)
    why_not = doubt(joint.chosen.solution, joint.onset_s, setup)
    # a fall that obeys its equation of motion would show a lost fringe; nothing holds a level motion, whose u means
    # nothing then
    if why_not and not joint.chosen.solution.problem.in_flight.any():
        return _refused(adaptive, motion, why_not)
    # believed on whole circles before, and what was to test them does not say enough
    unsure = _strayed(joint, motion) & ~_rejected(adaptive)
    if unsure.any() and not is_fringe_sure(motion.track, joint.onset_s):
        return _without(motion, unsure, UNSURE_FRINGE)
    return motion


def _by_circles(conditioned: Conditioned, setup: Setup) -> MeasuredMotion:
    return _motion_of(estimate_adaptive(adaptive_rounds(conditioned, setup)), conditioned, setup)


def _with_reason(adaptive: MeasuredMotion, why: str) -> MeasuredMotion:
    """Return the motion with why the joint correction does not stand; nothing where it was not asked for."""
    because = f"{why[:1].lower()}{why[1:]}".rstrip(".")
    warnings = (f"the joint correction does not stand here ({because}): the adaptive one was used",) if why else ()
    return replace(adaptive, warnings=adaptive.warnings + warnings)


def _without(adaptive: MeasuredMotion, wrong: BoolArray, reason: str = NO_SINGLE_BODY) -> MeasuredMotion:
    """Return the motion with receivers rejected that neither their own circle nor one body's motion describes.

    Such a circle may look round: the phases of receivers that see nearly one path agree for a while.
    """
    rows = zip(adaptive.corrected.channels, wrong, strict=True)
    channels = tuple(replace(one, verdict="rejected", reason=reason) if alone else one for one, alone in rows)
    return replace(adaptive, corrected=replace(adaptive.corrected, channels=channels))


def _refused(adaptive: MeasuredMotion, motion: MeasuredMotion, why: str) -> MeasuredMotion:
    """Return the motion refused by what the flights of the joint one say of the setup, or by a guess and that."""
    causes = tuple(one for one in motion.warnings if one.startswith(CONTRADICTED))
    named = next((one.removesuffix(COUNTED) for one in causes if one.startswith(NAMED)), "")
    rejected = _without(adaptive, np.ones(len(adaptive.corrected.channels), dtype=np.bool_), named or why)
    return rejected if named else replace(rejected, warnings=rejected.warnings + causes)


def _with_left_out(motion: MeasuredMotion, stretches: Sequence[UnexplainedStretch]) -> MeasuredMotion:
    """Return a motion with what it was measured without; rejected where no joint estimate stands without it either.

    A phase that was led astray for milliseconds may have lost a fringe, and a round circle says nothing of that.
    """
    shown = unexplained_of(stretches)
    if motion.corrected.method != "joint":
        for receiver, why in shown.items():
            motion = _without(motion, np.arange(len(motion.corrected.channels)) == receiver, why)
        return motion
    sentences = (f"receiver {receiver + 1} {why}: left out there" for receiver, why in shown.items())
    return replace(motion, warnings=(*sentences, *motion.warnings))


def _is_hopeless(estimate: MotionEstimate, adaptive: MeasuredMotion) -> bool:
    """Whether the joint estimate has nothing to begin with.

    It corrects circles that reflections bend, not a lost count of fringes: a path that follows its circle, but not its
    signal. A floor can bend circles of level motion by more than they leave of their noise: no such circle says that
    there is no echo.
    """
    return bool(_strayed(estimate, adaptive).any())


def _strayed(estimate: MotionEstimate, motion: MeasuredMotion) -> BoolArray:
    """Return which receivers are rejected by their path, not by the fit of their circle."""
    return _rejected(motion) & [channel.verdict != "rejected" for channel in estimate.channels]


def _rejected(motion: MeasuredMotion) -> BoolArray:
    """Return which receivers are rejected."""
    return np.array([channel.verdict == "rejected" for channel in motion.corrected.channels])


def _falls(estimate: MotionEstimate) -> bool:
    """Whether the places before the first impact are those of a free fall."""
    if estimate.position_m is None or estimate.impact_s.size == 0:
        return False
    onset_s, impact_s = estimate.onset_s, float(estimate.impact_s[0])
    # the release is no clean cut, and the impact's instant is known to a bin
    time_s, margin_s = estimate.time_s, _FALL_MARGIN * (impact_s - onset_s)
    falling = (time_s > onset_s + margin_s) & (time_s < impact_s - margin_s)
    if falling.sum() < TRACKS.least_fall_samples:
        return False
    bend = np.polyfit(time_s[falling] - onset_s, estimate.position_m[2, falling], 2)[0]
    return bool(abs(-2.0 * bend / NOMINAL_GRAVITY_M_S2 - 1.0) < TRACKS.largest_g_error)


def _motion_of(
    estimate: MotionEstimate, conditioned: Conditioned, setup: Setup, *, is_tested: bool = False
) -> MeasuredMotion:
    """Return what was measured, its paths held against their signals; `is_tested`: by an estimate that follows."""
    bounces, changes, blur, by_setup = None, None, 1.0, NOTHING
    warnings: tuple[str, ...] = ()
    # the far field bends the path by millimetres: no flight obeys gravity there, and the track gives the bounces
    if isinstance(estimate, JointEstimate) and setup.processing.geometry == "exact":
        try:
            responses = setup_responses(estimate, setup)
            bounces, fit = joint_bounces(estimate, setup, responses)
            changes, test = joint_changes(estimate, bounces, fit, setup, responses)
            warnings, blur, by_setup = test.warnings, test.blur, responses.bias_deviations()
            estimate, bounces = estimate.widened(test.widening), bounces.widened(test.widening)
        except SolveError as error:
            why = error.message.rstrip(".")
            warnings = (f"the flights could not be fitted ({why}): the bounces were taken from the track",)
    # phase = 2 pi L / wavelength: estimates are in metres, the corrected IQ is shown in rad (method 1)
    rad_per_m = 2.0 * np.pi / setup.radar.wavelength_m
    phase, u_phase = estimate.change_m * rad_per_m, estimate.u_change_m * rad_per_m
    paths = PathLengths(estimate.time_s, phase, estimate.change_m, estimate.u_change_m, estimate.valid)
    samples = estimate.time_s, estimate.i, estimate.q, estimate.valid, u_phase
    corrected = CorrectedIQ(*samples, estimate.method, estimate.channels, decisions=estimate.choices)
    if isinstance(estimate, JointEstimate) and not any(one.startswith(NAMED) for one in warnings):
        turned = turned_polarisation(estimate.chosen.solution, blur)
        warnings = (turned, *warnings) if turned else warnings
    if isinstance(estimate, JointEstimate) and estimate.chosen.ended_early:
        warnings += (ENDED_EARLY,)
    elif isinstance(estimate, JointEstimate) and not warnings:
        solution = estimate.chosen.solution
        warning = doubt(solution, estimate.onset_s, setup, by_setup) or hardly_known(estimate, setup, changes)
        warnings = (warning,) if warning else ()
    paths, track = _located(estimate, paths, setup)
    motion = MeasuredMotion(corrected, paths, track, bounces, changes, warnings=warnings)
    if isinstance(estimate, JointEstimate):
        is_tested = is_fringe_sure(track, estimate.onset_s)
    return checked(motion, conditioned, setup.radar.wavelength_m, is_held=is_tested)


def _located(estimate: MotionEstimate, paths: PathLengths, setup: Setup) -> tuple[PathLengths, Track | None]:
    # the joint estimate knows the sphere as a body; the adaptive one's circles show the phase that it scatters with
    measured = setup.transmitter.polarization_deg is not None and not isinstance(estimate, JointEstimate)
    if estimate.position_m is None or estimate.u_position_m is None or measured:
        # the phase that the body adds is taken off the direct path (method 3)
        return locate_body(paths, setup)
    if setup.processing.geometry == "plane":
        # the joint estimate's paths are those to the centre already
        return paths, locate(paths, setup)
    valid = np.asarray(estimate.valid.all(axis=0) & np.isfinite(estimate.position_m).all(axis=0))
    return paths, Track(estimate.time_s, estimate.position_m, estimate.u_position_m, valid, "exact")


def _try_joint_with(
    prior: FrontEndPrior | None, setup: Setup, rounds: AdaptiveRounds, progress: Callable[[float], None]
) -> tuple[JointEstimate | None, str, FrontEndPrior | None]:
    """Return the joint estimate, why it does not stand or why its prior was not used, and the prior with its use."""
    joint, why = _try_joint(setup, rounds, progress)
    if prior is None:
        return joint, why, None
    # kept as they are wired; the estimate sees the sign already applied
    known = tuple(front_end.with_phase_sign(setup.radar.phase_sign) for front_end in prior.front_ends)
    unused = replace(prior, used=False)
    if joint is not None:
        why = disagreement(joint.constants, known)
        # a front end that changed would bend the track with the authority of ten runs: the run by itself comes first
        if why or not knows_more(known, joint.constants):
            return joint, why, unused
    # anew from the start: with the constants held, walls and floor may be chosen otherwise
    try:
        helped, failed = _try_joint(setup, rounds, lambda _: progress(1.0), known)
    except NoSingleBodyError as error:
        helped, failed = None, error.message.rstrip(".")
    if helped is None:
        return joint, failed if joint is not None else why, unused
    return helped, "", replace(prior, used=True)


def _try_joint(
    setup: Setup,
    rounds: AdaptiveRounds,
    progress: Callable[[float], None],
    front_ends: tuple[FrontEnd, ...] | None = None,
) -> tuple[JointEstimate | None, str]:
    """Return the joint estimate, or None and why it does not stand."""
    try:
        joint = estimate_joint(rounds, setup, hardware=front_ends, progress=progress)
    except NoSingleBodyError:
        raise
    except ProcessingError as error:
        return None, error.message.rstrip(".")
    # a matrix without inverse says that the signal holds too little; every other fault is one
    except np.linalg.LinAlgError as error:
        return None, f"its equations have no solution: {error}"
    # a bad misfit is a model that is wrong here, and its u means nothing
    if not joint.fits:
        stretches = unexplained_stretches(joint.chosen.solution)
        raise UnexplainedError(joint.chi_square, stretches) if stretches else NoSingleBodyError(joint.chi_square)
    return joint, ""


def _with_prior(motion: MeasuredMotion, prior: FrontEndPrior | None, why: str) -> MeasuredMotion:
    """Return the motion with which runs its prior came from, or why it was not used."""
    if prior is None:
        return motion
    if prior.used:
        channels = tuple(replace(channel, prior_runs=prior.runs) for channel in motion.corrected.channels)
        return replace(motion, corrected=replace(motion.corrected, channels=channels), front_end_prior=prior)
    if not why:
        return replace(motion, front_end_prior=prior)
    runs = prior.runs[0] if len(prior.runs) == 1 else f"{prior.runs[0]} to {prior.runs[-1]}"
    warning = f"what {runs} say about the front ends is not used: this run does not agree ({why})"
    return replace(motion, front_end_prior=prior, warnings=(*motion.warnings, warning))
