"""Noise of sampled voltages, from high differences that no smooth motion can imitate."""

from __future__ import annotations

import numpy as np

from radargui.model.arrays import FloatArray
from radargui.model.pieces import pieces

SIXTH_DIFFERENCE_GAIN = 924.0
"""Sum of the squared binomial coefficients of order 6: variance of the sixth difference of unit white noise."""


def white_noise_v(volts: FloatArray) -> FloatArray:
    """Return the standard deviation of white noise, sigma = median|d6 x| / (0.6745 sqrt(924)).

    The median keeps impacts and clipped samples out.

    Parameters
    ----------
    volts
        Shape (n_channels, n_samples), at least 7 samples; NaN are passed over.

    Returns
    -------
    FloatArray
        Volts, shape (n_channels,).
    """
    difference = sixth_differences(volts)
    np.abs(difference, out=difference)
    median = np.nanmedian if np.isnan(difference).any() else np.median
    return np.asarray(
        median(difference, axis=1, overwrite_input=True) / (0.674489750196 * np.sqrt(SIXTH_DIFFERENCE_GAIN))
    )


def sixth_differences(values: FloatArray) -> FloatArray:
    """Return the sixth differences of (n_channels, n_samples), shape (n_channels, n_samples - 6)."""
    out = np.empty((values.shape[0], max(values.shape[1] - 6, 0)))
    with np.errstate(invalid="ignore"):
        for part in pieces(out.shape[1]):
            out[:, part] = np.diff(values[:, part.start : part.stop + 6], 6, axis=1)
    return out


def block_means(volts: FloatArray, size: int) -> FloatArray:
    """Return the means of consecutive blocks of `size` samples, shape (n_channels, n_samples // size)."""
    count = volts.shape[1] // size
    return np.asarray(volts[:, : count * size].reshape(volts.shape[0], count, size).mean(axis=2))
