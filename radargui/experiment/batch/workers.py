"""Run the tasks of a batch on the cores of this computer, or on a Dask cluster that sees the same files."""

import multiprocessing
import os
import re
from collections import deque
from collections.abc import Generator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from multiprocessing.synchronize import Event
from typing import Any

from radargui.experiment.batch.task import BatchOutcome, BatchTask, work_on
from radargui.model.errors import CancelledError, ProcessingError, RadarGuiError, UsageError, worded
from radargui.model.workers import begin_worker, workers_ignoring_interrupts

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
                yield BatchOutcome(suspect.run, "failed", worded(ProcessingError, "no_answer"))


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


ANSWER_S = 10  # for a scheduler to answer: one that runs does at once (chosen by hand)
WORKER_S = 30
"""Queues of clusters give workers late; who waits longer wants to know. Chosen by hand."""
_ADDRESS = re.compile(r"(tcp|tls|wss?)://[^\s/]+:\d{1,5}")


def run_on_cluster(tasks: Sequence[BatchTask], scheduler: str) -> Generator[BatchOutcome, None, None]:
    """Yield the outcome of each task as it ends, in no special order.

    Where a worker is lost, the scheduler gives its tasks to others. Closing the iterator takes back what was not begun.

    Parameters
    ----------
    tasks
        What to do; the paths in them must mean the same files on every worker.
    scheduler
        Address as tcp://HOST:PORT.

    Raises
    ------
    UsageError
        The library is not installed, or the address is none.
    RadarGuiError
        Nobody answers there, or it has no workers.
    """
    client = _connected(scheduler)
    try:
        _want_workers(client, scheduler)
        yield from _outcomes(client, tasks)
    finally:
        client.close()


def _outcomes(client: Any, tasks: Sequence[BatchTask]) -> Generator[BatchOutcome, None, None]:
    from distributed import as_completed

    # Not pure: what a task gives depends on the file, which the name of the task does not say.
    futures = client.map(work_on, tasks, pure=False)
    runs = {future.key: task.run for future, task in zip(futures, tasks, strict=True)}
    try:
        for future in as_completed(futures, loop=client.loop):
            run = runs[future.key]
            yield future.result() if future.status == "finished" else BatchOutcome(run, "failed", _why(future))
            future.release()
    finally:
        client.cancel([future for future in futures if not future.done()], reason="the batch was stopped")


def _connected(scheduler: str) -> Any:
    if not _ADDRESS.fullmatch(scheduler):
        raise UsageError(f"--scheduler = {scheduler!r}, allowed: tcp://HOST:PORT or tls://HOST:PORT")
    try:
        from distributed import Client
    except ImportError:
        raise worded(UsageError, "no_dask") from None
    try:
        return Client(scheduler, timeout=ANSWER_S, set_as_default=False)
    except OSError:
        # TimeoutError is one, too.
        raise worded(RadarGuiError, "no_scheduler", scheduler=scheduler) from None


def _want_workers(client: Any, scheduler: str) -> None:
    try:
        client.wait_for_workers(1, timeout=WORKER_S)
    except TimeoutError:
        raise worded(RadarGuiError, "no_workers", scheduler=scheduler) from None


def _why(future: Any) -> RadarGuiError:
    error = future.exception() if future.status == "error" else None
    if error is None or type(error).__name__ == "KilledWorker":
        return worded(ProcessingError, "no_answer_of_cluster")
    return worded(ProcessingError, "cluster_failed", kind=type(error).__name__, error=error)
