"""Names for the array types of arguments and results, and small helpers for long arrays.

Compute weighed sums of neighbouring samples, which interpolation and smoothing of even samples are. A circular buffer
that one thread writes and others read, without waiting for each other.
"""

from collections.abc import Iterator
from functools import lru_cache
from typing import Any, TypeAlias, TypeVar

import numpy as np
from numpy.polynomial import legendre
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


_SHORT, _FEW, _MANY = 11, 48, 256
"""Weights up to which numpy's `correlate` is several times as fast a weight, up to which it pays to cut them, and from
which Fourier transforms are faster."""
_PARTS = 8  # so many times as long as the weights are pieces that are transformed, at the least; chosen by hand


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
    if weights.size >= _MANY:
        return _by_transform(values, weights)[:count]
    total = np.zeros(count)
    length = _SHORT if weights.size <= _FEW else weights.size
    for first in range(0, weights.size, length):
        some = weights[first : first + length]
        total += np.correlate(values[first : first + count + some.size - 1], some, "valid")
    return total


def _by_transform(values: FloatArray, weights: FloatArray) -> FloatArray:
    """Return the sums, and some more behind them, from overlapping pieces (overlap-save, Oppenheim & Schafer 8.7).

    scipy's `oaconvolve` does the same, but loading `scipy.signal` takes half a second.
    """
    length = 1 << int(np.ceil(np.log2(_PARTS * weights.size)))
    step = length - weights.size + 1
    padded = np.zeros((-(-values.size // step) - 1) * step + length)
    padded[: values.size] = values
    pieces = np.lib.stride_tricks.sliding_window_view(padded, length)[::step]
    # sums, not a convolution: the weights are not turned round
    filtered = np.fft.rfft(pieces, axis=1) * np.fft.rfft(weights, length).conj()
    return np.asarray(np.fft.irfft(filtered, length, axis=1)[:, :step].ravel())


def savitzky_golay(x: FloatArray, window: int, *, derivative: int = 0, spacing: float = 1.0) -> FloatArray:
    """Return a least-squares parabola around each sample along the last axis (Savitzky & Golay 1964).

    At the ends that of the first or the last window.

    Parameters
    ----------
    x
        Shape (..., n_samples).
    window
        Odd number of samples, at most n_samples.
    derivative, spacing
        Which derivative to give, and the distance of the samples for it.
    """
    half, unit = window // 2, spacing**derivative
    fit, values = _parabolas(window, derivative)
    weights = np.asarray(values[half] @ fit) / unit
    rows = [weighed_sums(row, weights) for row in x.reshape(-1, x.shape[-1])]
    middle = np.stack(rows).reshape(*x.shape[:-1], -1)
    begin, end = x[..., :window] @ fit.T @ values[:half].T, x[..., -window:] @ fit.T @ values[half + 1 :].T
    return np.asarray(np.concatenate([begin / unit, middle, end / unit], axis=-1), dtype=np.float64)


@lru_cache(maxsize=8)
def _parabolas(window: int, derivative: int) -> tuple[FloatArray, FloatArray]:
    """Return what fits a parabola to a window's samples, (3, window), and its derivative at each of them."""
    half = max(window // 2, 1)
    place = np.arange(-half, half + 1) / half
    # Legendre's: powers of the place would be nearly alike
    columns = legendre.legvander(place, 2)
    slopes = [legendre.legder(unit, derivative) for unit in np.eye(3)]
    values = np.stack([legendre.legval(place, slope) for slope in slopes], axis=1) / half**derivative
    return np.asarray(np.linalg.pinv(columns), dtype=np.float64), np.asarray(values, dtype=np.float64)


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
