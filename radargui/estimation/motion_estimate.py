"""The result that every estimate hands on: motion, corrected IQ, uncertainties, constants, quality."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from radargui.correction.quality import LIMITS, assess
from radargui.estimation.signals import ScaledSignals
from radargui.model.arrays import BoolArray, FloatArray
from radargui.model.channel_quality import ChannelQuality
from radargui.model.front_end import FrontEnd

FEW_FRINGES, WIDEST, MIN_FRINGES = 3.0, 4.0, 0.1
"""u is widened by sqrt(1 + (few / F)^2), at most by the second, for a receiver that saw F fringes (standing still: the
third): below some the posterior of one model is too narrow (pendulums and level circles of benchmark accuracy)."""


@dataclass(frozen=True, slots=True)
class MotionEstimate:
    """The motion and the corrected IQ of one recording.

    Attributes
    ----------
    method
        adaptive or joint.
    time_s
        Shape (n_samples,).
    change_m, u_change_m
        Change of each path length against the rest, shape (n_receivers, n_samples); NaN where unknown.
    i, q
        On the unit circle, at the time of channel 0, shape (n_receivers, n_samples).
    valid
        Shape (n_receivers, n_samples).
    position_m, u_position_m
        Shape (3, n_samples); None with fewer than three receivers.
    onset_s
        End of the rest.
    impact_s
        Instants of the impacts, shape (n_impacts,).
    constants, channels
        One a receiver.
    chi_square
        Mean squared residual in units of the measured noise, one a receiver, shape (n_receivers,).
    choices
        What the evidence chose, one sentence each.
    """

    method: str
    time_s: FloatArray = field(repr=False)
    change_m: FloatArray = field(repr=False)
    u_change_m: FloatArray = field(repr=False)
    i: FloatArray = field(repr=False)
    q: FloatArray = field(repr=False)
    valid: BoolArray = field(repr=False)
    position_m: FloatArray | None = field(repr=False)
    u_position_m: FloatArray | None = field(repr=False)
    onset_s: float
    impact_s: FloatArray
    constants: tuple[FrontEnd, ...]
    channels: tuple[ChannelQuality, ...]
    chi_square: FloatArray
    choices: tuple[str, ...]

    @property
    def fits(self) -> bool:
        """Whether the misfit is small enough in every receiver: else a simpler correction must stand in."""
        return bool((self.chi_square <= LIMITS.max_misfit).all())


def few_fringes_factor(phase_rad: FloatArray) -> FloatArray:
    """Return by how much the uncertainties of receivers grow that saw few fringes, phases (n_receivers, n)."""
    # a short arc fits many circles: below some fringes Laplace's Gaussian is narrower than what is possible
    span = np.maximum(np.ptp(phase_rad, axis=1) / (2.0 * np.pi), MIN_FRINGES)
    return np.asarray(np.minimum(np.sqrt(1.0 + (FEW_FRINGES / span) ** 2), WIDEST))


def channel_qualities(
    signals: ScaledSignals,
    moving: BoolArray,
    iq: tuple[FloatArray, FloatArray],
    valid: BoolArray,
    phase_rad: FloatArray,
    amplitude: FloatArray,
    counted_noise: FloatArray,
    chi_square: FloatArray,
    constants: tuple[FrontEnd, ...],
) -> tuple[ChannelQuality, ...]:
    """Return the quality of each receiver in the motion.

    Parameters
    ----------
    signals
        What was estimated from.
    moving
        Samples of the motion, shape (n_samples,).
    iq, valid, phase_rad
        On the unit circle, shapes (n_receivers, n_samples).
    amplitude
        Typical one, in the unit of the signals, shape (n_receivers,).
    counted_noise
        Noise of a bin of one channel, in the same unit, shape (n_receivers,).
    chi_square, constants
        As in `MotionEstimate`.
    """
    # of one channel, over the typical amplitude: 10 log10(A^2 / 2 sigma^2) is the SNR
    noise = signals.sigma.reshape(-1, 2).mean(axis=1) / amplitude
    found = (
        assess(
            str(n + 1),
            iq=np.stack([iq[0][n, moving], iq[1][n, moving]]),
            phase_rad=phase_rad[n, moving],
            valid=valid[n, moving],
            noise=float(noise[n]),
            counted_noise=float(counted_noise[n] / amplitude[n]),
            fraction_clipped=float(signals.unusable_share[n]),
            gain_ratio=own.gain_ratio,
            quadrature_error_deg=own.quadrature_error_deg,
            u_gain_ratio=own.u_gain_ratio,
            u_quadrature_error_deg=own.u_quadrature_error_deg,
            chi_square=float(chi_square[n]),
        )
        for n, own in enumerate(constants)
    )
    return tuple(
        replace(one, harmonics=own.harmonics, u_harmonics=own.u_harmonics)
        for one, own in zip(found, constants, strict=True)
    )
