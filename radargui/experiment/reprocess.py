"""Finish runs that a crash left, and compute stored runs again."""

from collections.abc import Callable, Sequence
from contextlib import closing, suppress
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

from radargui.experiment.finished import FinishedJob
from radargui.experiment.processing_apart import ProcessingApart
from radargui.files.access import Outcome, Progress, each_run, silent
from radargui.files.run_file import read_run_setup, run_is_complete
from radargui.files.run_results import finish_run, write_results
from radargui.model.errors import FileError, RadarGuiError, UsageError
from radargui.model.result import RunResult
from radargui.model.setup import Setup
from radargui.processing.long_recording import read_for_processing
from radargui.processing.process import OnPreliminary, process
from radargui.session.catalogue import Catalogue, RunLine
from radargui.session.info import FILE_NAME
from radargui.session.known_setup import known_front_ends, known_setup_of_run
from radargui.session.lock import Owner, SessionLock, owner_of
from radargui.session.session import Session


def process_run(
    path: Path,
    setup: Setup | None = None,
    *,
    progress: Progress | None = None,
    on_preliminary: OnPreliminary | None = None,
) -> RunResult:
    """Process a run file and store the results in it, in place of older ones; its samples are not touched.

    What earlier runs of its session say about the front ends, and all others about the antennas, is its prior.

    Parameters
    ----------
    path
        Run file.
    setup
        None: the one it was recorded with.
    progress
        Called with the share done, 0 to 1; what it raises ends the work, and the stored results stay.
    on_preliminary
        See `process`.

    Raises
    ------
    FileError
        The run cannot be read or written.
    SetupError
        The setup in the run is not valid for this version.
    UsageError
        No setup was given and the run holds none.
    ProcessingError
        The samples do not fit the setup.
    """
    result = computed(path, setup or own_setup(path), progress, on_preliminary)
    write_results(path, result)
    return result


def computed(
    path: Path, setup: Setup, progress: Progress | None = None, on_preliminary: OnPreliminary | None = None
) -> RunResult:
    """Return what a run gives with a setup, with what the other runs of its session say as prior; nothing is stored.

    Parameters and errors as for `process_run`.
    """
    known = known_front_ends(path, setup), known_setup_of_run(path, setup)
    return process(read_for_processing(path), setup, progress, on_preliminary, *known)


def own_setup(path: Path) -> Setup:
    """Return the setup a run was recorded with.

    Raises
    ------
    UsageError
        It holds none.
    """
    setup = read_run_setup(path)
    if setup is None:
        raise UsageError(f"{path} holds no setup", remedy="Name a setup file with --setup.")
    return setup


NOTHING = "nothing was recorded"


def unfinished_runs(data_folder: Path, index: Path | None = None, progress: Progress = silent) -> tuple[RunLine, ...]:
    """Return the runs below a folder that a crash, a kill or a failure left unfinished.

    Sessions that a program writes to now are left out.

    Parameters
    ----------
    data_folder
        Its sessions, at any depth; or one session.
    index
        See `Catalogue`.
    progress
        Called with the share of the look that is done; what it raises ends it.
    """
    found = _unfinished(data_folder, index, progress)
    busy = {folder for folder in {line.path.parent for line in found} if owner_of(folder) is not None}
    return tuple(line for line in found if line.path.parent not in busy and not _is_complete(line.path))


def held_runs(data_folder: Path, index: Path | None = None) -> dict[Path, Owner]:
    """Return the unfinished runs that `unfinished_runs` leaves out, with the program that writes to their session.

    One on another computer may be gone: nobody can know from here (see `SessionLock`).

    Parameters
    ----------
    data_folder, index
        See `unfinished_runs`.
    """
    runs = [line.path for line in _unfinished(data_folder, index, silent)]
    owners = {folder: owner_of(folder) for folder in {run.parent for run in runs}}
    return {run: owner for run in runs if (owner := owners[run.parent]) is not None}


def _unfinished(data_folder: Path, index: Path | None, progress: Progress) -> list[RunLine]:
    with closing(Catalogue(data_folder, index)) as catalogue:
        catalogue.refresh(progress)
        return [line for line in catalogue.unfinished() if not line.problem]


def recover(run: Path, *, now: datetime) -> int:
    """Finish an unfinished run, mark it as recovered, and return how many samples of each channel it holds.

    One without any sample is set aside in its session.

    Parameters
    ----------
    run
        Run file.
    now
        Date and time with offset from UTC.

    Raises
    ------
    SessionError
        Another program writes to the session, or its folder cannot be written.
    FileError
        The run cannot be read, or was closed in order.
    """
    lock = SessionLock(run.parent)
    try:
        at = (now if now.tzinfo else now.astimezone()).isoformat(timespec="seconds")
        count = finish_run(run, now=at)
        if count == 0 and (run.parent / FILE_NAME).is_file():
            with closing(Session.open(run.parent)) as session:
                session.reject(run, NOTHING)
    finally:
        lock.release()
    return count


def _is_complete(path: Path) -> bool:
    with suppress(FileError):
        return run_is_complete(path)
    return True


@dataclass(frozen=True, slots=True)
class RecoveredRun:
    """What became of an unfinished run.

    Attributes
    ----------
    path
        Run file.
    n_samples
        Samples of each channel that it holds.
    result
        None where it was not processed.
    error
        Why it could not be processed; the recording is finished and safe all the same.
    """

    path: Path
    n_samples: int
    result: RunResult | None = None
    error: RadarGuiError | None = None


def recover_run(run: Path, *, now: datetime, progress: Progress | None = None) -> RecoveredRun:
    """Finish an unfinished run, mark it as recovered, process it, and keep the results beside its samples.

    Parameters
    ----------
    run
        Run file, see `unfinished_runs`.
    now
        Date and time with offset from UTC.
    progress
        Called with the share of the processing done.

    Raises
    ------
    SessionError
        Another program writes to the session, or its folder cannot be written.
    FileError
        The run cannot be read, or was closed in order; it is as it was.
    """
    count = recover(run, now=now)
    if count == 0:
        return RecoveredRun(run, count)
    try:
        return RecoveredRun(run, count, process_run(run, progress=progress))
    except RadarGuiError as error:
        return RecoveredRun(run, count, error=error)


def compute_later(
    runs: Sequence[Path], progress: Progress, setup_of: Callable[[Path], Setup] = own_setup
) -> tuple[Outcome[RunResult], ...]:
    """Compute the results of runs that were left for later, one after the other in a process of its own.

    Parameters
    ----------
    runs
        Run files.
    progress
        Called with the share of all that is done; what it raises ends the work.
    setup_of
        Gives the setup of each; left out: the one it was recorded with.
    """
    with closing(ProcessingApart()) as apart:

        def compute(run: Path, report: Progress) -> RunResult:
            return apart.process(FinishedJob(run, setup_of(run), 0, None), report, lambda _preliminary: None)[0]

        return tuple(each_run(runs, compute, progress))
