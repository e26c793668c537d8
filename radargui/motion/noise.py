"""Noise of sampled voltages, from high differences that no smooth motion can imitate."""

from __future__ import annotations

import numpy as np

from radargui.model.arrays import FloatArray

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
    difference = np.abs(np.diff(volts, 6, axis=1))
    with np.errstate(invalid="ignore"):
        return np.asarray(np.nanmedian(difference, axis=1) / (0.674489750196 * np.sqrt(SIXTH_DIFFERENCE_GAIN)))


def block_means(volts: FloatArray, size: int) -> FloatArray:
    """Return the means of consecutive blocks of `size` samples, shape (n_channels, n_samples // size)."""
    count = volts.shape[1] // size
    return np.asarray(volts[:, : count * size].reshape(volts.shape[0], count, size).mean(axis=2))
