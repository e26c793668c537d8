"""Lowest and highest of each bin: many samples become few points, and no peak is hidden."""

from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from radargui.model.arrays import FloatArray, IntArray

Samples = TypeVar("Samples", bound=NDArray[Any])


def lowest_and_highest(values: Samples, size: int, first_index: int = 0) -> tuple[Samples, Samples]:
    """Return the lowest and the highest value of each bin of `size` samples.

    Bins begin at multiples of `size` of the absolute index, so that those of a stream stay where they are whatever
    block its samples come in; the first and the last bin may hold fewer samples.

    Parameters
    ----------
    values
        Shape (..., n_samples); NaN is passed over.
    size
        Samples in a bin, at least 1.
    first_index
        Absolute index of the first sample.

    Returns
    -------
    tuple
        Lowest and highest, shape (..., n_bins) each; NaN where a bin holds no number.
    """
    count = values.shape[-1]
    if count == 0:
        return values, values
    offset = first_index % size
    # bins of the absolute index: a picture that scrolls does not flicker
    edges = np.maximum(np.arange(0, offset + count, size) - offset, 0)
    lowest: Any = np.fmin.reduceat(values, edges, axis=-1)
    highest: Any = np.fmax.reduceat(values, edges, axis=-1)
    return lowest, highest


def extremes(values: FloatArray, size: int) -> IntArray:
    """Return the indices of the lowest and the highest sample of each bin, and of both ends, in order.

    Parameters
    ----------
    values
        Shape (n_samples,); of a bin that holds no number, one sample is kept, so that a curve breaks there.
    size
        Samples in a bin.

    Returns
    -------
    IntArray
        At most 2 n_bins + 2 indices; all of them where a bin holds two samples at most.
    """
    if size <= 2:
        return np.arange(values.size, dtype=np.intp)
    if values.size == 0:
        return np.empty(0, dtype=np.intp)
    # the first sample of each bin that holds its extreme: where it stands, not only how high
    bins = np.arange(values.size) // size
    low, high = lowest_and_highest(values, size)
    kept = [np.array([0, values.size - 1]), np.flatnonzero(np.isnan(low)) * size]
    for end in (low, high):
        at = np.flatnonzero(values == end[bins])
        kept.append(at[np.diff(bins[at], prepend=-1) > 0])
    return np.unique(np.concatenate(kept)).astype(np.intp)
