"""A batch on an existing Dask cluster, whose workers see the same files."""

import re
from collections.abc import Generator, Sequence
from typing import Any

from radargui.experiment.batch.task import BatchOutcome, BatchTask, work_on
from radargui.model.errors import ProcessingError, RadarGuiError, UsageError

ANSWER_S = 10
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
        raise UsageError(
            "--scheduler needs the package dask.distributed, which is not installed.",
            remedy='Install it with: pip install "radargui[cluster]"',
        ) from None
    try:
        return Client(scheduler, timeout=ANSWER_S, set_as_default=False)
    except OSError:
        # TimeoutError is one, too.
        raise RadarGuiError(
            f"No Dask scheduler answers at {scheduler}.",
            reasons=("it is not running", "a firewall is between", "its version differs from the one here"),
            remedy="Start it with `dask scheduler`, or leave --scheduler out to use this computer.",
        ) from None


def _want_workers(client: Any, scheduler: str) -> None:
    try:
        client.wait_for_workers(1, timeout=WORKER_S)
    except TimeoutError:
        raise RadarGuiError(
            f"The Dask scheduler at {scheduler} has no workers.", remedy="Start some with `dask worker ADDRESS`."
        ) from None


def _why(future: Any) -> RadarGuiError:
    error = future.exception() if future.status == "error" else None
    if error is None or type(error).__name__ == "KilledWorker":
        return ProcessingError(
            "the workers that had it ended without an answer.",
            reasons=("their memory does not suffice", "the file makes a library crash"),
            remedy="Process this run alone.",
        )
    return ProcessingError(
        f"the cluster could not do it: {type(error).__name__}: {error}.",
        reasons=("RadarGUI is not installed on the workers",),
    )
