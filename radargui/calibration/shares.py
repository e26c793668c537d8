"""Work that is the same for each recording, in processes of its own, with progress and an end at any time."""

from __future__ import annotations

import signal
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import active_children, get_context
from typing import TypeVar

from radargui.model.errors import ProcessingError

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
    others = active_children()
    # who began it hears Ctrl-C and ends it
    pool = ProcessPoolExecutor(
        min(workers, len(tasks)), get_context("spawn"), signal.signal, (signal.SIGINT, signal.SIG_IGN)
    )
    try:
        for answer in [pool.submit(work, *one) for one in tasks]:
            while not wait([answer], LOOK_S).done:
                shares.look()
            out.append(answer.result())
            shares.one_done()
    except BrokenProcessPool as error:
        raise ProcessingError(
            "a process that estimated one of the recordings ended without an answer.",
            reasons=("the memory does not suffice", "somebody killed it"),
            remedy="Close other programs and calibrate again, or take fewer recordings.",
        ) from error
    finally:
        # who cancels does not wait for an estimate of a minute
        for process in set(active_children()).difference(others) if len(out) < len(tasks) else ():
            process.terminate()
        pool.shutdown(cancel_futures=True)
    return out
