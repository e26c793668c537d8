"""The live track by absolute sample index, which the screen pulls, and the thread that estimates and fills it."""

import math
import threading
from bisect import bisect_left
from dataclasses import dataclass

import numpy as np

from radargui.acquisition.ring import CircularBuffer, Ring
from radargui.model.arrays import FloatArray, IntArray
from radargui.model.block import Block
from radargui.processing.live import LiveEstimate, LiveProcessor

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
        n = self._n
        return LiveSpan(
            index=np.asarray(indices[0], dtype=np.intp),
            time_s=indices[0] / self._rate_hz,
            i=values[:n],
            q=values[n : 2 * n],
            change_m=values[2 * n : 3 * n],
            position_m=values[3 * n :],
        )

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
    """

    def __init__(self, ring: Ring, processor: LiveProcessor, track: LiveTrack, longest_lag: int) -> None:
        self._ring = ring
        self._processor = processor
        self._track = track
        self._longest_lag = max(1, min(longest_lag, ring.length // 2))
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
