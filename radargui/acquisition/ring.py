"""The ring: the last seconds of raw samples by absolute index; one thread writes, any thread copies, without a lock."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import DTypeLike, NDArray

from radargui.model.arrays import BoolArray, FloatArray
from radargui.model.block import Block
from radargui.model.digitisation import Digitisation


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
    end
        Absolute index after the last column.
    """

    def __init__(self, n_rows: int, length: int, dtype: DTypeLike) -> None:
        self._data: NDArray[Any] = np.empty((n_rows, max(1, length)), dtype=dtype)
        # written, so that the system gives the memory now and not while samples come
        self._data.fill(0)
        self._announced = 0
        self.end = 0

    @property
    def length(self) -> int:
        """Columns held."""
        return int(self._data.shape[1])

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


class RingSpan(NamedTuple):
    """Consecutive samples from the ring.

    Attributes
    ----------
    first_index
        Absolute index of the first column.
    volts
        Shape (n_channels, n); NaN where samples were lost.
    """

    first_index: int
    volts: FloatArray


class Ring:
    """The last `length` samples of all channels; memory is allocated once.

    Parameters
    ----------
    n_channels
        Channels of a block.
    length
        Samples of each channel that are held.
    dtype
        int16 for codes, float64 for volts.
    digitisation
        How codes become volts; left out, samples are volts.
    """

    def __init__(
        self, n_channels: int, length: int, dtype: DTypeLike, digitisation: Digitisation | None = None
    ) -> None:
        self._digitisation = digitisation
        self._samples = CircularBuffer(n_channels, length, dtype)
        self._valid = CircularBuffer(1, length, np.bool_)

    @property
    def length(self) -> int:
        """Samples of each channel that are held."""
        return self._samples.length

    @property
    def latest(self) -> int:
        """Absolute index after the last sample."""
        return self._samples.end

    @property
    def first(self) -> int:
        """Absolute index of the oldest sample held."""
        return self._samples.first

    def append(self, block: Block) -> None:
        """Append a block; indices missing before it become a gap. The reader's thread only."""
        lost = block.first_index - self._samples.end
        # indices go on over lost samples: time stays index / rate
        if lost > 0:
            self._valid.fill(lost, value=False)
            self._samples.fill(lost, value=0)
        self._valid.fill(block.count, value=True)
        self._samples.extend(block.samples)

    def since(self, index: int) -> RingSpan:
        """Return all samples held from absolute index `index` on."""
        return self._span(index, self.latest)

    def recent(self, count: int) -> RingSpan:
        """Return the last `count` samples."""
        end = self.latest
        return self._span(end - count, end)

    def blocks(self, first: int, last: int) -> tuple[Block, ...]:
        """Return what is held of samples first:last as the device gave it, one block a stretch without a gap."""
        begin, samples = self._samples.copy(first, last)
        valid = self._valid_of(begin, samples.shape[1])
        edges = np.flatnonzero(np.diff(np.concatenate(([False], valid, [False])).astype(np.int8)))
        return tuple(
            Block(samples=samples[:, low:high], first_index=begin + int(low))
            for low, high in zip(edges[::2], edges[1::2], strict=True)
        )

    def _span(self, first: int, last: int) -> RingSpan:
        begin, samples = self._samples.copy(first, last)
        valid = self._valid_of(begin, samples.shape[1])
        volts = np.array(samples, dtype=np.float64) if self._digitisation is None else self._digitisation.volts(samples)
        # a line through a gap would be taken for signal
        volts[:, ~valid] = np.nan
        return RingSpan(begin, volts)

    def _valid_of(self, first: int, count: int) -> BoolArray:
        """Return which of the samples are real; those overwritten since they were copied are not."""
        begin, flags = self._valid.copy(first, first + count)
        out = np.zeros(count, dtype=np.bool_)
        out[begin - first : begin - first + flags.shape[1]] = flags[0]
        return out
