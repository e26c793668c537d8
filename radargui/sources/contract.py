"""The contract of a source of samples, kept by NI device, simulated scene and replay, and the clock that paces it."""

import threading
import time
from typing import Protocol

from radargui.model.recording import Block, Digitisation, Truth


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
