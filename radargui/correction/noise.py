"""White noise of a channel from sixth differences."""

from __future__ import annotations

import numpy as np

from radargui.model.arrays import FloatArray

_SUM_OF_SQUARES = 924.0  # of the binomial coefficients 1 -6 15 -20 15 -6 1
_BLOCK = 64
_CALM = 3.0


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
    difference = np.diff(volts, n=6, axis=1)
    n_blocks = max(1, difference.shape[1] // _BLOCK)
    kept = difference[:, : n_blocks * _BLOCK]
    power = (kept.reshape(volts.shape[0], n_blocks, -1) ** 2).mean(axis=2)
    calm = power < _CALM * np.median(power, axis=1, keepdims=True)
    chosen = (power * calm).sum(axis=1) / calm.sum(axis=1)
    scale = np.median(np.abs(volts - np.median(volts, axis=1, keepdims=True)), axis=1)
    return np.asarray(np.maximum(np.sqrt(chosen / _SUM_OF_SQUARES), 1e-7 * scale + 1e-15))
