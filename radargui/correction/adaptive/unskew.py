"""Multiplexer skew: bring every channel's means to the time of channel 0."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from radargui.correction.bins import Bins
from radargui.correction.start import StillEllipse
from radargui.model.arrays import FloatArray


def unskew(
    bins: Bins, delay_s: FloatArray, phase_rad: FloatArray, amplitude: FloatArray, ellipses: Sequence[StillEllipse]
) -> FloatArray:
    """Return what each channel would have shown at the time of channel 0, shape (n_channels, n_bins).

    Channel k shows Z(t + d_k); the difference A (exp(j phi(t)) - exp(j phi(t + d_k))), brought through the receiver's
    gain ratio and quadrature error, is added to it.

    Parameters
    ----------
    bins
        The means as measured.
    delay_s
        d_k, shape (n_channels,).
    phase_rad, amplitude
        Current estimates, shape (n_receivers, n_bins).
    ellipses
        Hardware constants of each receiver.
    """
    value = bins.value.copy()
    if not delay_s.any():
        return value
    for receiver, ellipse in enumerate(ellipses):
        gain, sine, cosine = np.exp(ellipse.log_gain), np.sin(ellipse.skew_rad), np.cos(ellipse.skew_rad)
        for part in range(2):
            channel = 2 * receiver + part
            later = np.interp(bins.time_s + delay_s[channel], bins.time_s, phase_rad[receiver])
            change = amplitude[receiver] * (np.exp(1j * phase_rad[receiver]) - np.exp(1j * later))
            value[channel] += change.real if part == 0 else gain * (sine * change.real + cosine * change.imag)
    return value
