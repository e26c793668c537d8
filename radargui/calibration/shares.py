"""Work that is the same for each recording, in processes of its own, with progress and an end at any time."""

from __future__ import annotations

import signal
from collections.abc import Callable, Sequence
from multiprocessing import get_context
from typing import TypeVar

Progress = Callable[[float], None]
T = TypeVar("T")
MOST_ROUNDS = 60
LOOK_S = 0.1
"""How often it is looked whether somebody wants no more."""


class Shares:
    """Progress of the parts: an estimate a recording, and rounds of the fits, of which nobody knows how many.

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
        """A recording was estimated."""
        self._done += 1
        self.look()

    def round_done(self) -> None:
        """A step of a fit was made."""
        self._rounds += 1
        self.look()

    def look(self) -> None:
        """Say how far it is; what that raises ends the work."""
        self._report(0.5 * self._done / self._count + 0.5 * self._rounds / (self._rounds + MOST_ROUNDS))


def each(work: Callable[..., T], tasks: Sequence[tuple[object, ...]], workers: int, shares: Shares) -> list[T]:
    """Do the work on each recording, in processes where there are workers for it."""
    out = []
    if workers < 2 or len(tasks) < 2:
        for one in tasks:
            out.append(work(*one))
            shares.one_done()
        return out
    # leaving the pool ends its processes: who cancels does not wait for an estimate of a minute
    pool = get_context("spawn").Pool(min(workers, len(tasks)), signal.signal, (signal.SIGINT, signal.SIG_IGN))
    with pool:
        running = [pool.apply_async(work, one) for one in tasks]
        for answer in running:
            while not answer.ready():
                shares.look()
                answer.wait(LOOK_S)
            out.append(answer.get())
            shares.one_done()
    return out
