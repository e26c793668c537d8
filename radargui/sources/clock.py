"""The clock that paces a source; tests inject one of the same shape."""

import threading
import time


class Clock:
    """The clock of this computer: seconds that only go forward, and a wait that can be interrupted."""

    def now(self) -> float:
        """Return the time in s from an arbitrary origin."""
        return time.perf_counter()

    def wait(self, seconds: float, interrupt: threading.Event) -> bool:
        """Wait until `seconds` have passed or `interrupt` is set; return whether it is set."""
        return interrupt.wait(max(seconds, 0.0))


SYSTEM_CLOCK = Clock()
