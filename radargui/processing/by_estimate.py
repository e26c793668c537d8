"""The way of the estimates: joint where it can be made and nothing refuses it, else adaptive (method 2).

Of one or two receivers, which tell no position, each echo is followed in its Doppler band, or by its circle where that
knows more. An estimate as what was measured: its flights, bounces and paths, held against their signals. Whether all
paths grow while the tracer hangs at rest: an oscillator that drifts, or a tracer that sinks.

Method 8, An oscillator that drifts.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from radargui.correction.quality import LIMITS, OFF_CIRCLE
from radargui.estimation.adaptive.estimate import estimate_adaptive
from radargui.estimation.adaptive.found import AdaptiveRounds, adaptive_rounds
from radargui.estimation.doubts import doubt, is_fringe_sure, is_unknown
from radargui.estimation.hardware import disagreement, knows_more
from radargui.estimation.joint import JointEstimate, estimate_joint, with_setup_known
from radargui.estimation.motion_estimate import MotionEstimate
from radargui.estimation.posterior.kinematics import kinematics
from radargui.estimation.posterior.unexplained import Residuals, UnexplainedError, unexplained_stretches
from radargui.estimation.select.budget import LooseMapsError, NoSingleBodyError
from radargui.estimation.select.fall import FoundFall
from radargui.estimation.solve.minimise import log_evidence
from radargui.model.arrays import BoolArray, ComplexArray, FloatArray
from radargui.model.assumed import DIAMETER
from radargui.model.errors import ProcessingError, SolveError
from radargui.model.finding import Finding, error_of, refuse, warn, why_of
from radargui.model.front_end import FrontEnd, FrontEndPrior, run_names
from radargui.model.gravity import expected_gravity_m_s2
from radargui.model.result import Bounces, Kinematics, PathLengths, Segment, Track, whole_milliseconds
from radargui.model.setup import Setup
from radargui.model.setup_pool import SetupPrior, bumped
from radargui.model.setup_posterior import SetupPosterior
from radargui.model.uncertainty_budget import InputChange
from radargui.physics.path_length import MIN_RECEIVERS
from radargui.physics.scattering import is_delayed
from radargui.processing.by_flights import MAX_PULL, MeasuredDrop
from radargui.processing.checks.estimate import is_blamed
from radargui.processing.continuity import checked, measure_in_band
from radargui.processing.measured_motion import (
    MeasuredMotion,
    Progress,
    Report,
    corrected_of,
    locate_body,
    paths_of,
    track_of,
)
from radargui.restitution.flight_fit import FlightFit
from radargui.restitution.flight_test import FlightTest
from radargui.restitution.input_changes import SetupResponses, joint_changes, setup_responses
from radargui.restitution.joint_bounces import joint_bounces
from radargui.restitution.settings import TRACKS
from radargui.restitution.setup_outlier import wrong_value
from radargui.signals.conditioned import Conditioned

_FALL_MARGIN = 0.1  # of the fall left out at both ends
NO_SINGLE_BODY = refuse("no_single_body")
Estimate = Callable[..., JointEstimate]
"""Makes a joint estimate, as `estimate_joint` does."""


@dataclass(frozen=True, slots=True)
class _Joint:
    """The joint estimate or why there is none, the prior with its use, and why it was not used."""

    found: JointEstimate | ProcessingError
    prior: FrontEndPrior | None = None
    unused: Finding | None = None


def _is_pulled(found: SetupPosterior | None) -> bool:
    """Return whether a value of the setup was found so far from what is stated that an entry is wrong."""
    return found is not None and bool((np.abs(found.mean) > MAX_PULL * found.deviation).any())


def measure_drop(
    drop: MeasuredDrop,
    conditioned: Conditioned,
    setup: Setup,
    progress: Progress,
    prior: FrontEndPrior | None,
    others: SetupPrior | None = None,
) -> MeasuredMotion | None:
    """Return what the joint estimate makes of a drop that begins from its flights; None where circles have to tell.

    They have to where flights were not followed to their end, and where their joint estimate is refused for what it
    says of setup, receivers or fringes. Where none stands the flights do, if they explain the signals within what the
    setup states.

    Parameters
    ----------
    drop
        By its flights.
    conditioned, setup, progress, prior, others
        As of `measure_by_estimate`.
    """
    if not drop.is_followed:
        return None
    fall = FoundFall.of(drop.estimate, drop.signals, setup)
    joint = _joint_estimate(prior, setup, fall, progress)
    if isinstance(joint.found, ProcessingError) and not drop.is_explained:
        return None
    if isinstance(joint.found, UnexplainedError):
        return replace(drop.motion, unexplained=joint.found.stretches)
    if isinstance(joint.found, ProcessingError):
        return drop.motion.said(warn("flights_stand", cause=why_of(joint.found)))
    # flights that explain the signals within what the setup states need no entry that is wrong
    stands = drop.is_explained and drop.estimate.max_pull < MAX_PULL
    # an entry that is wrong pulls the others along: the road by circles names it
    if _is_pulled(joint.found.chosen.setup):
        return drop.motion.said(warn("flights_stand", cause=warn("entry_pulled", times_u=MAX_PULL))) if stands else None
    found, measured = _pooled(joint.found, fall, conditioned, setup, others)
    motion = _judged(measured, found, drop.motion, setup)
    if motion.estimate is None or motion.rejected.any():
        return drop.motion.said(warn("flights_stand", cause=warn("joint_rejected"))) if stands else None
    own = drop.motion.corrected
    drift = drifting_rest(own.time_s, own.i + 1j * own.q, own.valid, conditioned.segment, setup.radar.wavelength_m)
    return _with_prior(motion, joint).said(drift)


def wrong_diameter(stated: MeasuredMotion, other: MeasuredMotion, by_m: float, setup: Setup) -> Finding | None:
    """Return that the sphere's diameter is likely wrong, where the joint estimate with another one is the likelier one.

    Flights place no wall, and one hides from them what a sphere of another size scatters.

    Parameters
    ----------
    stated, other
        What was measured with the diameter that is stated, of which something would be blamed, and with another one.
    by_m
        What the other diameter has more.
    setup
        What states it.
    """
    if other.estimate is None or other.flights.bent is not None or other.flights.cause is not None:
        return None
    if stated.estimate is None:
        # nothing to compare it with: it has to leave no doubt
        gain = 0.0 if is_blamed(other, setup) else np.inf
    else:
        gain = 2.0 * (log_evidence(other.estimate.chosen.solution) - log_evidence(stated.estimate.chosen.solution))
    return wrong_value(DIAMETER, by_m, gain, 0.0, setup)


def measure_by_estimate(
    conditioned: Conditioned,
    setup: Setup,
    progress: Progress,
    on_preliminary: Callable[[MeasuredMotion], None],
    prior: FrontEndPrior | None,
    others: SetupPrior | None = None,
    estimate: Estimate = estimate_joint,
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
        Of the run: each joint estimate is an attempt; what it raises ends the work.
    on_preliminary
        Given what the adaptive estimate says before the joint one is begun.
    prior
        What is known about the front ends, as they are wired. The joint estimate is made without it, and again with it
        where the run by itself does not contradict it and knows much less: short drops.
    others
        What other runs say of antennas, release and wavelength. The joint estimate is moved to what it and they say
        together where the run by itself does not contradict them.
    estimate
        Makes the joint estimate.

    Raises
    ------
    ProcessingError
        Neither estimate can be made.
    """
    if conditioned.n_receivers < MIN_RECEIVERS:
        alone = measure_in_band(conditioned, setup.radar.wavelength_m, lambda own: _by_circles(own, setup))
        asked = setup.processing.correction == "joint" and "correction" in setup.processing.model_fields_set
        return alone.said(warn("joint_not_used", cause=refuse("needs_three_receivers")) if asked else None)
    rounds = adaptive_rounds(conditioned, setup)
    # always: it starts the joint estimate, and stands where that does not
    adaptive = estimate_adaptive(rounds)
    if setup.processing.correction != "joint":
        motion = motion_of_adaptive(adaptive, conditioned, setup)
        return motion.said(_drift_at_rest(adaptive, conditioned, setup))
    tested = motion_of_adaptive(adaptive, conditioned, setup, is_tested=True)
    # a long search in a signal without an echo ends in a misfit: said at once instead
    if _is_hopeless(adaptive, tested):
        return tested
    # the operator has a result soon, and the joint one replaces it
    on_preliminary(tested)
    joint = _joint_estimate(prior, setup, rounds, progress, estimate)
    if isinstance(joint.found, UnexplainedError):
        return replace(tested, unexplained=joint.found.stretches)
    if isinstance(joint.found, ProcessingError):
        refused = _refused_with(joint.found, adaptive, tested, setup)
        # where nothing has tested it, it is judged by its own signal
        return refused or motion_of_adaptive(adaptive, conditioned, setup).said(
            warn("joint_not_used", cause=why_of(joint.found))
        )
    found, measured = _pooled(joint.found, rounds, conditioned, setup, others)
    motion = _judged(measured, found, tested, setup)
    if motion.estimate is not None:
        motion = _with_prior(motion, joint).said(_drift_at_rest(adaptive, conditioned, setup))
    return motion


def _by_circles(conditioned: Conditioned, setup: Setup) -> MeasuredMotion:
    return motion_of_adaptive(estimate_adaptive(adaptive_rounds(conditioned, setup)), conditioned, setup)


def _drift_at_rest(adaptive: MotionEstimate, conditioned: Conditioned, setup: Setup) -> Finding | None:
    """Return what is said of a rest before a fall in which all paths change alike."""
    if not (conditioned.segment.has_rest and _falls(adaptive, setup)):
        return None
    i, q, valid = adaptive.i, adaptive.q, adaptive.valid
    return drifting_rest(adaptive.time_s, i + 1j * q, valid, conditioned.segment, setup.radar.wavelength_m)


def _refused_with(
    error: ProcessingError, estimate: MotionEstimate, adaptive: MeasuredMotion, setup: Setup
) -> MeasuredMotion | None:
    """Return the adaptive motion refused by what the joint estimate failed by; None where that says nothing of it."""
    if isinstance(error, LooseMapsError):
        return adaptive.refused(refuse("wall_unseen", what="offsets"), error.misfit < np.inf)
    if not isinstance(error, NoSingleBodyError):
        return None
    wrong = _misfits(error.misfit, estimate, setup)
    # neither their own circle nor one body's motion describes them: such a circle may look round, for the phases of
    # receivers that see nearly one path agree for a while
    return adaptive.refused(NO_SINGLE_BODY, wrong) if wrong.any() else None


def _misfits(misfit: FloatArray, estimate: MotionEstimate, setup: Setup) -> BoolArray:
    """Return which receivers neither the motion of one body nor, where it tells, their own circle describes."""
    wrong = misfit > LIMITS.max_misfit
    # a round circle is believed where the places fall: elsewhere mirrors bend it as they like, its u is of noise
    return np.asarray(wrong & (estimate.chi_square > LIMITS.max_misfit) if _falls(estimate, setup) else wrong)


def _judged(motion: MeasuredMotion, joint: JointEstimate, adaptive: MeasuredMotion, setup: Setup) -> MeasuredMotion:
    """Return what the joint estimate measured; rejected where it leaves open which fringe it is, or what reflects."""
    solution, onset_s = joint.chosen.solution, joint.onset_s
    if motion.track is not None and is_unknown(motion.track, onset_s, setup.radar.wavelength_m):
        return _instead(adaptive, motion.flights.cause, NO_SINGLE_BODY)
    unseen = doubt(solution, onset_s, setup)
    # a fall that obeys its equation of motion would show a lost fringe; nothing holds a level motion, whose u means
    # nothing then
    if unseen and not solution.problem.in_flight.any():
        return _instead(adaptive, motion.flights.cause, unseen)
    # believed on whole circles before, and what was to test them does not say enough
    unsure = _strayed(joint, motion) & ~adaptive.rejected
    if unsure.any() and not is_fringe_sure(motion.track, onset_s):
        return motion.refused(refuse("fringe_unsure"), unsure)
    return motion


def _instead(adaptive: MeasuredMotion, cause: Finding | None, guess: Finding) -> MeasuredMotion:
    """Return the adaptive motion refused by what the flights say of the setup, or by a guess beside a part of that."""
    if cause is not None and cause.facts["explains"]:
        # nothing counts in uncertainties that nobody gets
        return adaptive.refused(cause.with_facts(is_counted=False))
    return replace(adaptive.refused(guess), flights=FlightTest(cause=cause))


def _is_hopeless(estimate: MotionEstimate, adaptive: MeasuredMotion) -> bool:
    """Whether the joint estimate has nothing to begin with.

    It corrects circles that reflections bend, not a lost count of fringes: a path that follows its circle, but not its
    signal. A floor can bend circles of level motion by more than they leave of their noise: no such circle says that
    there is no echo.
    """
    is_bent = [one.finding is not None and one.finding.code == OFF_CIRCLE for one in estimate.channels]
    return bool((_strayed(estimate, adaptive) & ~np.array(is_bent)).any())


def _strayed(estimate: MotionEstimate, motion: MeasuredMotion) -> BoolArray:
    """Return which receivers are rejected by their path, not by the fit of their circle."""
    return motion.rejected & [channel.verdict != "rejected" for channel in estimate.channels]


def _falls(estimate: MotionEstimate, setup: Setup) -> bool:
    """Whether the places before the first impact are those of a free fall."""
    if estimate.position_m is None or estimate.impact_s.size == 0:
        return False
    onset_s, impact_s = estimate.onset_s, float(estimate.impact_s[0])
    # the release is no clean cut, and the impact's instant is known to a bin
    time_s, margin_s = estimate.time_s, _FALL_MARGIN * (impact_s - onset_s)
    falling = (time_s > onset_s + margin_s) & (time_s < impact_s - margin_s)
    if falling.sum() < TRACKS.min_samples or np.ptp(time_s[falling]) < TRACKS.min_fall_s:
        return False
    bend = np.polyfit(time_s[falling] - onset_s, estimate.position_m[2, falling], 2)[0]
    return bool(abs(-2.0 * bend / expected_gravity_m_s2(setup.site) - 1.0) < TRACKS.largest_g_error)


def _joint_estimate(
    prior: FrontEndPrior | None,
    setup: Setup,
    found: AdaptiveRounds | FoundFall,
    progress: Progress,
    estimate: Estimate = estimate_joint,
) -> _Joint:
    """Return the joint estimate of the run by itself; with a prior where it agrees with that and knows much less."""
    alone = _tried(estimate, setup, found, progress.attempt())
    if prior is None or isinstance(alone, NoSingleBodyError):
        return _Joint(alone)
    # kept as they are wired; the estimate sees the sign already applied
    known = tuple(front_end.with_phase_sign(setup.radar.phase_sign) for front_end in prior.front_ends)
    unused = replace(prior, used=False)
    if isinstance(alone, JointEstimate):
        differs = disagreement(alone.constants, known)
        # a front end that changed would bend the track with the authority of ten runs: the run by itself comes first
        if differs or not knows_more(known, alone.constants):
            return _Joint(alone, unused, differs)
    # anew from the start: with the constants held, walls and floor may be chosen otherwise
    helped = _tried(estimate, setup, found, progress.attempt(), known)
    if isinstance(helped, JointEstimate):
        return _Joint(helped, replace(prior, used=True))
    return _Joint(alone, unused, why_of(helped))


def _tried(
    estimate: Estimate,
    setup: Setup,
    found: AdaptiveRounds | FoundFall,
    progress: Report,
    front_ends: tuple[FrontEnd, ...] | None = None,
) -> JointEstimate | ProcessingError:
    """Return the joint estimate, or why it does not stand."""
    try:
        joint = estimate(found, setup, hardware=front_ends, progress=progress)
    except ProcessingError as error:
        return error
    # a matrix without inverse says that the signal holds too little; every other fault is one
    except np.linalg.LinAlgError as error:
        return error_of(SolveError, "no_solution", error=str(error))
    # ten milliseconds in a second hardly show in the misfit, and bend the motion all the same
    if stretches := unexplained_stretches(Residuals.of_solution(joint.chosen.solution)):
        return UnexplainedError(joint.chi_square, stretches)
    # a bad misfit is a model that is wrong here, and its u means nothing
    return joint if joint.fits else NoSingleBodyError(joint.chi_square)


def _pooled(
    alone: JointEstimate,
    begun: AdaptiveRounds | FoundFall,
    conditioned: Conditioned,
    setup: Setup,
    others: SetupPrior | None,
) -> tuple[JointEstimate, MeasuredMotion]:
    """Return the estimate and what it measured, with what other runs say of the setup where it agrees with them."""
    motion = motion_of_joint(alone, conditioned, setup)
    own, said = alone.chosen.setup, motion.setup_likelihood
    # whose flights do not fit says nothing of its antennas, and cannot contradict
    if own is None or said is None or others is None:
        return alone, motion
    if moved := bumped(said, others, setup):
        # an antenna that was pushed: nothing of before it holds for this run, nor for those after
        differs = warn("setup_differs", runs=run_names(others.runs), cause=moved)
        return alone, replace(motion, setup_prior=replace(others, used=False)).said(differs)
    try:
        found = with_setup_known(alone, begun, setup, others.likelihood(own.deviation))
    except SolveError:
        return alone, motion
    return found, replace(motion_of_joint(found, conditioned, setup), setup_prior=others, setup_likelihood=said)


def _with_prior(motion: MeasuredMotion, joint: _Joint) -> MeasuredMotion:
    """Return the motion with which runs its prior came from, or why it was not used."""
    prior = joint.prior
    if prior is None:
        return motion
    motion = replace(motion, front_end_prior=prior)
    if prior.used:
        channels = tuple(replace(channel, prior_runs=prior.runs) for channel in motion.corrected.channels)
        return replace(motion, corrected=replace(motion.corrected, channels=channels))
    if joint.unused is None:
        return motion
    return motion.said(warn("front_ends_differ", runs=run_names(prior.runs), cause=joint.unused))


_MIN_M_S = 5e-5
"""Of a path: half of it is a speed, a part in 50 000 of a fall's."""
_SIGMAS = 6.0
"""Of white noise: 1/f noise makes more of a drift, but not in all receivers alike."""
_ALIKE = 0.3
"""The slowest path over the fastest, and a radius over its path: offsets drift in any direction, one a receiver."""
_PATH_M = 1.4
"""From an antenna over the sphere to another, usually: a frequency that drifts by a share makes that share of it."""


def drifting_rest(
    time_s: FloatArray, point: ComplexArray, valid: BoolArray, segment: Segment, wavelength_m: float
) -> Finding | None:
    """Return a finding where all paths grow, or shrink, alike before the motion, else None.

    Each rest lies next to one point of the unit circle: what turns it is a path, what lengthens it is none.

    Parameters
    ----------
    time_s
        Of the samples, shape (n,).
    point, valid
        I + jQ on the unit circle, by an estimate that has no say in what rests (the joint one has the tracer at its
        place then), and what is known of it, shapes (n_receivers, n).
    segment
        The rest.
    wavelength_m
        Of the transmitted wave.
    """
    rest = slice(segment.rest_first, segment.rest_last)
    found = np.array([_slopes(time_s[rest], *one) for one in zip(point[:, rest], valid[:, rest], strict=True)])
    # NaN compares false
    speed, radial, u = found.T * wavelength_m / (2.0 * np.pi)
    size = np.abs(speed)
    alike = bool(size.min() > _ALIKE * size.max()) and abs(float(np.sign(speed).sum())) == speed.size
    if not (alike and (size > np.maximum(_SIGMAS * u, _MIN_M_S)).all() and (np.abs(radial) < _ALIKE * size).all()):
        return None
    mean = float(speed.mean())
    return warn("rest_drifts", speed_m_s=mean, share_per_s=abs(mean) / _PATH_M)


def _slopes(time_s: FloatArray, point: ComplexArray, valid: BoolArray) -> FloatArray:
    """Return by what a receiver's phase and radius change in a second at rest, and the u of both, in rad and radii."""
    known = valid & np.isfinite(point)
    if known.sum() < 3:
        return np.full(3, np.nan)
    point = point[known] / point[known].mean()
    away_s = time_s[known] - time_s[known].mean()
    square = float(away_s @ away_s)
    slope = (away_s @ point) / square
    off = point - point.mean() - slope * away_s
    u = np.sqrt(float((np.abs(off) ** 2).mean()) / 2.0 / square)
    return np.array([slope.imag, slope.real, u])


def motion_of_adaptive(
    estimate: MotionEstimate, conditioned: Conditioned, setup: Setup, *, is_tested: bool = False
) -> MeasuredMotion:
    """Return what circles found; `is_tested`: an estimate that follows tests it."""
    paths, track = _located(estimate, paths_of(estimate, setup), setup)
    motion = MeasuredMotion(corrected_of(estimate, setup), paths, track)
    return checked(motion, conditioned, setup.radar.wavelength_m, is_held=is_tested)


Bounced = Callable[[JointEstimate, Setup, SetupResponses], tuple[Bounces, FlightFit | None]]


def motion_of_joint(
    estimate: JointEstimate, conditioned: Conditioned, setup: Setup, bounces_of: Bounced = joint_bounces
) -> MeasuredMotion:
    """Return what the joint estimate found, its uncertainties widened by what its flights, bounces and g, say."""
    found = estimate.chosen.setup
    estimate, bounces, changes, flights = _with_flights(estimate, setup, bounces_of)
    paths, track = _located(estimate, paths_of(estimate, setup), setup)
    # flights that do not fit bend antennas, too: other runs must not be told
    is_sound = estimate.chosen.solution.settled and flights.bent is None and flights.cause is None
    said = found.alone.widened(flights.widening) if found is not None and is_sound else None
    motion = MeasuredMotion(
        corrected_of(estimate, setup),
        paths,
        track,
        bounces,
        changes,
        motion=_motion(estimate, conditioned, flights.widening),
        setup_posterior=() if found is None else found.values(setup),
        setup_likelihood=said,
        estimate=estimate,
        flights=flights,
    )
    is_sure = is_fringe_sure(track, estimate.onset_s)
    return checked(motion, conditioned, setup.radar.wavelength_m, is_held=is_sure)


def _motion(estimate: JointEstimate, conditioned: Conditioned, widening: float) -> Kinematics:
    """Return velocities and accelerations of the motion."""
    last_s = float(estimate.time_s[min(conditioned.segment.last, estimate.time_s.size) - 1])
    time_s = whole_milliseconds(estimate.onset_s, last_s)
    return kinematics(estimate.chosen.solution, estimate.chosen.alternatives, time_s).widened(widening)


def _with_flights(
    estimate: JointEstimate, setup: Setup, bounces_of: Bounced
) -> tuple[JointEstimate, Bounces | None, tuple[InputChange, ...] | None, FlightTest]:
    """Return the estimate, its bounces, what both change by with each input of the setup, and what its flights say."""
    # the far field bends the path by millimetres: no flight obeys gravity there, and the track gives the bounces
    if setup.processing.geometry != "exact":
        return estimate, None, None, FlightTest()
    try:
        responses = setup_responses(estimate, setup)
        bounces, fit = bounces_of(estimate, setup, responses)
        bounces, changes, test = joint_changes(estimate, bounces, fit, setup, responses)
    except SolveError as error:
        return estimate, None, None, FlightTest(bent=warn("flights_not_fitted", cause=why_of(error)))
    return estimate.widened(test.widening), bounces.widened(test.widening), changes, test


def _located(estimate: MotionEstimate, paths: PathLengths, setup: Setup) -> tuple[PathLengths, Track | None]:
    # the joint estimate knows the sphere as a body; the adaptive one's circles show the phase that it scatters with
    measured = is_delayed(setup) and not isinstance(estimate, JointEstimate)
    if estimate.position_m is None or estimate.u_position_m is None or measured:
        # the phase that the body adds is taken off the direct path (method 3)
        return locate_body(paths, setup)
    # the joint estimate's paths are those to the centre already
    return paths, track_of(estimate, paths, setup)
