"""The joint estimate of a recording: motion and mismatch from all channels together."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from radargui.correction.adaptive.found import Found, adaptive_rounds
from radargui.correction.estimate import MotionEstimate
from radargui.correction.hardware import HardwareConstants, front_end_prior
from radargui.correction.joint.breaks import break_speeds
from radargui.correction.joint.choose import Chosen, choose_model
from radargui.correction.joint.drift import measure_drift
from radargui.correction.joint.minimise import chi_square
from radargui.correction.joint.samples import AtSamples, at_samples
from radargui.correction.signals import Signals
from radargui.correction.verdict import judge_channels
from radargui.model.errors import ProcessingError
from radargui.model.front_end import FrontEnd
from radargui.model.recording import Recording
from radargui.model.setup import Setup

_TYPICAL_ROUNDS = 20
_UNTRUSTED = 9.0


@dataclass(frozen=True, slots=True)
class JointEstimate(MotionEstimate):
    """A motion estimate with its posterior.

    Attributes
    ----------
    chosen
        Solution with the factored normal matrix: what flights and restitution are fitted on.
    """

    chosen: Chosen = field(repr=False)


def estimate_joint(
    recording: Recording,
    setup: Setup,
    *,
    found: Found | None = None,
    hardware: tuple[FrontEnd, ...] | None = None,
    progress: Callable[[float], None] | None = None,
) -> JointEstimate:
    """Estimate motion and mismatch of a recording together.

    Parameters
    ----------
    recording, setup
        Three or four receivers.
    found
        The adaptive rounds, where they are known already.
    hardware
        Constants found before (`pool_constants`), prior of this run; None where nothing is known.
    progress
        Called between rounds with the share done, 0 to 1: nobody knows how many there will be, each takes a part of
        what is left. What it raises, as `CancelledError`, ends the work.

    Raises
    ------
    ProcessingError
        Fewer than three receivers, no motion, no rest before it.
    """
    if recording.n_receivers < 3:
        raise ProcessingError(
            "The joint correction needs three receivers.", remedy='Choose correction = "adaptive" for one or two.'
        )
    done = 0

    def tick() -> None:
        nonlocal done
        done += 1
        if progress is not None:
            progress(1.0 - math.exp(-done / _TYPICAL_ROUNDS))

    found = found or adaptive_rounds(recording, setup)
    if not found.has_rest:
        raise ProcessingError(
            "The recording starts in motion.", reasons=("the trigger came late",), remedy="Record 0.1 s of rest first."
        )
    tick()
    signals = found.signals
    prior = None if hardware is None else front_end_prior(hardware, signals.phase_sign)
    drift = measure_drift(signals, found.start_s)
    chosen = choose_model(found, drift, np.asarray(setup.floor.normal), tick, prior)
    values = at_samples(chosen.solution, signals, chosen.rivals)
    if progress is not None:
        progress(1.0)
    return _estimate(recording, setup, signals, found.onset_s, chosen, values)


def _estimate(
    recording: Recording, setup: Setup, signals: Signals, onset_s: float, chosen: Chosen, values: AtSamples
) -> JointEstimate:
    solution = chosen.solution
    speeds = break_speeds(solution, np.asarray(setup.floor.normal))
    impacts = speeds.are_impacts()
    breaks = solution.problem.layout.breaks
    u_breaks = np.sqrt(solution.normal.border_variances()[breaks])
    constants = _constants(chosen, signals)
    misfit = chi_square(solution)
    valid = (values.misfit < _UNTRUSTED) & signals.usable
    amplitude = np.array([np.median(np.abs(signal.direct)) for signal in solution.at.signals])
    clipped = (
        recording.clipped()[: 2 * signals.n_receivers].reshape(signals.n_receivers, 2, -1).any(axis=1).mean(axis=1)
    )
    channels = judge_channels(
        amplitude,
        signals.sigma.reshape(-1, 2).mean(axis=1),
        values.i,
        values.q,
        valid,
        values.change_m,
        setup.radar.wavelength_m,
        signals.time_s >= onset_s,
        clipped,
        misfit,
        constants,
    )
    return JointEstimate(
        "joint",
        signals.time_s,
        values.change_m,
        values.u_change_m,
        values.i,
        values.q,
        valid,
        values.position_m,
        values.u_position_m,
        onset_s,
        speeds.time_s[impacts],
        u_breaks[impacts],
        constants,
        channels,
        misfit,
        chosen.choices,
        chosen,
    )


def _constants(chosen: Chosen, signals: Signals) -> tuple[HardwareConstants, ...]:
    """Return gain ratio, quadrature error and mean offsets, uncertainties widened by the misfit and by 1.5."""
    solution = chosen.solution
    theta, variance = solution.state.theta, solution.normal.border_variances()
    u = 1.5 * np.sqrt(np.maximum(variance, 0.0))
    out = []
    for own, signal, scale in zip(solution.problem.layout.receivers, solution.at.signals, signals.scale_v, strict=True):
        gain = float(np.exp(theta[own.log_gain]))
        offset = scale * np.median(signal.besides, axis=1)
        u_offset = scale * u[own.offset]
        out.append(
            HardwareConstants(
                gain,
                gain * float(u[own.log_gain]),
                signals.phase_sign * float(np.degrees(theta[own.skew])),
                float(np.degrees(u[own.skew])),
                (float(offset[0]), signals.phase_sign * float(offset[1])),
                (float(u_offset[0]), float(u_offset[1])),
            )
        )
    return tuple(out)
