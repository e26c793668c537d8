"""Activity: how much the voltages move within a short window, against what noise alone would do."""

from __future__ import annotations

import numpy as np

from radargui.conditioning.noise import block_means
from radargui.model.arrays import FloatArray, held_beyond

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
