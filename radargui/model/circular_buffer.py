"""A circular buffer that one thread writes and others read, without waiting for each other."""

from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from radargui.model.arrays import IntArray


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
