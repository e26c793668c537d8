"""White noise of a channel from sixth differences."""

from __future__ import annotations

import numpy as np

from radargui.model.arrays import FloatArray
from radargui.motion.noise import SIXTH_DIFFERENCE_GAIN, sixth_differences

_BLOCK = 64
_CALM = 3.0
_LEAST = 1e-7  # of the deviation, never more than the range


def noise_deviation(volts: FloatArray) -> FloatArray:
    """Return the standard deviation of each channel's white noise.

    Sixth differences remove every polynomial up to the fifth order: sigma^2 = <(D^6 u)^2> / 924. Blocks above
    three times the median (impacts, glitches) are left out.

    Parameters
    ----------
    volts
        Shape (n_channels, n_samples), at least 64 samples.

    Returns
    -------
    FloatArray
        Shape (n_channels,), above zero.
    """
    difference = sixth_differences(volts)
    n_blocks = max(1, difference.shape[1] // _BLOCK)
    kept = difference[:, : n_blocks * _BLOCK]
    power = (kept.reshape(volts.shape[0], n_blocks, -1) ** 2).mean(axis=2)
    calm = power < _CALM * np.median(power, axis=1, keepdims=True)
    chosen = (power * calm).sum(axis=1) / calm.sum(axis=1)
    sigma = np.sqrt(chosen / SIXTH_DIFFERENCE_GAIN)
    if (sigma > _LEAST * np.ptp(volts, axis=1) + 1e-15).all():
        return np.asarray(sigma)
    scale = np.median(np.abs(volts - np.median(volts, axis=1, keepdims=True)), axis=1)
    return np.asarray(np.maximum(sigma, _LEAST * scale + 1e-15))
