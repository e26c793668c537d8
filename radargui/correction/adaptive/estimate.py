"""The adaptive estimate of a recording: each receiver on its own circle, fast, one to four receivers."""

from __future__ import annotations

import numpy as np

from radargui.correction.adaptive.found import Found, adaptive_rounds
from radargui.correction.adaptive.samples import circles_at_samples
from radargui.correction.estimate import MotionEstimate
from radargui.correction.hardware import HardwareConstants
from radargui.correction.signals import Signals
from radargui.correction.verdict import judge_channels
from radargui.geometry.bistatic import locate_exact, position_uncertainty
from radargui.model.arrays import FloatArray
from radargui.model.recording import Recording
from radargui.model.setup import Setup

_U_IMPACT_S = 1e-4


def estimate_adaptive(recording: Recording, setup: Setup, found: Found | None = None) -> MotionEstimate:
    """Correct each receiver by a circle whose centre and radius are functions of position.

    Parameters
    ----------
    recording, setup
        One to four receivers; positions need three.
    found
        The rounds, where they are known already.

    Raises
    ------
    ProcessingError
        No motion.
    """
    found = found or adaptive_rounds(recording, setup)
    signals, ground, last = found.signals, found.ground, found.last
    samples = circles_at_samples(found, signals)
    change = samples.phase_rad * ground.wavelength_m / (2.0 * np.pi)
    u_change = samples.u_phase_rad * ground.wavelength_m / (2.0 * np.pi)
    rest = signals.time_s < found.start_s
    change[:, rest] = 0.0
    position = u_position = None
    if ground.antennas.n_receivers >= 3:
        start = np.array([np.interp(signals.time_s, ground.bins.time_s, row) for row in last.place])
        position = locate_exact(change, ground.antennas, ground.release_m, start)
        u_position = position_uncertainty(position, u_change, ground.antennas)
    constants = tuple(_constants(found, signals, n) for n in range(ground.antennas.n_receivers))
    chi_square = np.array([fit.chi_square for fit in last.fits])
    valid = np.broadcast_to(signals.usable, change.shape) & np.isfinite(change)
    clipped = (
        recording.clipped()[: 2 * signals.n_receivers].reshape(signals.n_receivers, 2, -1).any(axis=1).mean(axis=1)
    )
    channels = judge_channels(
        np.median(last.amplitude, axis=1),
        signals.sigma.reshape(-1, 2).mean(axis=1),
        samples.i,
        samples.q,
        valid,
        change,
        ground.wavelength_m,
        ~rest,
        clipped,
        chi_square,
        constants,
    )
    return MotionEstimate(
        "adaptive",
        signals.time_s,
        change,
        u_change,
        samples.i,
        samples.q,
        valid,
        position,
        u_position,
        found.onset_s,
        found.impact_s,
        np.full(found.impact_s.size, _U_IMPACT_S),
        constants,
        channels,
        chi_square,
        _choices(found),
    )


def _constants(found: Found, signals: Signals, receiver: int) -> HardwareConstants:
    fit, scale = found.last.fits[receiver], float(signals.scale_v[receiver])
    u = np.sqrt(np.diag(fit.covariance) * max(1.0, fit.chi_square))
    bias: FloatArray = np.zeros(2)
    if found.last.bias is not None:
        n = found.last.bias.size
        mean = found.last.bias(found.last.place).mean(axis=0)
        bias = np.array([mean @ fit.theta[5 : 5 + n], mean @ fit.theta[5 + n : 5 + 2 * n]])
    gain, sign = float(np.exp(fit.theta[2])), signals.phase_sign
    return HardwareConstants(
        gain,
        gain * float(u[2]),
        sign * float(np.degrees(fit.theta[3])),
        float(np.degrees(u[3])),
        (scale * float(fit.theta[0] + bias[0]), sign * scale * float(fit.theta[1] + bias[1])),
        (scale * float(u[0]), scale * float(u[1])),
    )


def _choices(found: Found) -> tuple[str, ...]:
    if found.last.bias is None:
        return ()
    where = "position" if found.ground.antennas.n_receivers >= 3 else "path length"
    return (f"Maps of {where} with a correlation length of {found.last.bias.length_m:.2f} m.",)
