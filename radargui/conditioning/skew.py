"""Multiplexer skew: all channels brought to the time of channel 0."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import make_interp_spline

from radargui.model.arrays import FloatArray

DEGREE = 5


def remove_skew(volts: FloatArray, sample_rate_hz: float, delay_s: FloatArray) -> FloatArray:
    """Interpolate each channel back by its delay with a quintic spline.

    A channel is sampled at n / rate + delay; its value at n / rate is wanted. Without this the skew is a quadrature
    error that grows with speed, 2 pi f_doppler skew.

    Parameters
    ----------
    volts
        Finite, shape (n_channels, n_samples).
    sample_rate_hz
        Rate of each channel.
    delay_s
        Delay of each channel against channel 0, shape (n_channels,).

    Returns
    -------
    FloatArray
        Volts, same shape; the first sample of the later channels is extrapolated by a fraction of a sample.
    """
    if not delay_s.any() or volts.shape[1] <= DEGREE:
        return volts
    out = volts.copy()
    index = np.arange(volts.shape[1], dtype=np.float64)
    # quintic: its error grows with the sixth power of the frequency, a cubic's with the fourth
    for channel in np.flatnonzero(delay_s):
        out[channel] = make_interp_spline(index, volts[channel], DEGREE)(index - delay_s[channel] * sample_rate_hz)
    return out
