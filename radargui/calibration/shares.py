"""Do the work that is the same for each recording in processes of its own, with progress and cancelling."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from contextvars import ContextVar
from multiprocessing import active_children, get_context
from typing import TypeVar

from radargui.model.cores import begin_worker
from radargui.model.errors import ProcessingError

Progress = Callable[[float], None]
T = TypeVar("T")
_HALF_FULL_ROUNDS = 60
"""After so many rounds the fits' half of the bar is half full. Chosen by hand: the larger, the slower it goes on."""
LOOK_S = 0.1
"""How often it is looked whether somebody wants no more."""


class Shares:
    """Progress of a calibration: one estimate for each recording, then an unknown number of rounds of the fits.

    Parameters
    ----------
    report
        Given the share done.
    count
        Recordings.
    """

    def __init__(self, report: Progress, count: int) -> None:
        self._report, self._count, self._done, self._rounds = report, count, 0, 0

    def one_done(self) -> None:
        """Note that a recording was estimated."""
        self._done += 1
        self.look()

    def round_done(self) -> None:
        """Note that a step of a fit was made."""
        self._rounds += 1
        self.look()

    def look(self) -> None:
        """Report the share done; an exception from there ends the work."""
        # begun again without a recording more are done than there are; rounds never reach their half: none is the last
        estimates, rounds = min(self._done / self._count, 1.0), self._rounds / (self._rounds + _HALF_FULL_ROUNDS)
        self._report(0.5 * estimates + 0.5 * rounds)


class Crew:
    """Processes that keep what they were given from call to call; without any, this process does the work.

    Parameters
    ----------
    count
        How many; one is this process itself.
    shares
        Their progress, reported while one waits.
    """

    def __init__(self, count: int, shares: Shares | None = None) -> None:
        self.shares = shares or Shares(lambda _: None, 1)
        self._pools = [
            # one process a pool, so that a recording is always with the one that knows it; spawned, for a fork copies
            # the locks of threads that it does not copy
            ProcessPoolExecutor(1, get_context("spawn"), begin_worker)
            for _ in range(count if count > 1 else 0)
        ]
        # a pool does not tell its processes: they say their numbers themselves
        self._ids = [pool.submit(os.getpid) for pool in self._pools]

    @property
    def count(self) -> int:
        """Processes that work."""
        return max(len(self._pools), 1)

    def each(
        self, work: Callable[..., T], tasks: Sequence[tuple[object, ...]], done: Callable[[], None] = lambda: None
    ) -> list[T]:
        """Do the work on each task, the n-th always in the same process; answers come in their order."""
        if not self._pools:
            return [self._done(work(*one), done) for one in tasks]
        begun = [self._pools[n % self.count].submit(work, *one) for n, one in enumerate(tasks)]
        return [self._done(self._answer(one), done) for one in begun]

    @staticmethod
    def _done(answer: T, done: Callable[[], None]) -> T:
        done()
        return answer

    def _answer(self, begun: Future[T]) -> T:
        try:
            while not wait([begun], LOOK_S).done:
                self.shares.look()
            return begun.result()
        except BrokenProcessPool as error:
            raise ProcessingError(
                "a process that estimated one of the recordings ended without an answer.",
                reasons=("the memory does not suffice", "somebody killed it"),
                remedy="Close other programs and calibrate again, or take fewer recordings.",
            ) from error

    def close(self) -> None:
        """End the processes at once, also in the middle of an estimate."""
        ids = {one.result() for one in self._ids if one.exception() is None}
        # by number: this program may have other processes, which nobody cancelled
        for process in active_children():
            if process.pid in ids:
                process.terminate()
        for pool in self._pools:
            pool.shutdown(cancel_futures=True)


_CREW: ContextVar[Crew] = ContextVar("crew", default=Crew(1))  # noqa: B039  it has no state


def crew() -> Crew:
    """Return the processes that work now."""
    return _CREW.get()


@contextmanager
def working(count: int, shares: Shares | None = None) -> Iterator[Crew]:
    """Start so many processes for `crew`, and end them afterwards."""
    here = Crew(count, shares)
    token = _CREW.set(here)
    try:
        yield here
    finally:
        _CREW.reset(token)
        here.close()
