"""The work on a run that was just recorded: its result, compared with the live track, kept in its file."""

import contextlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from radargui.acquisition.live_track import LiveSpan
from radargui.experiment.live_agreement import LiveAgreement, live_agreement
from radargui.files.run_results import write_results
from radargui.model.errors import CancelledError
from radargui.model.result import RunResult
from radargui.model.setup import Setup
from radargui.processing.long_recording import read_for_processing
from radargui.processing.offline import cut_short, process
from radargui.session.front_ends import known_front_ends


@dataclass(frozen=True, slots=True)
class FinishedJob:
    """A run to process; can be sent to another process.

    Attributes
    ----------
    path
        Run file.
    setup
        Under which it was recorded.
    first_index
        Absolute index of its first sample.
    live
        Live estimates of its time; None where there are none.
    """

    path: Path
    setup: Setup
    first_index: int
    live: LiveSpan | None

    @property
    def has_preliminary(self) -> bool:
        """Whether there will be a preliminary result."""
        return self.setup.processing.correction == "joint"


def preliminary_result(job: FinishedJob) -> RunResult | None:
    """Return the preliminary result of a run, without computing the final one; None where there is none.

    Raises
    ------
    FileError
        The run cannot be read.
    ProcessingError
        The samples do not fit the setup.
    """
    found: list[RunResult] = []

    def enough(_: float) -> None:
        if found:
            raise CancelledError

    if job.has_preliminary:
        with contextlib.suppress(CancelledError):
            process(read_for_processing(job.path), job.setup, enough, found.append)
    return found[0] if found else None


def process_finished(
    job: FinishedJob, progress: Callable[[float], None], on_preliminary: Callable[[RunResult], None]
) -> tuple[RunResult, LiveAgreement | None]:
    """Process a run, keep results and agreement in its file, and return both.

    What earlier runs of its session say about the front ends is its prior.

    Parameters
    ----------
    job
        The run.
    progress
        Called with the share done, 0 to 1. Where it raises `CancelledError`, the preliminary result is kept, within
        a second; where the setup asks for a correction that has none, the work ends at once.
    on_preliminary
        Given the preliminary result, see `process`.

    Raises
    ------
    FileError
        The run cannot be read or written.
    ProcessingError
        The samples do not fit the setup.
    CancelledError
        `progress` did, and there is no preliminary result.
    """
    found: list[RunResult] = []
    cancelled = False

    def checked(fraction: float) -> None:
        nonlocal cancelled
        try:
            progress(fraction)
        except CancelledError:
            cancelled = True
        if cancelled and (found or not job.has_preliminary):
            raise CancelledError

    def keep(result: RunResult) -> None:
        found.append(result)
        on_preliminary(result)

    checked(0.0)
    recording = read_for_processing(job.path)
    try:
        result = process(recording, job.setup, checked, keep, known_front_ends(job.path, job.setup))
    except CancelledError:
        if not found:
            raise
        result = cut_short(found[0])
    agreement = None if job.live is None else live_agreement(job.live, job.first_index, result)
    write_results(job.path, result, health=None if agreement is None else agreement.record())
    return result, agreement
