"""Multiplexer skew: all channels brought to the time of channel 0."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import make_interp_spline

from radargui.model.arrays import FloatArray

DEGREE = 5


def remove_skew(volts: FloatArray, sample_rate_hz: float, channel_skew_s: float) -> FloatArray:
    """Interpolate channel k back by k x skew with a quintic spline.

    Channel k is sampled at n / rate + k skew; its value at n / rate is wanted. Without this the skew is a quadrature
    error that grows with speed, 2 pi f_doppler skew.

    Parameters
    ----------
    volts
        Finite, shape (n_channels, n_samples).
    sample_rate_hz
        Rate of each channel.
    channel_skew_s
        Delay of channel k against channel k - 1.

    Returns
    -------
    FloatArray
        Volts, same shape; the first sample of the later channels is extrapolated by a fraction of a sample.
    """
    if channel_skew_s == 0.0 or volts.shape[1] <= DEGREE:
        return volts
    out = volts.copy()
    index = np.arange(volts.shape[1], dtype=np.float64)
    for channel in range(1, volts.shape[0]):
        delay = channel * channel_skew_s * sample_rate_hz
        out[channel] = make_interp_spline(index, volts[channel], DEGREE)(index - delay)
    return out
