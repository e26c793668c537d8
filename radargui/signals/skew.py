"""Bring all channels of a multiplexed converter to the time of channel 0."""

from functools import lru_cache

import numpy as np

from radargui.model.arrays import FloatArray
from radargui.motion.smoothing import weighed_sums

DEGREE = 5  # of the spline: quintic, its error grows with the sixth power of the frequency
REACH = 24
"""Samples on each side that a spline's value depends on by more than 1e-8: its influence falls by 0.43 a sample."""
MIN_WEIGHT = 1e-7
"""Of the samples beyond those that count, all together: a sixteenth of the last step of a converter of 20 bits."""


def remove_skew(volts: FloatArray, sample_rate_hz: float, delay_s: FloatArray, *, slow: bool = False) -> FloatArray:
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
    slow
        Whether a wave has 32 samples at least. A polynomial of sixth degree through seven of them is then within 3e-8
        of the wave, and three times as fast.

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
            middle, ends = _polynomial_weights(back) if slow else _weights(back), _end_weights(back)
            reach, values = middle.size // 2, volts[channel]
            out[channel, reach : n_samples - reach] = weighed_sums(values, middle)
            # at the ends the spline ends too
            out[channel, :REACH] = ends[:REACH] @ values[: 3 * REACH]
            out[channel, -REACH:] = ends[-REACH:] @ values[-3 * REACH :]
        else:
            out[channel] = _interpolated(volts[channel], back)
    return out


def _interpolated(values: FloatArray, back: float) -> FloatArray:
    """Return values (n, ...) so many samples earlier, same shape."""
    n = values.shape[0]
    index = np.arange(n, dtype=np.float64)
    # quintic: its error grows with the sixth power of the frequency, a cubic's with the fourth. Not-a-knot: the three
    # samples beside each end are no knots (de Boor 1978, ch. XIII)
    half = (DEGREE + 1) // 2
    knots = np.concatenate([np.zeros(DEGREE + 1), index[half:-half], np.full(DEGREE + 1, n - 1.0)])
    coefficients = np.linalg.solve(_basis(index, knots), values.reshape(n, -1))
    return np.asarray((_basis(index - back, knots) @ coefficients).reshape(values.shape))


def _basis(at: FloatArray, knots: FloatArray) -> FloatArray:
    """Return all B-splines at places (n,), those of the outermost pieces beyond them, shape (n, n_splines)."""
    n_splines = knots.size - DEGREE - 1
    span = np.clip(np.searchsorted(knots, at, side="right") - 1, DEGREE, n_splines - 1)
    # those that are not zero there, degree by degree (Cox 1972, de Boor 1972)
    values = [np.ones_like(at)]
    for degree in range(1, DEGREE + 1):
        saved, raised = np.zeros_like(at), []
        for k, lower in enumerate(values):
            right, left = knots[span + k + 1], knots[span + k + 1 - degree]
            share = lower / (right - left)
            raised.append(saved + (right - at) * share)
            saved = (at - left) * share
        values = [*raised, saved]
    out = np.zeros((at.size, n_splines))
    for k, value in enumerate(values):
        out[np.arange(at.size), span - DEGREE + k] = value
    return out


@lru_cache(maxsize=32)
def _weights(back: float) -> FloatArray:
    """Return the weights of the samples around the wanted one, of a long spline's middle, an odd number of them."""
    row = _interpolated(np.eye(6 * REACH + 1), back)[3 * REACH, 2 * REACH : 4 * REACH + 1]
    # those without which no sample changes by more than 1e-7 of the largest
    away = np.abs(row[:REACH][::-1]) + np.abs(row[REACH + 1 :])
    left_out = np.append(np.cumsum(away[::-1])[::-1], 0.0)
    reach = int(np.argmax(left_out < MIN_WEIGHT))
    return row[REACH - reach : REACH + reach + 1]


@lru_cache(maxsize=32)
def _polynomial_weights(back: float) -> FloatArray:
    """Return the weights of seven samples around the wanted one (Lagrange)."""
    place = np.arange(-3.0, 4.0)
    return np.linalg.solve(np.vander(place, increasing=True).T, (-back) ** np.arange(place.size))


@lru_cache(maxsize=32)
def _end_weights(back: float) -> FloatArray:
    """Return the weights of as many samples at an end that each of them is made of, shape (3 REACH, 3 REACH)."""
    return _interpolated(np.eye(3 * REACH), back)
