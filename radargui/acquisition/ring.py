"""Hold the last samples of all channels."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import DTypeLike, NDArray

from radargui.model.arrays import BoolArray, CircularBuffer, FloatArray, lowest_and_highest, runs_of
from radargui.model.recording import Block, Digitisation


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

    Attributes
    ----------
    length
        Samples of each channel that are held.
    """

    def __init__(
        self, n_channels: int, length: int, dtype: DTypeLike, digitisation: Digitisation | None = None
    ) -> None:
        self._kind = (n_channels, length, dtype, digitisation)
        self._samples = CircularBuffer(n_channels, length, dtype)
        self.length = self._samples.length
        self._valid = CircularBuffer(1, length, np.bool_)

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
        return self.span(index, self.latest)

    def thinned(self, count: int, most: int) -> FloatArray:
        """Return volts of at most `most` evenly spaced of the last `count` samples, the newest one among them.

        Only these are copied and scaled. Shape (n_channels, n); NaN where samples were lost.
        """
        end = self.latest
        index = np.arange(end - 1, max(end - count, self.first) - 1, -max(1, -(-count // most)))[::-1]
        index, samples = self._samples.pick(index)
        volts = self._volts(samples)
        known, flags = self._valid.pick(index)
        volts = volts[:, volts.shape[1] - known.size :]
        volts[:, ~flags[0]] = np.nan
        return volts

    def held(self) -> Ring:
        """Return a copy that nobody appends to, for looking at while samples go on coming."""
        copied = Ring(*self._kind)
        for block in self.blocks(self.first, self.latest):
            copied.append(block)
        return copied

    def blocks(self, first: int, last: int) -> tuple[Block, ...]:
        """Return what is held of samples first:last as the device gave it, one block a stretch without a gap."""
        begin, samples, valid = self._copy(first, last)
        return tuple(Block(samples[:, low:high], begin + low) for low, high in runs_of(valid).tolist())

    def span(self, first: int, last: int) -> RingSpan:
        """Return what is held of samples first:last."""
        begin, samples, valid = self._copy(first, last)
        volts = self._volts(samples)
        # a line through a gap would be taken for signal
        volts[:, ~valid] = np.nan
        return RingSpan(begin, volts)

    def extremes(self, first: int, last: int, size: int) -> tuple[int, FloatArray, FloatArray, BoolArray]:
        """Return the lowest and highest volts of bins of `size` samples in first:last, scaled after they are found.

        Returns
        -------
        tuple
            Number of the first bin (bin k begins at absolute index k `size`), lowest and highest, shape
            (n_channels, n) each, and whether samples of the bin were lost, shape (n,).
        """
        begin, samples, valid = self._copy(first, last)
        if valid.all():
            # a converter's scaling is monotonic; it may fall
            ends = [self._volts(codes) for codes in lowest_and_highest(samples, size, begin)]
        else:
            ends = list(lowest_and_highest(self.span(begin, last).volts, size, begin))
        lost: BoolArray = lowest_and_highest(~valid, size, begin)[1]
        return begin // size, np.fmin(*ends), np.fmax(*ends), lost

    def _volts(self, samples: NDArray[Any]) -> FloatArray:
        digitisation = self._kind[-1]
        return np.array(samples, dtype=np.float64) if digitisation is None else digitisation.volts(samples)

    def _copy(self, first: int, last: int) -> tuple[int, NDArray[Any], BoolArray]:
        """Return the index of the first sample held, what is held, and which of it is real.

        What was overwritten between the two copies is not.
        """
        begin, samples = self._samples.copy(first, last)
        known, flags = self._valid.copy(begin, begin + samples.shape[1])
        valid = np.zeros(samples.shape[1], dtype=np.bool_)
        valid[known - begin : known - begin + flags.shape[1]] = flags[0]
        return begin, samples, valid
