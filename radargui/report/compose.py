"""The report of a session put together from its sections."""

from __future__ import annotations

from collections.abc import Sequence

from radargui.report.document import Document
from radargui.report.run_facts import RunFacts
from radargui.report.run_section import run_section
from radargui.report.session_section import session_section
from radargui.session.info import SessionInfo


def compose(info: SessionInfo, runs: Sequence[RunFacts], made_at: str) -> Document:
    """Return the report of a session: session and setup, then one section a run.

    Parameters
    ----------
    info
        The session's record.
    runs
        In the order of their numbers.
    made_at
        Date and time of the report, for people.
    """
    sections = (session_section(info, runs, made_at), *(run_section(run, info.setup) for run in runs))
    return Document(f"RadarGUI report: {info.name}", info.operator, sections)
