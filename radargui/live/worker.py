"""The thread that turns samples into a live track."""

import threading
from typing import Protocol

from radargui.live.processor import LiveProcessor
from radargui.live.track import LiveTrack
from radargui.model.recording import Block

LONGEST_LAG_S = 2.0
"""Catching up is many times faster than real time, and a skip loses the track until the next rest."""


class HeldSamples(Protocol):
    """The last samples of a source, by their absolute index; somebody else adds to them meanwhile."""

    @property
    def length(self) -> int:
        """Samples held at the most."""
        ...

    @property
    def first(self) -> int:
        """Absolute index of the oldest one."""
        ...

    @property
    def latest(self) -> int:
        """Absolute index after the newest one."""
        ...

    def blocks(self, first: int, last: int) -> tuple[Block, ...]:
        """Return what is held of samples first:last, one block a stretch without a gap."""
        ...


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
        Least number of samples that are estimated at once: the time for a block hardly depends on its length.
    """

    def __init__(
        self, ring: HeldSamples, processor: LiveProcessor, track: LiveTrack, longest_lag: int, together: int = 1
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
        self._fallen_at: int | None = None
        self.skipped = 0

    @property
    def lag(self) -> int:
        """Samples that wait to be estimated."""
        return self._ring.latest - self._next

    def wake(self) -> None:
        """Note that the ring has new samples; this never waits."""
        self._new.set()

    def at_release(self, index: int) -> None:
        """Note that the tracer hangs at its release and rests at absolute sample index `index`; from any thread."""
        self._release_at = index

    def fallen(self, index: int) -> None:
        """Note that a drop had ended at absolute sample index `index`; from any thread."""
        self._fallen_at = index

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
        if self._fallen_at is not None and block.end_index > self._fallen_at:
            self._fallen_at = None
            self._processor.fallen()
        self._track.append(self._processor.push(block.samples, block.first_index))
