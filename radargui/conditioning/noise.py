"""White noise of voltages, from high differences that no smooth motion can imitate; how much they move against it.

Method 2, Noise.
"""

from __future__ import annotations

import numpy as np

from radargui.model.arrays import FloatArray, held_beyond

SIXTH_DIFFERENCE_GAIN = 924.0
"""Sum of the squared binomial coefficients of order 6: variance of the sixth difference of unit white noise."""
LEAST_SAMPLES = 64
"""Of a channel: its noise is then known to 15 % (standard deviation over 500 draws of white noise)."""
_SIXTH_DIFFERENCE = np.array([1.0, -6.0, 15.0, -20.0, 15.0, -6.0, 1.0])  # binomial coefficients, signs by turns
_BLOCK = 64
"""Samples judged together: 2 ms at 33 kS/s, about as long as an impact rings in the sixth difference."""
_CALM = 3.0
"""A block with so many times the median power holds an impact or a glitch. Of white noise one block
in a thousand has 2.3 times."""
_LEAST_OF_SPAN = 1e-6
"""Of the channel's range: a simulated signal without noise keeps finite weights, a converter of 16 bit has 4e-6."""
_LEAST_V = 1e-12  # in V: a channel that shows one value only keeps finite weights, far below any converter's step


def white_noise_v(volts: FloatArray) -> FloatArray:
    """Return the standard deviation of each channel's white noise, sigma^2 = <(D^6 u)^2> / 924.

    Sixth differences remove every polynomial up to the fifth order. Blocks above three times the median power
    (impacts, glitches) are left out; below a millionth of the channel's range nothing is told from rounding.

    Parameters
    ----------
    volts
        Finite, shape (n_channels, n_samples).

    Returns
    -------
    FloatArray
        Volts, shape (n_channels,), above zero.
    """
    least = np.maximum(_LEAST_OF_SPAN * np.ptp(volts, axis=1), _LEAST_V)
    difference = sixth_differences(volts)
    if difference.shape[1] == 0:
        return np.asarray(least)
    n_blocks = max(1, difference.shape[1] // _BLOCK)
    length = difference.shape[1] // n_blocks
    kept = difference[:, : n_blocks * length].reshape(volts.shape[0], n_blocks, length)
    power = np.einsum("cbs,cbs->cb", kept, kept) / length
    # the median block is one without an impact, whatever the drop
    calm = power <= _CALM * np.median(power, axis=1, keepdims=True)
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


def block_means(volts: FloatArray, size: int) -> FloatArray:
    """Return the means of consecutive blocks of `size` samples, shape (n_channels, n_samples // size)."""
    count = volts.shape[1] // size
    # a product is several times as fast as `mean` over so few
    return np.asarray(volts[:, : count * size].reshape(volts.shape[0], count, size) @ np.full(size, 1.0 / size))


BLOCK_S = 0.0005
"""Averaging that still follows a Doppler of several hundred Hz."""
WINDOW_S = 0.02
"""Long enough to see the slow start of a fall, short enough to tell when."""


def block_size(sample_rate_hz: float) -> int:
    """Return how many samples one block of the activity averages."""
    return max(1, round(BLOCK_S * sample_rate_hz))


def window_blocks(sample_rate_hz: float) -> int:
    """Return how many blocks one window of the activity holds."""
    return max(8, round(WINDOW_S * sample_rate_hz / block_size(sample_rate_hz)))


def activity(volts: FloatArray, sample_rate_hz: float, noise_v: FloatArray) -> FloatArray:
    """Return the variance of block means in a sliding window over the variance that white noise gives them.

    About 1 where nothing moves; pooled over the channels, each in units of its own noise.

    Parameters
    ----------
    volts
        Finite, shape (n_channels, n_samples).
    sample_rate_hz
        Rate of each channel.
    noise_v
        White noise of each channel, shape (n_channels,), above zero.

    Returns
    -------
    FloatArray
        One value a block of `block_size` samples, shape (n_blocks,); the window is centred on the block.
    """
    size = block_size(sample_rate_hz)
    window = window_blocks(sample_rate_hz)
    # a mean of n samples has a noise smaller by sqrt(n)
    means = block_means(volts, size) * (np.sqrt(size) / noise_v)[:, None]
    if means.shape[1] <= window:
        # a record shorter than a window has one activity
        return np.full(means.shape[1], float(means.var(axis=1).mean()) if means.size else 0.0)
    return sliding_variance(means, window)


def sliding_variance(values: FloatArray, window: int) -> FloatArray:
    """Return the variance in a centred window, ends held, mean over the channels of `values` (n_channels, n): (n,)."""
    n_channels, n = values.shape
    centred = values - values.mean(axis=1, keepdims=True)
    total = np.zeros((n_channels + 1, n + 1))
    np.cumsum(centred, axis=1, out=total[1:, 1:])
    # of the squares only their sum over the channels counts
    np.cumsum(np.einsum("cn,cn->n", centred, centred), out=total[0, 1:])
    mean = (total[:, window:] - total[:, :-window]) / window
    variance = (mean[0] - np.einsum("cn,cn->n", mean[1:], mean[1:])) / n_channels
    return np.maximum(held_beyond(variance, window // 2, n), 0.0)
