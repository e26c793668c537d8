"""The work on a run that was just recorded: its result, compared with the live track, kept in its file."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from radargui.acquisition.live_track import LiveSpan
from radargui.experiment.live_agreement import LiveAgreement, live_agreement
from radargui.experiment.reprocess import process_run
from radargui.model.result import RunResult
from radargui.model.setup import Setup


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


def process_finished(job: FinishedJob, progress: Callable[[float], None]) -> tuple[RunResult, LiveAgreement | None]:
    """Process a run, keep results and agreement in its file, and return both.

    Raises
    ------
    FileError
        The run cannot be read or written.
    ProcessingError
        The samples do not fit the setup.
    """
    found: list[LiveAgreement] = []

    def compared(result: RunResult) -> dict[str, object]:
        agreement = None if job.live is None else live_agreement(job.live, job.first_index, result)
        if agreement is None:
            return {}
        found.append(agreement)
        return agreement.record()

    progress(0.0)
    result = process_run(job.path, job.setup, progress=progress, health_of=compared)
    return result, found[0] if found else None
