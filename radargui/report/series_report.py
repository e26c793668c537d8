"""The report of several sessions together: other heights, samples, days."""

from collections.abc import Sequence
from datetime import datetime
from pathlib import Path

from radargui.files.access import Progress, fresh_files, silent
from radargui.report.document import Document
from radargui.report.facts import SessionFacts, report_facts
from radargui.report.numbers import write_numbers
from radargui.report.rendering import render
from radargui.report.report import REPORT_FILES, Report
from radargui.report.series_section import series_section
from radargui.report.session_section import session_section
from radargui.restitution.speed_models import ModelName


def write_series_report(
    sessions: Sequence[SessionFacts],
    output: Path,
    progress: Progress = silent,
    *,
    now: datetime | None = None,
    model: ModelName | None = None,
) -> Report:
    """Write what sessions found together; the pages of single runs are in their own reports.

    Parameters
    ----------
    sessions
        At least two, as their own reports give them.
    output
        Folder of the report's files, which are replaced there.
    progress
        Called with the share done, 0 to 1.
    now
        Date and time of the report with offset from UTC; the clock's where left out.
    model
        The dependence of e on the impact speed that the user chose; left out: all are told.

    Raises
    ------
    FileError
        The folder cannot be written.
    """
    made_at = (now or datetime.now().astimezone()).isoformat(sep=" ", timespec="seconds")
    facts = report_facts(sessions, made_at, model)
    report = Report(tuple(sessions), *(output / name for name in REPORT_FILES))
    write_numbers(facts, output)
    sections = (series_section(facts), *(session_section(one.info, one.runs, made_at) for one in sessions))
    operators = ", ".join(dict.fromkeys(one.info.operator for one in sessions if one.info.operator))
    with fresh_files((report.pdf, report.html), force=True) as (pdf, html):
        render(Document(f"RadarGUI series: {len(sessions)} sessions", operators, sections), pdf, html, progress)
    return report
