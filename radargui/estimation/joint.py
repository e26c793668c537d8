"""The joint estimate of a recording: motion and mismatch from all channels together."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from radargui.estimation.adaptive.found import AdaptiveRounds
from radargui.estimation.forward.slow_noise import measure_drift
from radargui.estimation.hardware import as_prior
from radargui.estimation.motion_estimate import MotionEstimate, channel_qualities
from radargui.estimation.posterior.motion_posterior import AlternativeMotion, MotionPosterior
from radargui.estimation.posterior.samples import AtSamples, at_samples
from radargui.estimation.select.choose import choose_model
from radargui.estimation.select.chosen_model import ChosenModel
from radargui.estimation.select.converge import LAST, converge
from radargui.estimation.select.fall import FoundFall
from radargui.estimation.signals import ScaledSignals, composed, remaining
from radargui.estimation.solve.break_velocities import break_speeds
from radargui.estimation.solve.held_setup import with_antennas_of, with_setup_moved
from radargui.estimation.solve.minimise import chi_square, minimise
from radargui.estimation.solve.problem import State
from radargui.model.errors import ProcessingError
from radargui.model.finding import error_of
from radargui.model.front_end import FrontEnd
from radargui.model.setup import Setup
from radargui.model.setup_posterior import SetupLikelihood
from radargui.physics.path_length import MIN_RECEIVERS

_STAGES = {"floor": (0.0, 0.35, 12), "flights": (0.35, 0.42, 4), "walls": (0.42, 0.84, 40), "last": (0.84, 0.98, 3)}
"""Where on the bar each stage of `choose_model` begins and ends, and its rounds: between drops without a wall, where
floor and breaks take two thirds of the time and walls 16 rounds, and those with one: three quarters and 70 to 85."""
_EVEN = 0.7  # share of a stage over which each round counts alike; those beyond the typical number share the rest
_WIDENED = 1.5
"""Factor on u of gain ratio and quadrature error (method 6): by it first posteriors had 95 to 99 % inside 2u."""
_UNTRUSTED = 9.0  # local chi-square above which a sample is not valid: three times the noise (method 6, Quality)


@dataclass(frozen=True, slots=True)
class JointEstimate(MotionEstimate):
    """A motion estimate with its posterior.

    Attributes
    ----------
    chosen
        The solution and what was chosen on the way.
    posterior
        What flights and restitution are fitted on.
    alternatives
        Other motions that the evidence does not rule out.
    """

    chosen: ChosenModel = field(repr=False)
    posterior: MotionPosterior = field(repr=False)
    alternatives: tuple[AlternativeMotion, ...] = field(repr=False)

    def widened(self, factor: float) -> JointEstimate:
        """Return it with the uncertainties of paths and positions times a factor."""
        u_position = None if self.u_position_m is None else factor * self.u_position_m
        return replace(self, u_change_m=factor * self.u_change_m, u_position_m=u_position)


def estimate_joint(
    found: AdaptiveRounds | FoundFall,
    setup: Setup,
    *,
    hardware: tuple[FrontEnd, ...] | None = None,
    progress: Callable[[float], None] | None = None,
) -> JointEstimate:
    """Estimate motion and mismatch of a recording together.

    Parameters
    ----------
    found
        A drop by its flights, or the adaptive rounds, of three or four receivers.
    setup
        Its floor's normal.
    hardware
        Constants found before (`pool_constants`), prior of this run; None where nothing is known.
    progress
        Called between rounds with the share done, 0 to 1: nobody knows how many there will be, each stage has its
        measured share of the time. What it raises, as `CancelledError`, ends the work.

    Raises
    ------
    ProcessingError
        Fewer than three receivers, no rest before the motion.
    """
    signals = found.signals
    if signals.n_receivers < MIN_RECEIVERS:
        remedy = 'Choose correction = "adaptive" for one or two.'
        raise error_of(ProcessingError, "joint_needs_three_receivers", remedy=remedy)
    stage, done = "floor", 0

    def entered(name: str) -> None:
        nonlocal stage, done
        stage, done = name, 0

    def round_done() -> None:
        nonlocal done
        done += 1
        if progress is not None:
            progress(_share_done(stage, done))

    if not signals.has_rest:
        late = ("the trigger came late",)
        raise error_of(ProcessingError, "starts_in_motion", reasons=late, remedy="Record 0.1 s of rest first.")
    round_done()
    prior = None if hardware is None else as_prior(remaining(hardware, signals))
    drift = measure_drift(signals, signals.rest_end_s)
    chosen = choose_model(found, drift, np.asarray(setup.floor.normal), round_done, prior, entered=entered)
    values = at_samples(chosen.solution, signals, chosen.alternatives)
    if progress is not None:
        progress(1.0)
    return estimate_of_model(setup, signals, chosen, values)


def with_setup_known(
    estimate: JointEstimate, found: AdaptiveRounds | FoundFall, setup: Setup, others: SetupLikelihood
) -> JointEstimate:
    """Return an estimate with what other runs say of antennas, release and wavelength, beside what it says itself.

    Parameters
    ----------
    estimate
        Of the run alone, made from what was found with this setup.
    found, setup
        As for `estimate_joint`.
    others
        What they say.

    Raises
    ------
    SolveError
        The normal matrix cannot be factored.
    """
    chosen, unknowns = estimate.chosen, found.data.setup
    if chosen.setup is None or unknowns is None:
        return estimate
    posterior = chosen.setup.with_others(others)
    by, was = posterior.mean - chosen.setup.mean, chosen.solution
    moved = converge(with_setup_moved(was, unknowns, by), 4, lambda: None, LAST)
    alternatives = []
    for one in chosen.alternatives:
        if one.solution.normal is was.normal:
            # what unseen mirrors move was linearised where the best is
            state = State(
                moved.state.coefficients + one.solution.state.coefficients - was.state.coefficients,
                moved.state.theta + one.solution.state.theta - was.state.theta,
            )
            alternatives.append(replace(one, solution=replace(moved, state=state)))
        else:
            # the same antennas for all: the others say where they stand, whatever reflects
            start = with_antennas_of(one.solution, moved)
            alternatives.append(replace(one, solution=minimise(start, LAST.steps, LAST.minimise)))
    chosen = replace(chosen, solution=moved, alternatives=tuple(alternatives), setup=posterior)
    signals = found.signals
    return estimate_of_model(setup, signals, chosen, at_samples(chosen.solution, signals, chosen.alternatives))


def _share_done(stage: str, rounds: int) -> float:
    """Return the share of the work that is done after some rounds of a stage."""
    begin, end, typical = _STAGES[stage]
    over = max(0.0, rounds / typical - _EVEN)
    share = min(rounds / typical, _EVEN) + (1.0 - _EVEN) * (1.0 - float(np.exp(-over / (1.0 - _EVEN))))
    return begin + (end - begin) * share


def estimate_of_model(setup: Setup, signals: ScaledSignals, chosen: ChosenModel, values: AtSamples) -> JointEstimate:
    """Return the estimate that a chosen model and its values at the samples make."""
    solution = chosen.solution
    normal = np.asarray(setup.floor.normal)
    speeds = break_speeds(solution, normal)
    impacts = speeds.are_impacts()
    # a body comes to rest by bounces that are too short to be followed
    unseen_m = 0.0 if solution.problem.in_flight[-1] else speeds.bouncing_on_m(signals.time_s)
    constants = composed(_constants(chosen), signals)
    misfit = chi_square(solution)
    # where the model does not fit a sample is no evidence of a place
    valid = (values.misfit < _UNTRUSTED) & signals.usable
    amplitude = np.array([np.median(np.abs(signal.direct)) for signal in solution.at.signals])
    channels = channel_qualities(
        signals,
        signals.time_s >= signals.onset_s,
        (values.i, values.q),
        valid,
        values.change_m * (2.0 * np.pi / setup.radar.wavelength_m),
        amplitude,
        solution.problem.bins.typical_sigma,
        misfit,
        constants,
    )
    posterior = MotionPosterior(solution, signals.onset_s)
    # what unseen mirrors move was linearised where the best is
    others = tuple(
        AlternativeMotion(
            MotionPosterior(
                one.solution, signals.onset_s, posterior if one.solution.normal is solution.normal else None
            ),
            one.weight,
        )
        for one in chosen.alternatives
    )
    return JointEstimate(
        "joint",
        signals.time_s,
        values.change_m,
        # a path is a way there and a way back: where a body is off, it is off by up to twice as much
        np.hypot(values.u_change_m, 2.0 * unseen_m),
        values.i,
        values.q,
        valid,
        values.position_m,
        np.hypot(values.u_position_m, np.abs(normal)[:, None] * unseen_m),
        signals.onset_s,
        speeds.time_s[impacts],
        constants,
        channels,
        misfit,
        chosen.choices,
        chosen,
        posterior,
        others,
    )


def _constants(chosen: ChosenModel) -> tuple[FrontEnd, ...]:
    """Return gain ratio and quadrature error, one a receiver, uncertainties widened by `_WIDENED`."""
    solution = chosen.solution
    theta, variance = solution.state.theta, solution.normal.global_variances()
    u = _WIDENED * np.sqrt(np.maximum(variance, 0.0))
    out = []
    for own in solution.problem.layout.receivers:
        gain, angle = float(np.exp(theta[own.log_gain])), float(np.degrees(theta[own.quadrature_error]))
        u_gain, u_angle = gain * float(u[own.log_gain]), float(np.degrees(u[own.quadrature_error]))
        harmonics, u_harmonics = (tuple(values[own.harmonics].tolist()) for values in (theta, u))
        out.append(FrontEnd(gain, u_gain, angle, u_angle, harmonics, u_harmonics))
    return tuple(out)
