"""Names for the array types of arguments and results, and small helpers for long arrays.

A circular buffer that one thread writes and others read, without waiting for each other.
"""

from collections.abc import Iterator
from typing import Any, TypeAlias, TypeVar

import numpy as np
from numpy.typing import DTypeLike, NDArray

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


def runs_of(flags: BoolArray) -> IntArray:
    """Return where runs of True begin and end, one past the last, shape (n_runs, 2)."""
    return np.flatnonzero(np.diff(np.concatenate([[0], flags.astype(np.int8), [0]]))).reshape(-1, 2)


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


class CircularBuffer:
    """Columns by absolute index; the last `length` of them are held in memory allocated once.

    The writer never waits. It announces what it is about to overwrite, writes, then publishes the new end; a reader
    copies first and then drops what was announced meanwhile, so a copy never holds torn data (a sequence lock).

    Parameters
    ----------
    n_rows
        Rows of each column.
    length
        Columns held.
    dtype
        Type of the numbers.

    Attributes
    ----------
    length
        Columns held.
    end
        Absolute index after the last column.
    """

    def __init__(self, n_rows: int, length: int, dtype: DTypeLike) -> None:
        self.length = max(1, length)
        self._data: NDArray[Any] = np.empty((n_rows, self.length), dtype=dtype)
        # written, so that the system gives the memory now and not while samples come
        self._data.fill(0)
        self._announced = 0
        self.end = 0

    @property
    def first(self) -> int:
        """Absolute index of the oldest column that is safe to ask for."""
        return max(0, self._announced - self.length)

    def extend(self, columns: NDArray[Any]) -> None:
        """Append columns, shape (n_rows, n); one thread only."""
        count = columns.shape[1]
        end = self.end + count
        # before the first byte is overwritten: who copies meanwhile finds out afterwards
        self._announced = end
        kept = columns[:, max(0, count - self.length) :]
        begin = (end - kept.shape[1]) % self.length
        head = min(kept.shape[1], self.length - begin)
        self._data[:, begin : begin + head] = kept[:, :head]
        self._data[:, : kept.shape[1] - head] = kept[:, head:]
        # last: nobody asks for columns that are not written yet
        self.end = end

    def fill(self, count: int, value: float) -> None:
        """Append `count` columns of one value; one thread only."""
        self.extend(np.broadcast_to(np.asarray(value, self._data.dtype), (self._data.shape[0], count)))

    def pick(self, index: IntArray) -> tuple[IntArray, NDArray[Any]]:
        """Return what is held at ascending absolute indices: those indices, shape (n,), and a copy, shape (n_rows, n).

        This is cheaper than `copy` if few of many columns are wanted.
        """
        out = self._data[:, index % self.length]
        safe = index >= self.first
        return index[safe], out[:, safe]

    def copy(self, first: int, last: int) -> tuple[int, NDArray[Any]]:
        """Return what is held of columns first:last.

        Returns
        -------
        tuple
            Absolute index of the first column returned, and a copy of shape (n_rows, n), n from 0 to last - first.
        """
        last = min(last, self.end)
        first = max(first, self.first)
        if last <= first:
            return max(first, 0), self._data[:, :0].copy()
        begin = first % self.length
        head = min(last - first, self.length - begin)
        out = np.empty((self._data.shape[0], last - first), dtype=self._data.dtype)
        out[:, :head] = self._data[:, begin : begin + head]
        out[:, head:] = self._data[:, : last - first - head]
        # what was announced while copying may be half old, half new
        safe = self.first
        if safe > first:
            return min(safe, last), out[:, min(safe, last) - first :]
        return first, out
