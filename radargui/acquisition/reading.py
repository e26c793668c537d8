"""What the reader counts: samples read and lost, the rate they come at; checks that a source keeps its contract."""

from __future__ import annotations

import math
from collections import deque

from radargui.model.block import Block
from radargui.model.digitisation import Digitisation
from radargui.model.errors import SourceError
from radargui.sources.clock import Clock

_BLOCKS_TIMED = 128
"""The rate is taken over so many: 2.6 s of blocks of 20 ms, steady to the eye; chosen by hand."""
_BACKLOG_S = 0.2
"""The driver is asked so often: a question is a call over the network with a remote device; chosen by hand."""
_SILENCE_S = 1.5
"""A source may wait about a second for a block; silence beyond that lowers the rate."""


class Reading:
    """Counts of one reader's thread; other threads may look."""

    def __init__(self, digitisation: Digitisation, clock: Clock) -> None:
        self._digitisation = digitisation
        self._clock = clock
        self._times: deque[tuple[float, int]] = deque(maxlen=_BLOCKS_TIMED)
        self._next = 0
        self.samples_read = 0
        self.samples_lost = 0
        self.gaps = 0
        self.backlog = 0
        self._backlog_asked_s = -math.inf

    def take(self, block: Block) -> None:
        """Count a block.

        Raises
        ------
        SourceError
            The block does not fit the digitisation or the samples before it: a fault of the source.
        """
        shape = block.samples.shape
        if len(shape) != 2 or shape[0] != self._digitisation.n_channels:
            raise SourceError(
                f"The source promised {self._digitisation.n_channels} channels and gave a block of shape {shape}"
            )
        if block.first_index < self._next:
            raise SourceError(
                f"The source gave sample {block.first_index} again after sample {self._next - 1}",
            )
        lost = block.first_index - self._next
        if lost:
            self.samples_lost += lost
            self.gaps += 1
        self._next = block.end_index
        self.samples_read += block.count
        self._times.append((self._clock.now(), self.samples_read))

    def backlog_is_due(self) -> bool:
        """Whether it is time to ask the source for its backlog again: asking may cost a way over the network."""
        now = self._times[-1][0] if self._times else self._clock.now()
        if now - self._backlog_asked_s < _BACKLOG_S:
            return False
        self._backlog_asked_s = now
        return True

    def rate_hz(self) -> float | None:
        """Return the rate over the last blocks; None before two have come."""
        times = tuple(self._times)
        if len(times) < 2:
            return None
        last = times[-1][0]
        if self._clock.now() - last > _SILENCE_S:
            last = self._clock.now()
        return (times[-1][1] - times[0][1]) / (last - times[0][0]) if last > times[0][0] else None
