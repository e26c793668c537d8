"""Names for the array types of arguments and results, and small helpers for long arrays."""

from collections.abc import Iterator
from functools import lru_cache
from typing import Any, TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

FloatArray: TypeAlias = NDArray[np.float64]
"""Real numbers; NaN means unknown."""
ComplexArray: TypeAlias = NDArray[np.complex128]
"""Complex numbers: phasors, scattering amplitudes."""
BoolArray: TypeAlias = NDArray[np.bool_]
IntArray: TypeAlias = NDArray[np.intp]
RawArray: TypeAlias = NDArray[np.int16] | NDArray[np.float64]
"""Samples as the device gave them: int16 codes or volts, shape (n_channels, n_samples)."""

_MEDIAN_TO_SD = 1.0 / 0.674489750196
"""Standard deviation of normal noise over the median of its absolute value."""
_PIECE = 1 << 14
"""Samples: so many stay in the processor's cache, and need little memory beside their result."""


def pieces(count: int, size: int = _PIECE) -> Iterator[slice]:
    """Yield slices of at most `size` that cover `count` samples."""
    for first in range(0, count, size):
        yield slice(first, min(first + size, count))


def pairs_of(volts: FloatArray) -> list[slice]:
    """Return the channels of each receiver, of rows I1, Q1, I2, ..."""
    return [slice(first, first + 2) for first in range(0, volts.shape[0], 2)]


def runs_of(flags: BoolArray) -> IntArray:
    """Return where runs of True begin and end, one past the last, shape (n_runs, 2)."""
    return np.flatnonzero(np.diff(np.concatenate([[0], flags.astype(np.int8), [0]]))).reshape(-1, 2)


def held_beyond(inner: FloatArray, first: int, n: int) -> FloatArray:
    """Return values that begin at sample `first` of n, the first and the last of them held before and after."""
    out = np.empty(n)
    out[:first], out[first : first + inner.size], out[first + inner.size :] = inner[0], inner, inner[-1]
    return out


def order_statistics(values: FloatArray, *shares: float) -> FloatArray:
    """Return those of the last axis (..., n) that shares of the others lie below, shape (..., n_shares).

    numpy's quantiles interpolate between two values, which takes most of their time for some thousand values.
    """
    place = [round(share * (values.shape[-1] - 1)) for share in shares]
    return np.asarray(np.partition(values, place, axis=-1)[..., place])


def median(values: FloatArray | IntArray, axis: int | None = None) -> FloatArray:
    """Return the median along an axis, of all values without one; NaN where any is, and of none.

    numpy's median loads masked arrays and takes twice as long for some hundred values.
    """
    rows = np.ravel(values) if axis is None else np.moveaxis(values, axis, -1)
    last = rows.shape[-1] - 1
    if last < 0:
        return np.full(rows.shape[:-1], np.nan)
    lower, upper = last // 2, (last + 1) // 2
    part = np.partition(rows, (lower, upper, last), axis=-1)
    # what is no number is sorted to the end
    return np.asarray(np.where(np.isnan(part[..., last]), np.nan, 0.5 * (part[..., lower] + part[..., upper])))


def robust_sd(values: FloatArray) -> float:
    """Return the standard deviation of noise of mean zero by the median of its size, NaN of no values.

    0.6745 is the median of |x| of normal noise of deviation one. Outliers do not move the median.
    """
    return _MEDIAN_TO_SD * float(median(np.abs(values)))


@lru_cache(maxsize=64)
def even_transform_size(wanted: float) -> int:
    """Return the even number nearest to the one wanted whose Fourier transform is fast: factors 2, 3 and 5 alone."""
    near = range(2 * int(0.45 * wanted), 2 * int(0.55 * wanted) + 4, 2)
    return min((size for size in near if size and _is_smooth(size)), key=lambda size: abs(size - wanted))


def _is_smooth(size: int) -> bool:
    for factor in (2, 3, 5):
        while size % factor == 0:
            size //= factor
    return size == 1


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
    # fmin and fmax: one lost sample must not hide its whole bin
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
    kept = np.zeros(values.size, dtype=np.bool_)
    kept[[0, -1]] = kept[np.flatnonzero(np.isnan(low)) * size] = True
    for end in (low, high):
        at = np.flatnonzero(values == end[bins])
        kept[at[np.diff(bins[at], prepend=-1) > 0]] = True
    return np.flatnonzero(kept)
