"""Process many stored runs again, on all cores of this computer or on a cluster.

The work on one run of a batch, the same on this computer and on a cluster. Run the tasks of a batch on the cores of
this computer, or on a Dask cluster that sees the same files.
"""

import logging
import multiprocessing
import os
import re
from collections import deque
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass, field
from multiprocessing.synchronize import Event
from pathlib import Path
from typing import Any, Literal

from radargui import __version__
from radargui.experiment.reprocess import own_setup
from radargui.files.formats import RUN
from radargui.files.run_card import summarise
from radargui.files.run_results import results_are_current, write_results
from radargui.files.stored_results import read_prior
from radargui.model.errors import (
    CancelledError,
    FileError,
    ProcessingError,
    RadarGuiError,
    UsageError,
    fault_of,
    worded,
)
from radargui.model.result import RunResult
from radargui.model.setup import Setup, changed
from radargui.processing.long_recording import read_for_processing
from radargui.processing.process import process
from radargui.session.known_setup import known_setup_of_run
from radargui.session.session import run_paths
from radargui.system.cores import begin_worker, workers_ignoring_interrupts

_logger = logging.getLogger(__name__)
State = Literal["done", "skipped", "failed", "stopped"]


@dataclass(frozen=True, slots=True)
class TablesTo:
    """Tables instead of results within the run file, which then is only read.

    Attributes
    ----------
    folder
        Where the tables of this run go.
    write
        Writes them; a function that another process can import.
    are_current
        Tells whether those in a folder were made by this version with a setup.
    """

    folder: Path
    write: Callable[[RunResult, Path], None]
    are_current: Callable[[Path, Setup], bool]


@dataclass(frozen=True, slots=True)
class BatchTask:
    """One run and what to do with it.

    Attributes
    ----------
    run
        Run file, as whoever works on it finds it.
    setup
        None: the one it was recorded with.
    changes
        Keys of the setup with another value (see `changed`).
    force
        Whether results that are current already are made again.
    tables
        Where tables go; None: the results are stored in the run.
    version
        Of the program that gave the task.
    """

    run: Path
    setup: Setup | None = field(default=None, repr=False)
    changes: Mapping[str, str | int] = field(default_factory=dict)
    force: bool = False
    tables: TablesTo | None = field(default=None, repr=False)
    version: str = __version__


@dataclass(frozen=True, slots=True)
class BatchOutcome:
    """What became of a task.

    Attributes
    ----------
    run
        Run file.
    state
        done; skipped: its results are current already; failed; stopped: not done because the batch was stopped.
    error
        Why it failed.
    summary
        See `summarise`; empty unless done.
    """

    run: Path
    state: State
    error: RadarGuiError | None = None
    summary: Mapping[str, object] = field(default_factory=dict)


def work_on(task: BatchTask, progress: Callable[[float], None] | None = None) -> BatchOutcome:
    """Process one run; whatever goes wrong is in the outcome.

    What is known about the front ends is what the stored result had as prior; others say something about the antennas
    where this result was made with them before: the order in which workers end must not show in the results.

    Parameters
    ----------
    task
        What to do.
    progress
        Called with the share done; may raise `CancelledError`.
    """
    try:
        return _work_on(task, progress)
    except CancelledError:
        return BatchOutcome(task.run, "stopped")
    except RadarGuiError as error:
        return BatchOutcome(task.run, "failed", error)
    except Exception as error:
        _logger.exception("%s failed", task.run)
        return BatchOutcome(task.run, "failed", fault_of(error, "processing"))


def _work_on(task: BatchTask, progress: Callable[[float], None] | None) -> BatchOutcome:
    # computers of a cluster may have different installations: all runs of a batch come from one version
    if task.version != __version__:
        versions = {"own": __version__, "version": task.version}
        raise worded(ProcessingError, "other_version", process=os.getpid(), **versions)
    setup = changed(task.setup or own_setup(task.run), task.changes, "command line")
    to = task.tables
    if not task.force and (to.are_current(to.folder, setup) if to else results_are_current(task.run, setup)):
        return BatchOutcome(task.run, "skipped")
    others = known_setup_of_run(task.run, setup, only_again=True)
    result = process(read_for_processing(task.run), setup, progress, front_ends=read_prior(task.run), others=others)
    if to is None:
        write_results(task.run, result)
    else:
        to.write(result, to.folder)
    return BatchOutcome(task.run, "done", summary=summarise(result))


@dataclass(frozen=True, slots=True)
class FoundRun:
    """A run and where it lies below the path that was given.

    Attributes
    ----------
    path
        Absolute path of the run file.
    place
        Folder of its own for what is made from it, relative, without any way out.
    """

    path: Path
    place: Path


@dataclass(frozen=True, slots=True)
class FoundRuns:
    """What there is to work on.

    Attributes
    ----------
    runs
        Each once, in order.
    errors
        Paths that hold no run, with the reason.
    """

    runs: tuple[FoundRun, ...]
    errors: tuple[RadarGuiError, ...]


def find_runs(paths: Sequence[Path]) -> FoundRuns:
    """Return all runs in sessions, folders of sessions at any depth, and run files; links to folders are not followed.

    Parameters
    ----------
    paths
        Sessions, folders, run files.
    """
    runs: dict[Path, FoundRun] = {}
    errors: list[RadarGuiError] = []
    for path in paths:
        found = list(_below(path.absolute()))
        for one in found:
            # a run that is reached twice, by a folder and by its own name or by a link, is worked on once
            runs.setdefault(Path(os.path.realpath(one.path)), one)
        if not found:
            errors.append(_nothing(path))
    return FoundRuns(tuple(runs.values()), tuple(errors))


def _below(path: Path) -> Iterator[FoundRun]:
    if path.is_file():
        if path.suffix.lower() in RUN.suffixes:
            yield FoundRun(path, Path(path.parent.name, path.stem))
        return
    base = path.resolve()
    for folder, inside, _ in os.walk(path):
        inside.sort()
        for run in run_paths(Path(folder)):
            below = run.parent.relative_to(path)
            yield FoundRun(run, (below if below.parts else Path(base.name)) / run.stem)


def _nothing(path: Path) -> FileError:
    if not path.exists():
        return FileError(f"{path}: no such file or folder.", remedy="Check the path.")
    why = "is no run file" if path.is_file() else "holds no runs"
    return FileError(f"{path} {why}.", remedy="Give sessions, folders of sessions, or run files.")


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
