"""An estimate as what was measured: its flights, bounces and paths, held against their signals."""

from collections.abc import Callable

import numpy as np

from radargui.conditioning.conditioned import Conditioned
from radargui.estimation.joint import JointEstimate
from radargui.estimation.motion_estimate import MotionEstimate
from radargui.estimation.readout.kinematics import kinematics
from radargui.geometry.scattering import is_delayed
from radargui.model.errors import SolveError
from radargui.model.finding import warn, why_of
from radargui.model.result import Bounces, CorrectedIQ, Kinematics, PathLengths, Track, whole_milliseconds
from radargui.model.setup import Setup
from radargui.model.uncertainty_budget import InputChange
from radargui.processing.checks.estimate import is_fringe_sure
from radargui.processing.continuity import checked
from radargui.processing.locate import locate, locate_body
from radargui.processing.measured_motion import MeasuredMotion
from radargui.restitution.flight_fit import FlightFit
from radargui.restitution.flight_test import FlightTest
from radargui.restitution.input_changes import SetupResponses, joint_changes, setup_responses
from radargui.restitution.joint_bounces import joint_bounces


def motion_of_adaptive(
    estimate: MotionEstimate, conditioned: Conditioned, setup: Setup, *, is_tested: bool = False
) -> MeasuredMotion:
    """Return what circles found; `is_tested`: an estimate that follows tests it."""
    paths, track = _located(estimate, _paths_of(estimate, setup), setup)
    motion = MeasuredMotion(_corrected_of(estimate, setup), paths, track)
    return checked(motion, conditioned, setup.radar.wavelength_m, is_held=is_tested)


Bounced = Callable[[JointEstimate, Setup, SetupResponses], tuple[Bounces, FlightFit | None]]


def motion_of_joint(
    estimate: JointEstimate, conditioned: Conditioned, setup: Setup, bounces_of: Bounced = joint_bounces
) -> MeasuredMotion:
    """Return what the joint estimate found, its uncertainties widened by what its flights, bounces and g, say."""
    found = estimate.chosen.setup
    estimate, bounces, changes, flights = _with_flights(estimate, setup, bounces_of)
    paths, track = _located(estimate, _paths_of(estimate, setup), setup)
    # flights that do not fit bend antennas, too: other runs must not be told
    is_sound = estimate.chosen.solution.settled and flights.bent is None and flights.cause is None
    said = found.alone.widened(flights.widening) if found is not None and is_sound else None
    motion = MeasuredMotion(
        _corrected_of(estimate, setup),
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


def _paths_of(estimate: MotionEstimate, setup: Setup) -> PathLengths:
    # phase = 2 pi L / wavelength: estimates are in metres, the corrected IQ is shown in rad (method 1)
    phase = estimate.change_m * _rad_per_m(setup)
    return PathLengths(estimate.time_s, phase, estimate.change_m, estimate.u_change_m, estimate.valid)


def _corrected_of(estimate: MotionEstimate, setup: Setup) -> CorrectedIQ:
    samples = estimate.time_s, estimate.i, estimate.q, estimate.valid, estimate.u_change_m * _rad_per_m(setup)
    return CorrectedIQ(*samples, estimate.method, estimate.channels, decisions=estimate.choices)


def _rad_per_m(setup: Setup) -> float:
    return 2.0 * np.pi / setup.radar.wavelength_m


def _located(estimate: MotionEstimate, paths: PathLengths, setup: Setup) -> tuple[PathLengths, Track | None]:
    # the joint estimate knows the sphere as a body; the adaptive one's circles show the phase that it scatters with
    measured = is_delayed(setup) and not isinstance(estimate, JointEstimate)
    if estimate.position_m is None or estimate.u_position_m is None or measured:
        # the phase that the body adds is taken off the direct path (method 3)
        return locate_body(paths, setup)
    if setup.processing.geometry == "plane":
        # the joint estimate's paths are those to the centre already
        return paths, locate(paths, setup)
    valid = np.asarray(estimate.valid.all(axis=0) & np.isfinite(estimate.position_m).all(axis=0))
    return paths, Track(estimate.time_s, estimate.position_m, estimate.u_position_m, valid, "exact")
