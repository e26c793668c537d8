"""The live thread's work: pulls new samples from the ring, estimates, fills the live track; skips when too slow."""

from __future__ import annotations

import threading

from radargui.acquisition.live_track import LiveTrack
from radargui.acquisition.ring import Ring
from radargui.model.block import Block
from radargui.processing.live import LiveProcessor

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
            begin = end - max(1, self._longest_lag // 4)
        blocks = self._ring.blocks(begin, end)
        begin = max(begin, min(self._ring.first, end))
        self.skipped += begin - self._next
        self._next = begin
        for block in blocks:
            self._estimate(block)
        self._next = end

    def _estimate(self, block: Block) -> None:
        if self._release_at is not None and block.end_index > self._release_at:
            self._release_at = None
            self._processor.at_release()
        self._track.append(self._processor.push(block.samples, block.first_index))
