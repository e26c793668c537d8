"""The ring: the last seconds of raw samples by absolute index; reader writes, screen and live thread pull."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import DTypeLike

from radargui.acquisition.circular_buffer import CircularBuffer
from radargui.model.arrays import BoolArray, FloatArray
from radargui.model.block import Block
from radargui.model.digitisation import Digitisation


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
        volts[:, ~valid] = np.nan
        return RingSpan(begin, volts)

    def _valid_of(self, first: int, count: int) -> BoolArray:
        """Return which of the samples are real; those overwritten since they were copied are not."""
        begin, flags = self._valid.copy(first, first + count)
        out = np.zeros(count, dtype=np.bool_)
        out[begin - first : begin - first + flags.shape[1]] = flags[0]
        return out
