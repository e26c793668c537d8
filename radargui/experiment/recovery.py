"""Recovery of what a crash left: the run is finished, marked, and processed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

from radargui.experiment.reprocess import process_run
from radargui.model.errors import RadarGuiError
from radargui.model.result import RunResult
from radargui.session.recovery import recover


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


def recover_run(
    run: Path, *, now: datetime, process: bool = True, progress: Callable[[float], None] | None = None
) -> RecoveredRun:
    """Finish an unfinished run, mark it as recovered, process it, and keep the results beside its samples.

    Parameters
    ----------
    run
        Run file, see `session.recovery.unfinished_runs`.
    now
        Date and time with offset from UTC.
    process
        Whether to process it.
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
    if not process or count == 0:
        return RecoveredRun(run, count)
    try:
        return RecoveredRun(run, count, process_run(run, progress=progress))
    except RadarGuiError as error:
        return RecoveredRun(run, count, error=error)
