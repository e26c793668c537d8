"""Runs studied one after the other, by another process ahead of the pages where there are many."""

import multiprocessing
from collections import deque
from collections.abc import Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from functools import partial
from pathlib import Path

from radargui.model.setup import Setup
from radargui.model.workers import begin_worker
from radargui.report.run_facts import ResultOf, RunFacts, study

_FEWEST = 6
"""Runs from which on a process of its own costs less than it saves: it takes about a second to begin."""
_AHEAD = 3
"""Runs that wait for their page: some megabytes."""


def studied(
    paths: Sequence[Path], setup: Setup, result_of: ResultOf, *, detailed: bool, ahead: bool
) -> Iterator[RunFacts]:
    """Yield the facts of each run, in order.

    Parameters
    ----------
    paths
        Run files.
    setup, result_of, detailed
        See `study`.
    ahead
        Whether another process may read the next runs while one is drawn.
    """
    work = partial(study, setup=setup, result_of=result_of, detailed=detailed)
    if not ahead or len(paths) < _FEWEST:
        yield from map(work, paths)
        return
    context = multiprocessing.get_context("spawn")
    pool = ProcessPoolExecutor(1, context, begin_worker)
    try:
        waiting: deque[Future[RunFacts]] = deque()
        for path in paths:
            waiting.append(pool.submit(work, path))
            if len(waiting) > _AHEAD:
                yield waiting.popleft().result()
        while waiting:
            yield waiting.popleft().result()
    finally:
        pool.shutdown(cancel_futures=True)
