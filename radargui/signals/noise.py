"""Measure the white noise of voltages from high differences, which no smooth motion can imitate."""

from __future__ import annotations

import numpy as np

from radargui.model.arrays import FloatArray, median

SIXTH_DIFFERENCE_GAIN = 924.0
"""Sum of the squared binomial coefficients of order 6: variance of the sixth difference of unit white noise."""
MIN_SAMPLES = 64
"""Of a channel: its noise is then known to 15 % (standard deviation over 500 draws of white noise)."""
_SIXTH_DIFFERENCE = np.array([1.0, -6.0, 15.0, -20.0, 15.0, -6.0, 1.0])  # binomial coefficients, signs by turns
_BLOCK = 64
"""Samples judged together: 2 ms at 33 kS/s, about as long as an impact rings in the sixth difference."""
_CALM = 3.0
"""A block with so many times the median power holds an impact or a glitch. Of white noise one block
in a thousand has 2.3 times."""
_MIN_OF_SPAN = 1e-6
"""Of the channel's range: a simulated signal without noise keeps finite weights, a converter of 16 bit has 4e-6."""
_MIN_V = 1e-12  # in V: a channel that shows one value only keeps finite weights, far below any converter's step


def white_noise_v(volts: FloatArray) -> FloatArray:
    """Return the standard deviation of each channel's white noise, sigma^2 = <(D^6 u)^2> / 924.

    Sixth differences remove every polynomial up to the fifth order. Blocks above three times the median power
    (impacts, glitches) are left out; below a millionth of the channel's range nothing is distinguished from rounding.

    Parameters
    ----------
    volts
        Finite, shape (n_channels, n_samples).

    Returns
    -------
    FloatArray
        Volts, shape (n_channels,), above zero.
    """
    least = np.maximum(_MIN_OF_SPAN * np.ptp(volts, axis=1), _MIN_V)
    difference = sixth_differences(volts)
    if difference.shape[1] == 0:
        return np.asarray(least)
    n_blocks = max(1, difference.shape[1] // _BLOCK)
    length = difference.shape[1] // n_blocks
    kept = difference[:, : n_blocks * length].reshape(volts.shape[0], n_blocks, length)
    power = np.einsum("cbs,cbs->cb", kept, kept) / length
    # the median block is one without an impact, whatever the drop
    calm = power <= _CALM * median(power, axis=1)[:, None]
    # differences of white noise are correlated, but their mean square needs no independence
    variance = (power * calm).sum(axis=1) / calm.sum(axis=1) / SIXTH_DIFFERENCE_GAIN
    return np.asarray(np.maximum(np.sqrt(variance), least))


def sixth_differences(values: FloatArray) -> FloatArray:
    """Return the sixth differences of (n_channels, n_samples), shape (n_channels, n_samples - 6)."""
    out = np.empty((values.shape[0], max(values.shape[1] - 6, 0)))
    if out.size:
        for row, own in zip(values, out, strict=True):
            own[:] = np.correlate(row, _SIXTH_DIFFERENCE)
    return out
