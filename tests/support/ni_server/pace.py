"""How fast the stand-in devices sample: at once, by a clock, or by the hand of a test."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Protocol


class Pace(Protocol):
    """Tells how many samples a running task has acquired; called with the server's condition held."""

    condition: threading.Condition

    def start(self) -> float:
        """Return the start mark of a task."""

    def acquired(self, mark: float, rate_hz: float) -> int | None:
        """Return the samples acquired since a mark; None: always enough."""

    def wait(self, mark: float, rate_hz: float, wanted: int, timeout_s: float, gone: Callable[[], bool]) -> None:
        """Wait until `wanted` samples are acquired since the mark, the time is over or the task is gone."""

    def wait_for_edge(self, timeout_s: float, come: Callable[[], bool]) -> None:
        """Wait until an edge has come or the time is over; a pace without a clock does not wait."""


class AsFastAsPossible:
    """Every sample is there as soon as it is asked for."""

    def __init__(self) -> None:
        self.condition = threading.Condition()

    def start(self) -> float:
        return 0.0

    def acquired(self, mark: float, rate_hz: float) -> int | None:
        return None

    def wait(self, mark: float, rate_hz: float, wanted: int, timeout_s: float, gone: Callable[[], bool]) -> None:
        return None

    def wait_for_edge(self, timeout_s: float, come: Callable[[], bool]) -> None:
        return None


class RealTime:
    """Samples come at their rate by a clock."""

    def __init__(self, now: Callable[[], float] = time.monotonic) -> None:
        self.condition = threading.Condition()
        self._now = now

    def start(self) -> float:
        return self._now()

    def acquired(self, mark: float, rate_hz: float) -> int | None:
        return int((self._now() - mark) * rate_hz)

    def wait(self, mark: float, rate_hz: float, wanted: int, timeout_s: float, gone: Callable[[], bool]) -> None:
        deadline = min(self._now() + timeout_s, mark + wanted / rate_hz + 1e-6)
        while not gone() and (left := deadline - self._now()) > 0.0:
            self.condition.wait(left)

    def wait_for_edge(self, timeout_s: float, come: Callable[[], bool]) -> None:
        self.condition.wait_for(come, timeout_s)


class ByHand:
    """Samples come when a test says so."""

    def __init__(self) -> None:
        self.condition = threading.Condition()
        self.waiting = threading.Event()
        self._count = 0

    def advance(self, samples: int) -> None:
        """Let each running task acquire so many samples per channel."""
        with self.condition:
            self._count += samples
            self.condition.notify_all()

    def start(self) -> float:
        return float(self._count)

    def acquired(self, mark: float, rate_hz: float) -> int | None:
        return self._count - int(mark)

    def wait(self, mark: float, rate_hz: float, wanted: int, timeout_s: float, gone: Callable[[], bool]) -> None:
        if self._count - int(mark) < wanted:
            self.waiting.set()
        self.condition.wait_for(lambda: gone() or self._count - int(mark) >= wanted, timeout_s)

    def wait_for_edge(self, timeout_s: float, come: Callable[[], bool]) -> None:
        self.waiting.set()
        self.condition.wait_for(come, timeout_s)
