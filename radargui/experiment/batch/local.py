"""A batch on the cores of this computer."""

import multiprocessing
import os
from collections import deque
from collections.abc import Generator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from multiprocessing.synchronize import Event

from radargui.experiment.batch.task import BatchOutcome, BatchTask, work_on
from radargui.experiment.processing_apart import workers_ignoring_interrupts
from radargui.model.errors import CancelledError, ProcessingError
from radargui.model.workers import begin_worker

_AHEAD = 2
"""Tasks that are handed out for each worker: one to work on, one to go on with."""
_stop: Event | None = None
"""In a worker: what its parent stops it with."""


def run_local(tasks: Sequence[BatchTask], workers: int | None = None) -> Generator[BatchOutcome, None, None]:
    """Yield the outcome of each task as it ends, in no special order.

    Every worker is a process of its own with one thread for numerics. Where one ends without an answer (killed, out
    of memory, a crash in a library), the tasks that were handed out are done again one by one, each in a process of
    its own: only the one to blame fails. Closing the iterator stops the workers at their next step; run files are
    replaced in one step only, so none is left half written.

    Parameters
    ----------
    tasks
        What to do.
    workers
        Processes; None: as many as there are cores.
    """
    count = max(1, min(workers or os.cpu_count() or 1, len(tasks)))
    waiting = deque(tasks)
    while waiting:
        suspects: list[BatchTask] = []
        yield from _run_pool(waiting, count, suspects)
        for suspect in suspects:
            guilty: list[BatchTask] = []
            yield from _run_pool(deque([suspect]), 1, guilty)
            if guilty:
                yield BatchOutcome(suspect.run, "failed", _no_answer())


def _no_answer() -> ProcessingError:
    return ProcessingError(
        "its worker process ended without an answer.",
        reasons=("the memory does not suffice", "the file makes a library crash", "somebody killed it"),
        remedy="Use fewer --workers, or process this run alone.",
    )


def _run_pool(waiting: deque[BatchTask], count: int, suspects: list[BatchTask]) -> Generator[BatchOutcome, None, None]:
    """Yield outcomes until nothing waits, or a worker is lost: then `suspects` gets what was handed out."""
    context = multiprocessing.get_context("spawn")
    stop = context.Event()
    pool = ProcessPoolExecutor(count, mp_context=context, initializer=_begin, initargs=(stop,))
    running: dict[Future[BatchOutcome], BatchTask] = {}
    try:
        while waiting or running:
            while waiting and len(running) < _AHEAD * count:
                task = waiting.popleft()
                try:
                    with workers_ignoring_interrupts():
                        running[pool.submit(_work, task)] = task
                except BrokenProcessPool:
                    suspects.append(task)
                    break
            if suspects and not running:
                return
            for future in wait(running, return_when=FIRST_COMPLETED).done:
                task = running.pop(future)
                try:
                    outcome = future.result()
                except BrokenProcessPool:
                    suspects += [task, *running.values()]
                    return
                yield outcome
    finally:
        stop.set()
        pool.shutdown(wait=True, cancel_futures=True)


def _begin(stop: Event) -> None:
    global _stop
    _stop = stop
    begin_worker()


def _work(task: BatchTask) -> BatchOutcome:
    if _stop is not None and _stop.is_set():
        return BatchOutcome(task.run, "stopped")
    return work_on(task, _look_for_stop)


def _look_for_stop(_: float) -> None:
    if _stop is not None and _stop.is_set():
        raise CancelledError
