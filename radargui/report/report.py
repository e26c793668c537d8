"""The report of a session: PDF, HTML, CSV and JSON."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

from radargui.report.compose import compose
from radargui.report.document import Document
from radargui.report.html import HtmlReport, inline
from radargui.report.pdf import PdfReport
from radargui.report.plain_values import json_bytes
from radargui.report.run_facts import RunFacts, study
from radargui.report.series_files import impacts_csv, series_csv, session_document
from radargui.report.style import page_style
from radargui.report.whole_file import forget, partial_path, put_in_place, refusal, write_whole
from radargui.session.session import Session

FOLDER = "report"
_PROCESSING_SHARE = 0.5

Progress = Callable[[float], None]


@dataclass(frozen=True, slots=True)
class Report:
    """Where the report is.

    Attributes
    ----------
    pdf, html, json
        The report for people, on paper and on the screen, and for programs.
    csv
        One row an impact of each run.
    series_csv
        Statistics of the series.
    """

    pdf: Path
    html: Path
    csv: Path
    json: Path
    series_csv: Path


def write_report(
    session: Session,
    output: Path | None = None,
    progress: Progress | None = None,
    *,
    now: datetime | None = None,
) -> Report:
    """Write what all runs of a session give with its setup; only what their files do not hold is computed.

    Parameters
    ----------
    session
        A run of it that cannot be read or processed gets a section that says why.
    output
        Folder of the report's files, which are replaced there; the session's own `report` folder where left out.
    progress
        Called with the share done, 0 to 1.
    now
        Date and time of the report with offset from UTC; the clock's where left out.

    Raises
    ------
    FileError
        The folder cannot be written.
    """
    tell = progress or (lambda _: None)
    folder = output or session.path / FOLDER
    made_at = (now or datetime.now().astimezone()).isoformat(sep=" ", timespec="seconds")
    report = Report(
        folder / "report.pdf",
        folder / "report.html",
        folder / "report.csv",
        folder / "report.json",
        folder / "report-series.csv",
    )
    runs = _study_all(session, tell)
    write_whole(report.csv, [impacts_csv(runs)])
    write_whole(report.series_csv, [series_csv(runs)])
    write_whole(report.json, [json_bytes(session_document(session.info, runs, made_at))])
    _draw(compose(session.info, runs, made_at), report, tell)
    tell(1.0)
    return report


def _study_all(session: Session, tell: Progress) -> list[RunFacts]:
    paths = session.run_paths()
    runs = []
    for number, path in enumerate(paths):

        def part(done: float, number: int = number) -> None:
            tell(_PROCESSING_SHARE * (number + done) / len(paths))

        runs.append(study(path, session.setup, part))
        part(1.0)
    return runs


def _draw(document: Document, report: Report, tell: Progress) -> None:
    """Draw each page once, for PDF and HTML."""
    files: Sequence[Path] = (report.pdf, report.html)
    try:
        with (
            page_style(),
            partial_path(report.html).open("w", encoding="utf-8", errors="replace", newline="\n") as file,
            PdfReport(partial_path(report.pdf), document) as pdf,
        ):
            html = HtmlReport(file, document)
            for number, section in enumerate(document.sections, 1):
                pdf.add_text(section)
                pictures = []
                for picture in section.pictures:
                    page = picture.draw()
                    pictures.append(inline(picture.title, page))
                    pdf.add(page, f"{section.title}: {picture.title}")
                html.add(section, pictures)
                tell(_PROCESSING_SHARE + (1.0 - _PROCESSING_SHARE) * number / len(document.sections))
            html.end()
        for path in files:
            put_in_place(path)
    except OSError as error:
        for path in files:
            forget(path)
        raise refusal(report.pdf.parent, error) from None
    except BaseException:
        for path in files:
            forget(path)
        raise
