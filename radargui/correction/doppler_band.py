"""The correction in the Doppler band: the echo that conditioning followed, on the unit circle and with its quality."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from radargui.conditioning.conditioned import Conditioned
from radargui.correction.quality import assess
from radargui.model.arrays import BoolArray, FloatArray
from radargui.model.result import ChannelQuality


@dataclass(frozen=True, slots=True)
class InBand:
    """One receiver's echo in its Doppler band.

    Attributes
    ----------
    iq
        On the unit circle, shape (2, n_samples).
    phase_rad, u_phase_rad
        Unwrapped, and its standard uncertainty, shape (n_samples,).
    valid
        Where the echo leads, shape (n_samples,).
    quality
        Of the receiver.
    """

    iq: FloatArray
    phase_rad: FloatArray
    u_phase_rad: FloatArray
    valid: BoolArray
    quality: ChannelQuality


def correct_in_band(conditioned: Conditioned, number: int) -> InBand | None:
    """Correct one receiver by its echo in the Doppler band; None where too few frames show one.

    Parameters
    ----------
    conditioned
        All receivers.
    number
        The one, from 0.
    """
    echo = conditioned.echoes[number]
    if echo is None:
        return None
    unit = echo.wave / echo.amplitude_v
    iq = np.stack([unit.real, unit.imag])
    valid = echo.leads.copy()
    moving = slice(conditioned.segment.first, conditioned.segment.last)
    known = valid[moving]
    front_end = echo.front_end
    quality = assess(
        str(number + 1),
        iq=iq[:, moving],
        phase_rad=echo.phase_rad[moving],
        valid=known,
        noise=float(np.median(echo.u_phase_rad[moving][known])) if known.any() else 1.0,
        fraction_clipped=float(conditioned.unusable_share[number]),
        gain_ratio=front_end.gain_ratio,
        quadrature_error_deg=front_end.quadrature_error_deg,
        u_gain_ratio=front_end.u_gain_ratio,
        u_quadrature_error_deg=front_end.u_quadrature_error_deg,
    )
    # noise is known; what bends the circle is taken for phase as well, since nobody knows which it is
    u_phase = np.hypot(echo.u_phase_rad, quality.circularity or 0.0)
    return InBand(iq, echo.phase_rad, u_phase, valid, quality)
