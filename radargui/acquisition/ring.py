"""Ring buffers: the last samples, and the live track that is computed from them."""

from __future__ import annotations

import math
import threading
from bisect import bisect_left
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import DTypeLike, NDArray

from radargui.acquisition.circular_buffer import CircularBuffer
from radargui.model.arrays import BoolArray, FloatArray, IntArray, lowest_and_highest, runs_of
from radargui.model.recording import Block, Digitisation
from radargui.processing.live import LiveEstimate, LiveProcessor


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


MAXIMUM_COLUMNS = 400_000
"""Bounds the memory of an hour: 13 numbers of 8 bytes each with three receivers, 42 MB; chosen by hand."""


@dataclass(frozen=True, slots=True)
class LiveSpan:
    """Consecutive live estimates.

    Attributes
    ----------
    index
        Absolute sample index of each column, shape (n,).
    time_s
        index / rate, shape (n,).
    i, q
        Corrected, in amplitudes, shape (n_receivers, n); NaN before the correction is known.
    change_m
        Change of path length, shape (n_receivers, n); NaN while unknown.
    position_m
        Centre of the sphere, shape (3, n); NaN while unknown.
    """

    index: IntArray
    time_s: FloatArray
    i: FloatArray
    q: FloatArray
    change_m: FloatArray
    position_m: FloatArray


class LiveTrack:
    """The last estimates of the live thread; memory is allocated once.

    Parameters
    ----------
    n_receivers
        Rows of I, of Q and of path length.
    sample_rate_hz
        Rate that the indices count at.
    length_s
        Time span held; less where the estimates are so dense that they exceed `MAXIMUM_COLUMNS`.
    estimates_hz
        Estimates per second; None: one a sample.
    """

    def __init__(
        self, n_receivers: int, sample_rate_hz: float, length_s: float, estimates_hz: float | None = None
    ) -> None:
        columns = min(math.ceil(length_s * (estimates_hz or sample_rate_hz)), MAXIMUM_COLUMNS)
        self._n = n_receivers
        self._rate_hz = sample_rate_hz
        self._values = CircularBuffer(3 * n_receivers + 3, columns, np.float64)
        self._index = CircularBuffer(1, columns, np.int64)
        self.moving = False
        self.began_anew = False
        """See `LiveEstimate`."""

    @property
    def latest(self) -> int:
        """Absolute sample index after the last estimate."""
        end = self._index.end
        return self._index_at(end - 1) + 1 if end else 0

    def append(self, estimate: LiveEstimate) -> None:
        """Add estimates; their indices ascend. The live thread only."""
        self.moving, self.began_anew = estimate.moving, estimate.began_anew
        if estimate.index.size == 0:
            return
        values = np.concatenate([estimate.i, estimate.q, estimate.change_m, estimate.position_m])
        # the index first: a reader trusts the values only as far as both reach
        self._index.extend(estimate.index[None])
        self._values.extend(values)

    def since(self, index: int) -> LiveSpan:
        """Return all estimates held at absolute sample index `index` and later."""
        end = self._values.end
        held = range(self._index.first, end)
        column = held.start + bisect_left(held, index, key=self._index_at)
        first, values = self._values.copy(column, end)
        begin, indices = self._index.copy(first, end)
        values = values[:, begin - first :]
        n, at = self._n, np.asarray(indices[0], dtype=np.intp)
        return LiveSpan(at, at / self._rate_hz, *np.split(values, (n, 2 * n, 3 * n)))

    def _index_at(self, column: int) -> int:
        """Return the sample index of a column; a column overwritten meanwhile is older than anything asked for."""
        _, found = self._index.copy(column, column + 1)
        return int(found[0, 0]) if found.size else -1


LONGEST_LAG_S = 2.0
"""Catching up is many times faster than real time, and a skip loses the track until the next rest."""


class LiveWorker:
    """Turns what the ring gets into a live track, in a thread that calls `run`.

    Parameters
    ----------
    ring
        Where the samples are.
    processor
        Makes the estimates.
    track
        Where they go.
    longest_lag
        When more samples than this wait, all but the newest quarter of them are skipped.
    together
        So many at least are estimated at once: most of what a block takes does not depend on its length.
    """

    def __init__(
        self, ring: Ring, processor: LiveProcessor, track: LiveTrack, longest_lag: int, together: int = 1
    ) -> None:
        self._ring = ring
        self._processor = processor
        self._track = track
        self._longest_lag = max(1, min(longest_lag, ring.length // 2))
        self._together = together
        self._next = 0
        self._new = threading.Event()
        self._ended = False
        self._release_at: int | None = None
        self.skipped = 0

    @property
    def lag(self) -> int:
        """Samples that wait to be estimated."""
        return self._ring.latest - self._next

    def wake(self) -> None:
        """Tell that the ring has new samples; never waits."""
        self._new.set()

    def at_release(self, index: int) -> None:
        """Tell that the tracer hangs at its release and rests at absolute sample index `index`; from any thread."""
        self._release_at = index

    def finish(self) -> None:
        """Let `run` return soon."""
        self._ended = True
        self._new.set()

    def run(self) -> None:
        """Estimate until `finish`."""
        while not self._ended:
            self._new.wait()
            self._new.clear()
            self.catch_up()

    def catch_up(self) -> None:
        """Estimate what is new in the ring."""
        end = self._ring.latest
        begin = self._next
        if end - begin < self._together and not self._ended:
            return
        if end - begin > self._longest_lag:
            # far ahead at once: a worker that skips a little is late again with the next block
            begin = end - max(1, self._longest_lag // 4)
        blocks = self._ring.blocks(begin, end)
        begin = max(begin, min(self._ring.first, end))
        self.skipped += begin - self._next
        self._next = begin
        for block in blocks:
            self._estimate(block)
        self._next = end

    def _estimate(self, block: Block) -> None:
        # with the samples, not with the clock: the tracer hangs there from this sample on
        if self._release_at is not None and block.end_index > self._release_at:
            self._release_at = None
            self._processor.at_release()
        self._track.append(self._processor.push(block.samples, block.first_index))
