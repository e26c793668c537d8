"""The report of a session: PDF, HTML, CSV and JSON."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from datetime import datetime
from pathlib import Path

from radargui.files.access import Progress, fresh_files
from radargui.model.drop import RunOrigin
from radargui.report.document import Document
from radargui.report.facts import SessionFacts, report_facts
from radargui.report.numbers import FILES, write_numbers
from radargui.report.provenance import provenance_of
from radargui.report.rendering import render
from radargui.report.run_section import ResultOf, RunFacts, all_simulated, run_section, study
from radargui.report.session_section import session_section
from radargui.restitution.series import drop_labels
from radargui.restitution.speed_models import ModelName
from radargui.session.info import REPORT_FOLDER, SessionInfo, own_subfolder
from radargui.session.session import BY_OPERATOR, Session

_READING_SHARE = 0.5
REPORT_FILES = ("report.pdf", "report.html", *FILES)


@dataclass(frozen=True, slots=True)
class Report:
    """Where the report is.

    Attributes
    ----------
    facts
        Sessions that it was made of, without curves: a series needs them again.
    pdf, html, json
        The report for people, on paper and on the screen, and for programs.
    csv
        One row an impact of each run.
    series_csv
        Statistics of the series.
    tex, bib
        The tables for LaTeX, and how to cite the session.
    """

    facts: tuple[SessionFacts, ...] = field(repr=False, compare=False)
    pdf: Path
    html: Path
    csv: Path
    json: Path
    series_csv: Path
    tex: Path
    bib: Path


def write_report(
    session: Session,
    result_of: ResultOf,
    output: Path | None = None,
    progress: Progress | None = None,
    *,
    now: datetime | None = None,
    model: ModelName | None = None,
) -> Report:
    """Write what all runs of a session give with its setup.

    Parameters
    ----------
    session
        A run of it that cannot be read or processed gets a section that says why.
    result_of
        Gives the result of each run, see `study`.
    output
        Folder of the report's files, which are replaced there; the session's own `report` folder where left out.
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
    SessionError
        The session's own report folder is a link out of the session.
    """
    report_progress = progress or (lambda _: None)
    folder = output or own_subfolder(session.path, REPORT_FOLDER)
    made_at = (now or datetime.now().astimezone()).isoformat(sep=" ", timespec="seconds")
    runs = _study_all(session, result_of, report_progress)
    facts = _facts(session, runs, made_at)
    report = Report((facts,), *(folder / name for name in REPORT_FILES))
    write_numbers(report_facts([facts], made_at, model), folder)
    with fresh_files((report.pdf, report.html), force=True) as (pdf, html):
        render(
            compose(session.info, runs, made_at),
            pdf,
            html,
            lambda share: report_progress(_READING_SHARE + (1.0 - _READING_SHARE) * share),
        )
    report_progress(1.0)
    return report


def study_session(session: Session, result_of: ResultOf, progress: Progress, made_at: str) -> SessionFacts:
    """Return what a series needs of a session, without pages."""
    return _facts(session, _study_all(session, result_of, progress, drawn=False), made_at)


def _facts(session: Session, runs: Sequence[RunFacts], made_at: str) -> SessionFacts:
    without = {run.name: replace(run, curves=None) for run in runs}
    return SessionFacts(session.info, tuple(without.values()), provenance_of(session, without, made_at))


def _study_all(
    session: Session, result_of: ResultOf, report_progress: Progress, *, drawn: bool = True
) -> list[RunFacts]:
    paths = session.run_paths()
    runs = []
    for number, path in enumerate(paths):

        def part(done: float, number: int = number) -> None:
            report_progress(_READING_SHARE * (number + done) / len(paths))

        runs.append(study(path, session.setup, result_of, part, drawn=drawn))
        part(1.0)
    labels = _labels(session, {run.name: run.source for run in runs})
    return [replace(run, label=labels[run.name]) for run in runs]


def _labels(session: Session, origins: dict[str, RunOrigin]) -> dict[str, str]:
    """Return what the drops are called, also with those in mind that were rejected and keep their number."""
    rejected = session.rejected
    return drop_labels(
        (path.stem, origins.get(path.stem), rejected.get(path.name, BY_OPERATOR) == BY_OPERATOR)
        for path in session.run_paths(with_rejected=True)
    )


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
    # on the foot of every page
    mark = ", simulated" if all_simulated(runs) else ""
    return Document(f"RadarGUI report: {info.name}{mark}", info.operator, sections)
