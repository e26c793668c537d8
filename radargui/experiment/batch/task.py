"""The work on one run of a batch, the same on this computer and on a cluster."""

import logging
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from radargui import __version__
from radargui.experiment.reprocess import own_setup
from radargui.files.formats import RUN
from radargui.files.run_card import summarise
from radargui.files.run_results import results_are_current, write_results
from radargui.files.stored_results import read_prior
from radargui.model.errors import CancelledError, FileError, ProcessingError, RadarGuiError, fault_of, worded
from radargui.model.result import RunResult
from radargui.model.setup import Setup, changed
from radargui.processing.long_recording import read_for_processing
from radargui.processing.process import process
from radargui.session.known_setup import known_setup_of_run
from radargui.session.session import run_paths

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
    changes: Mapping[str, str] = field(default_factory=dict)
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
