"""Pacing: lets samples out when a real device would have taken them."""

from __future__ import annotations

import threading

from radargui.sources.clock import Clock


class Pacer:
    """Holds a reader back until a sample's time has come.

    Parameters
    ----------
    clock
        Seconds.
    sample_rate_hz
        Samples per second.
    realtime
        False lets every sample out at once.
    """

    def __init__(self, clock: Clock, sample_rate_hz: float, *, realtime: bool) -> None:
        self._clock = clock
        self._rate_hz = sample_rate_hz
        self._realtime = realtime
        self._start_s = 0.0
        self._stop = threading.Event()
        self._stop.set()

    @property
    def stopped(self) -> bool:
        """Whether `stop` was called since `start`, or `start` never."""
        return self._stop.is_set()

    def start(self) -> None:
        """Let the time of sample 0 be now."""
        self._start_s = self._clock.now()
        self._stop.clear()

    def stop(self) -> None:
        """Interrupt a wait and refuse all later ones; from any thread."""
        self._stop.set()

    def wait_for(self, end_index: int) -> bool:
        """Wait until the sample before `end_index` is taken; return False where stopped."""
        while self._realtime and not self._stop.is_set():
            left_s = self._start_s + end_index / self._rate_hz - self._clock.now()
            if left_s <= 0.0:
                break
            self._clock.wait(left_s, self._stop)
        return not self._stop.is_set()

    def taken(self) -> int | None:
        """Return how many samples a device would have taken by now; None where not in real time or stopped."""
        if not self._realtime or self._stop.is_set():
            return None
        return max(int((self._clock.now() - self._start_s) * self._rate_hz), 0)
