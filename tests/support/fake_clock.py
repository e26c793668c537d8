"""A clock that tests move by hand: waiting takes no time."""

from __future__ import annotations

import threading


class FakeClock:
    """Time goes on only by waiting, or by `advance`."""

    def __init__(self) -> None:
        self.time_s = 1000.0
        self.waits: list[float] = []

    def now(self) -> float:
        return self.time_s

    def wait(self, seconds: float, interrupt: threading.Event) -> bool:
        self.waits.append(seconds)
        if not interrupt.is_set():
            self.time_s += max(seconds, 0.0)
        return interrupt.is_set()

    def advance(self, seconds: float) -> None:
        self.time_s += seconds
