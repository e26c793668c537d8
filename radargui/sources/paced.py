"""Samples that are there already or made when asked for: replay, and what it shares with the simulation."""

import threading
from abc import ABC, abstractmethod
from dataclasses import replace

from radargui.model.block import Block, Gap
from radargui.model.digitisation import Digitisation
from radargui.model.errors import SourceError
from radargui.model.recording import Recording
from radargui.model.truth import Truth
from radargui.sources.contract import SYSTEM_CLOCK, Clock


class PacedSource(ABC):
    """The contract of a source but for `open`, for samples that are there already or made when asked for.

    Parameters
    ----------
    title
        What it is, for people.
    clock
        Paces real time.
    sample_rate_hz
        Samples per second and channel.
    block_s
        Length of a block.
    n_samples
        Samples of each channel; None: without end.
    realtime
        Give out samples when their time has come; otherwise as fast as asked.
    """

    is_waiting = False
    restarts = 0

    def __init__(
        self, title: str, clock: Clock, sample_rate_hz: float, block_s: float, n_samples: int | None, *, realtime: bool
    ) -> None:
        self._title = title
        self._clock = clock
        self._rate_hz = sample_rate_hz
        self._block = max(round(block_s * sample_rate_hz), 1)
        self._n_samples = n_samples
        self._realtime = realtime
        self._opened = False
        self._started = False
        self._start_s = 0.0
        self._next = 0
        self._lost = 0
        self._stopping = threading.Event()
        # nothing waits in a source that never began
        self._stopping.set()

    def start(self) -> None:
        """Begin at the first sample, which has index 0.

        Raises
        ------
        SourceError
            The source is not open.
        """
        if not self._opened:
            raise SourceError(f"{self._title} is not open", remedy="Open it before it is started.")
        self._next = self._lost = 0
        self._started = True
        self._start_s = self._clock.now()
        self._stopping.clear()

    def read(self) -> Block | None:
        """Return the next block, or None at the end and after `stop`.

        Raises
        ------
        SourceError
            The source was never started.
        """
        if not self._started:
            raise SourceError(f"{self._title} was not started", remedy="Start it before it is read.")
        return self._read()

    @abstractmethod
    def _read(self) -> Block | None:
        """Do what `read` does, once started."""

    def stop(self) -> None:
        """End sampling; a waiting `read` returns None at once. From any thread."""
        self._stopping.set()

    def close(self) -> None:
        """Release everything."""
        self.stop()
        self._opened = False

    def backlog(self) -> int:
        """Return how many samples per channel wait; 0 where not in real time."""
        if not self._realtime or self._stopping.is_set():
            return 0
        taken = int((self._clock.now() - self._start_s) * self._rate_hz) - self._lost
        return max((taken if self._n_samples is None else min(taken, self._n_samples)) - self._next, 0)

    def truth(self, first_index: int, count: int) -> Truth | None:
        """Return None: nobody knows what really happened."""
        del first_index, count
        return None

    def _end_of_block(self) -> int:
        end = self._next + self._block
        return end if self._n_samples is None else min(end, self._n_samples)

    def _wait_for(self, end_index: int) -> bool:
        """Wait until the sample before `end_index` is taken; return False where stopped."""
        while self._realtime and not self._stopping.is_set():
            # against the start, not the block before: waiting too long once does not add up
            left_s = self._start_s + end_index / self._rate_hz - self._clock.now()
            if left_s <= 0.0:
                break
            self._clock.wait(left_s, self._stopping)
        return not self._stopping.is_set()


_BLOCK_S = 0.02
"""As a device is read (`daq.read_interval_s`)."""


class ReplaySource(PacedSource):
    """The samples of a recording, block by block, its gaps as they were.

    Blocks never span a gap; a gap after the last sample is not reported, since no block follows it.

    Parameters
    ----------
    recording
        What is replayed.
    realtime
        Give out samples when their time has come; otherwise as fast as asked.
    clock
        Paces real time.
    block_s
        Length of a block.
    """

    def __init__(
        self,
        recording: Recording,
        *,
        realtime: bool = False,
        clock: Clock = SYSTEM_CLOCK,
        block_s: float = _BLOCK_S,
    ) -> None:
        rate_hz = recording.digitisation.sample_rate_hz
        super().__init__("The replay", clock, rate_hz, block_s, recording.n_samples, realtime=realtime)
        self._recording = recording
        self._gaps = _joined(recording.gaps)
        self._n_gaps = 0

    def open(self) -> Digitisation:
        """Return how the recording was digitised.

        Raises
        ------
        SourceError
            The recording is empty.
        """
        if self._recording.n_samples == 0:
            raise SourceError(f"{self._recording.name} holds no samples", remedy="Choose another file to replay.")
        self._opened = True
        digitisation = self._recording.digitisation
        return replace(digitisation, device=digitisation.device or f"replay of {self._recording.name}")

    def start(self) -> None:
        """Begin at the first sample.

        Raises
        ------
        SourceError
            The replay is not open.
        """
        super().start()
        self._n_gaps = 0

    def _read(self) -> Block | None:
        gap = self._gap_here()
        lost = self._lost + (gap.count if gap else 0)
        upcoming = self._gaps[self._n_gaps + (gap is not None) :]
        end = self._end_of_block()
        if upcoming:
            end = min(end, upcoming[0].first_index - lost)
        if end <= self._next or not self._wait_for(end + lost):
            return None
        # a copy: a block owns its samples, the recording stays as it was
        block = Block(self._recording.raw[:, self._next : end].copy(), self._next + lost, gap)
        self._lost, self._next = lost, end
        self._n_gaps += gap is not None
        return block

    def _gap_here(self) -> Gap | None:
        upcoming = self._gaps[self._n_gaps : self._n_gaps + 1]
        return upcoming[0] if upcoming and upcoming[0].first_index <= self._next + self._lost else None


def _joined(gaps: tuple[Gap, ...]) -> tuple[Gap, ...]:
    """Return gaps in order, those without a sample between them as one."""
    joined: list[Gap] = []
    for gap in sorted((gap for gap in gaps if gap.count > 0), key=lambda gap: gap.first_index):
        last = joined[-1] if joined else None
        if last is not None and gap.first_index <= last.first_index + last.count:
            joined[-1] = replace(last, count=last.count + gap.count)
        else:
            joined.append(gap)
    return tuple(joined)
