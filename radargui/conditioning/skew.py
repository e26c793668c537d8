"""Multiplexer skew: all channels brought to the time of channel 0."""

from functools import cache

import numpy as np
from scipy.interpolate import make_interp_spline
from scipy.ndimage import correlate1d

from radargui.model.arrays import FloatArray

DEGREE = 5
REACH = 24
"""Samples on each side that a spline's value depends on by more than 1e-8: its influence falls by 0.43 a sample."""


def remove_skew(volts: FloatArray, sample_rate_hz: float, delay_s: FloatArray) -> FloatArray:
    """Interpolate each channel back by its delay with a quintic spline.

    A channel is sampled at n / rate + delay; its value at n / rate is wanted. Without this the skew is a quadrature
    error that grows with speed, 2 pi f_doppler skew. The spline through evenly spaced samples, taken at one distance
    from each, is a weighted sum of its neighbours (Unser 1999): eight times as fast as the spline itself.

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
    n_samples = volts.shape[1]
    if not delay_s.any() or n_samples <= DEGREE:
        return volts
    out = volts.copy()
    for channel in np.flatnonzero(delay_s):
        back = float(delay_s[channel] * sample_rate_hz)
        if n_samples > 4 * REACH:
            correlate1d(volts[channel], _weights(back), output=out[channel])
            # at the ends the spline ends too
            out[channel, :REACH] = _interpolated(volts[channel, : 3 * REACH], back)[:REACH]
            out[channel, -REACH:] = _interpolated(volts[channel, -3 * REACH :], back)[-REACH:]
        else:
            out[channel] = _interpolated(volts[channel], back)
    return out


def _interpolated(values: FloatArray, back: float) -> FloatArray:
    """Return values so many samples earlier, shape (n,)."""
    # quintic: its error grows with the sixth power of the frequency, a cubic's with the fourth
    index = np.arange(values.size, dtype=np.float64)
    return np.asarray(make_interp_spline(index, values, DEGREE)(index - back))


@cache
def _weights(back: float) -> FloatArray:
    """Return the weights of the samples -REACH ... REACH around the wanted one, of a long spline's middle."""
    impulses = np.eye(6 * REACH + 1)[:, 2 * REACH : 4 * REACH + 1]
    index = np.arange(6 * REACH + 1, dtype=np.float64)
    return np.asarray(make_interp_spline(index, impulses, DEGREE)(3.0 * REACH - back))
