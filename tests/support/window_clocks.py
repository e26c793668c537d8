"""Clocks of sources for tests of the window: one that runs fast but never ahead of its readers, one that is led."""

from __future__ import annotations

import threading
import time

LONGEST_STEP_S = 0.01
"""Real time that one look at the clock can let pass: a machine that does other things slows the source, no more."""


class FastClock:
    """Time that runs several times as fast, so that no test waits for a real fall.

    Where nobody looked at it for a while, that while does not count: a reader that got no turn has missed nothing.
    """

    def __init__(self, speed: float) -> None:
        self._speed = speed
        self._lock = threading.Lock()
        self._looked_s = time.perf_counter()
        self._now_s = 1000.0

    def now(self) -> float:
        with self._lock:
            real_s = time.perf_counter()
            self._now_s += self._speed * min(real_s - self._looked_s, LONGEST_STEP_S)
            self._looked_s = real_s
            return self._now_s

    def wait(self, seconds: float, interrupt: threading.Event) -> bool:
        return interrupt.wait(min(max(seconds, 0.0) / self._speed, LONGEST_STEP_S))


class SeenClock:
    """Time that goes on with each picture of a window, once its reader has what there is: nothing passes unseen."""

    def __init__(self, step_s: float = 0.1) -> None:
        self._now_s, self._step_s = 1000.0, step_s
        self._due_s = 0.0

    def go_on(self) -> None:
        if self._due_s > self._now_s:
            self._now_s += self._step_s

    def now(self) -> float:
        return self._now_s

    def wait(self, seconds: float, interrupt: threading.Event) -> bool:
        self._due_s = self._now_s + seconds
        while self._now_s < self._due_s:
            if interrupt.wait(0.002):
                return True
        return interrupt.is_set()


class LedClock:
    """Time that goes on only where the test lets it."""

    def __init__(self) -> None:
        self.time_s = 0.0
        self.waited_for = False
        """Whether a source has begun: before it has, time that goes on is lost to it."""
        self._moved = threading.Condition()

    def now(self) -> float:
        with self._moved:
            return self.time_s

    def wait(self, seconds: float, interrupt: threading.Event) -> bool:
        del seconds
        with self._moved:
            self.waited_for = True
            # not for ever: who interrupts does not know of this condition
            self._moved.wait(LONGEST_STEP_S)
        return interrupt.is_set()

    def advance(self, seconds: float) -> None:
        with self._moved:
            self.time_s += seconds
            self._moved.notify_all()
