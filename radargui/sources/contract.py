"""The contract of a source of samples and the clock that paces it; replay, and what it shares with the simulation."""

import threading
import time
from abc import ABC, abstractmethod
from dataclasses import replace
from typing import Protocol

from radargui.model.errors import SourceError
from radargui.model.recording import Block, Digitisation, Recording, Truth


class Clock:
    """The clock of this computer: seconds that only go forward, and a wait that can be interrupted."""

    def now(self) -> float:
        """Return the time in s from an arbitrary origin."""
        return time.perf_counter()

    def wait(self, seconds: float, interrupt: threading.Event) -> bool:
        """Wait until `seconds` have passed or `interrupt` is set; return whether it is set."""
        return interrupt.wait(max(seconds, 0.0))


SYSTEM_CLOCK = Clock()


class Source(Protocol):
    """A source of samples of all channels.

    * Channel order is that of `Digitisation.channel_names`: I1, Q1, I2, Q2, ...
    * A block holds int16 codes (volts by `Digitisation.scaling`) or float64 volts, never both in one acquisition.
    * A block's array belongs to the block: the source makes a new one each time and never writes to it again.
    * Block size is the source's choice, about `daq.read_interval_s` of samples, at least one sample.
    * `read` blocks until a block is there, at most about a second, from one thread only; a source that waits for a
      start signal or restarts a device blocks until then, or until `stop`.
    * Lost samples (overflow) are reported by the `gap` of the next block; absolute indices count them.
    * `read` returns None at the end of data, for ever after; a failure raises `SourceError` once what was read
      before has been returned.
    * `stop` may be called from any thread, any number of times; a blocked `read` then returns None soon.
    """

    @property
    def is_waiting(self) -> bool:
        """Whether sampling was started and the edge it begins at has not come yet; from any thread, at once."""

    @property
    def restarts(self) -> int:
        """How often the device failed and was started again within this run; from any thread, at once."""

    def open(self) -> Digitisation:
        """Reserve and configure; return how samples will be digitised (rate and skew as in force).

        Raises
        ------
        SourceError
            The device, file or scene cannot be used; says why and what to do.
        """

    def start(self) -> None:
        """Begin to sample; index 0 is the first sample after this call."""

    def read(self) -> Block | None:
        """Return the next block, or None when there will be no more."""

    def stop(self) -> None:
        """End sampling; idempotent."""

    def close(self) -> None:
        """Release everything; idempotent, after `stop`."""

    def backlog(self) -> int:
        """Return how many samples per channel wait in the driver."""

    def truth(self, first_index: int, count: int) -> Truth | None:
        """Return what really happened during samples first_index : first_index + count; None but for simulations."""
        return None


class PacedSource(Source, ABC):
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

    def _end_of_block(self) -> int:
        end = self._next + self._block
        return end if self._n_samples is None else min(end, self._n_samples)

    def _wait_for(self, end_index: int) -> bool:
        """Wait until the sample before `end_index` is taken; return False where stopped."""
        # against the start, not the block before: waiting too long once does not add up
        due_s = self._start_s + end_index / self._rate_hz
        while self._realtime and not self._stopping.is_set() and (left_s := due_s - self._clock.now()) > 0.0:
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
        self, recording: Recording, *, realtime: bool = False, clock: Clock = SYSTEM_CLOCK, block_s: float = _BLOCK_S
    ) -> None:
        rate_hz = recording.digitisation.sample_rate_hz
        super().__init__("The replay", clock, rate_hz, block_s, recording.n_samples, realtime=realtime)
        self._recording = recording

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
        self._blocks = self._recording.blocks(self._block)

    def _read(self) -> Block | None:
        block = next(self._blocks, None)
        if block is None or not self._wait_for(block.end_index):
            return None
        self._next += block.count
        self._lost = block.end_index - self._next
        # a copy: a block owns its samples, the recording stays as it was
        return replace(block, samples=block.samples.copy())
