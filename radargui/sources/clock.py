"""The clock that paces a source; tests inject their own."""

import threading
import time
from typing import Protocol


class Clock(Protocol):
    """Seconds that only go forward, and a wait that can be interrupted."""

    def now(self) -> float:
        """Return the time in s from an arbitrary origin."""

    def wait(self, seconds: float, interrupt: threading.Event) -> bool:
        """Wait until `seconds` have passed or `interrupt` is set; return whether it is set."""


class SystemClock:
    """The clock of this computer."""

    def now(self) -> float:
        """Return the time in s from an arbitrary origin."""
        return time.perf_counter()

    def wait(self, seconds: float, interrupt: threading.Event) -> bool:
        """Wait until `seconds` have passed or `interrupt` is set; return whether it is set."""
        return interrupt.wait(max(seconds, 0.0))


SYSTEM_CLOCK = SystemClock()
