"""Write reports of sessions whose runs may still be without results: those are computed first."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from radargui import __version__
from radargui.experiment.reprocess import compute_later, own_setup
from radargui.files.access import Progress
from radargui.files.stored_results import read_stored_results
from radargui.model.errors import FileError
from radargui.model.setup import Setup
from radargui.processing.result_of_run import setup_of_result, stored_or_computed, stored_result
from radargui.session.session import Session

if TYPE_CHECKING:
    from radargui.report.report import WrittenReport


def setup_of(run: Path) -> Setup:
    """Return what the stored results were made with, so that they are shown; else what the run was recorded with."""
    return setup_of_result(run) or own_setup(run)


def report_session(session: Session, progress: Progress) -> WrittenReport:
    """Write the report of a session; results that are missing are computed in a process of their own.

    Parameters
    ----------
    progress
        Called with the share done, 0 to 1; what it raises ends the work.
    """
    # matplotlib is loaded only where a report is made
    from radargui.report.report import write_report

    missing = [path for path in session.run_paths() if not _is_computed(path)]
    share = len(missing) / (len(missing) + 1)
    if missing:
        compute_later(missing, lambda done: progress(share * done), setup_of)
    return write_report(session, stored_result, progress=lambda done: progress(share + (1.0 - share) * done))


def _is_computed(path: Path) -> bool:
    try:
        stored = read_stored_results(path)
    except FileError:
        # the report says why
        return True
    return bool(stored) and stored[-1].is_present and stored[-1].version == __version__


def report_series(sessions: Sequence[Path], output: Path, progress: Progress) -> Path:
    """Write the report of several sessions together; return its folder. `progress` as for `report_session`."""
    from radargui.report.report import study_session, write_series_report

    facts = []
    for number, path in enumerate(sessions):

        def part(share: float, number: int = number) -> None:
            progress((number + share) / (len(sessions) + 1))

        session = Session.open(path, write=False)
        facts.append(study_session(session, stored_or_computed, part))
    return write_series_report(facts, output).pdf.parent
