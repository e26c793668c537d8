"""Weighed sums of neighbouring samples: interpolation and smoothing on evenly spaced samples are such sums."""

import numpy as np

from radargui.model.arrays import FloatArray

_SHORT, _FEW = 11, 48
"""Weights up to which numpy's `correlate` is several times as fast a weight, and up to which it pays to cut them."""


def weighed_sums(values: FloatArray, weights: FloatArray) -> FloatArray:
    """Return the weighed sums of as many samples in turn, out_n = sum over k of w_k values_(n + k).

    Parameters
    ----------
    values
        Shape (n_samples,).
    weights
        Shape (n_weights,), at most n_samples of them.

    Returns
    -------
    FloatArray
        Shape (n_samples - n_weights + 1,).
    """
    count = values.size - weights.size + 1
    total = np.zeros(count)
    length = _SHORT if weights.size <= _FEW else weights.size
    for first in range(0, weights.size, length):
        some = weights[first : first + length]
        total += np.correlate(values[first : first + count + some.size - 1], some, "valid")
    return total
