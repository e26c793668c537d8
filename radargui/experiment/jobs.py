"""Jobs in order in one thread of their own: runs are processed while the next one is armed."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable
from typing import Generic, TypeVar

T = TypeVar("T")


class Jobs(Generic[T]):
    """Does one job after the other; the thread is there only once a job is.

    Parameters
    ----------
    work
        Does a job, in the thread; never raises.
    """

    def __init__(self, work: Callable[[T], None]) -> None:
        self._work = work
        self._waiting: queue.SimpleQueue[T | None] = queue.SimpleQueue()
        self._thread: threading.Thread | None = None

    def add(self, job: T) -> None:
        """Do a job after those before."""
        if self._thread is None:
            self._thread = threading.Thread(target=self._run, name="experiment-processing", daemon=True)
            self._thread.start()
        self._waiting.put(job)

    def close(self) -> None:
        """Wait until all jobs are done and the thread is gone."""
        self._waiting.put(None)
        if self._thread is not None:
            self._thread.join()

    def _run(self) -> None:
        while (job := self._waiting.get()) is not None:
            self._work(job)
