"""What is written of sessions: PDF, HTML, CSV, JSON, LaTeX and BibTeX of one or of a series."""

import multiprocessing
from collections import deque
from collections.abc import Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, replace
from datetime import datetime
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

from radargui.files.access import Progress, fresh_files, silent
from radargui.files.run_card import read_run_card
from radargui.model.drop import RunOrigin
from radargui.model.errors import FileError, RadarGuiError
from radargui.model.setup import Setup
from radargui.report.content import Chapter
from radargui.report.facts import ReportFacts, SessionFacts, provenance_of, report_facts
from radargui.report.findings_section import front_chapters
from radargui.report.numbers import FILES, write_numbers
from radargui.report.plots import page_style
from radargui.report.run_facts import ResultOf, RunFacts, study
from radargui.report.run_section import run_page, run_section
from radargui.report.typesetting import Paper, Typesetter, section_html, write_html
from radargui.restitution.series import drop_labels
from radargui.restitution.speed_models import ModelName
from radargui.session.info import REPORT_FOLDER, own_subfolder
from radargui.session.session import BY_OPERATOR, Session, was_drop
from radargui.system.cores import begin_worker

_RUNS_SHARE = 0.95
"""Of the progress reported (chosen by hand): the pages before the runs, which are written last, have the rest."""
REPORT_FILES = ("report.pdf", "report.html", *FILES)


@dataclass(frozen=True, slots=True)
class WrittenReport:
    """Where the report is.

    Attributes
    ----------
    facts
        Sessions that it was made of, without curves: a series needs them again.
    pdf, html, json
        The report for people, on paper and on the screen, and for programs.
    csv
        One row an impact of each run.
    """

    facts: tuple[SessionFacts, ...] = field(repr=False, compare=False)
    pdf: Path
    html: Path
    csv: Path
    json: Path


@dataclass(frozen=True, slots=True)
class PageLayout:
    """How a report is laid out.

    Attributes
    ----------
    paper
        Of the PDF.
    details
        Several pages a run instead of one.
    model
        The dependence of e on the impact speed that the user chose; None: all are told.
    """

    paper: Paper = "a4"
    details: bool = False
    model: ModelName | None = None


class _Writer:
    """PDF and HTML of a report while it grows: runs go out as they come, what stands before them is put there last."""

    def __init__(self, pages: Typesetter) -> None:
        self._pages = pages
        self._sections: list[tuple[str, str, str]] = []

    def put(self, chapter: Chapter) -> None:
        """Add a chapter behind the others."""
        self._pages.put(chapter)
        self._sections.append(self._section(chapter, f"run-{len(self._sections) + 1}"))

    def write(self, report: WrittenReport, facts: ReportFacts, layout: PageLayout, title: str, author: str) -> None:
        """Put what was found before the runs, and write all files; without a PDF where that cannot be made."""
        front, folder = front_chapters(facts), report.pdf.parent
        self._pages.put_in_front(front)
        before = [self._section(chapter, f"part-{number}") for number, chapter in enumerate(front, 1)]
        with fresh_files((report.html,), force=True) as (html,):
            folder.mkdir(parents=True, exist_ok=True)
            write_html(html, title, [*before, *self._sections])
            write_numbers(facts, folder)
        with fresh_files((report.pdf,), force=True) as (pdf,):
            try:
                self._pages.write(pdf, layout.paper, title, author, facts.made_at)
            except FileError as error:
                raise FileError(f"{error} {report.pdf} was not written; the other files of the report were.") from error

    @staticmethod
    def _section(chapter: Chapter, name: str) -> tuple[str, str, str]:
        return name, chapter.title, section_html(chapter, name)


@contextmanager
def _writing() -> Iterator[_Writer]:
    """Hand out what writes PDF and HTML; figures wait in a folder that vanishes."""
    with page_style(), TemporaryDirectory(prefix="radargui-report-") as folder:
        yield _Writer(Typesetter(Path(folder)))


def write_report(
    session: Session,
    result_of: ResultOf,
    output: Path | None = None,
    progress: Progress = silent,
    *,
    now: datetime | None = None,
    layout: PageLayout = PageLayout(),
    ahead: bool = False,
) -> WrittenReport:
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
        Called with the share done, 0 to 1; what it raises ends the work, and the files that were there stay.
    now
        Date and time of the report with offset from UTC; the clock's where left out.
    layout
        Paper, and how much is said of each run.
    ahead
        Whether another process may read runs while pages are drawn: `result_of` must be a function that it can import.

    Raises
    ------
    FileError
        The folder cannot be written, or no PDF can be made; all other files are there then.
    SessionError
        The session's own report folder is a link out of the session.
    """
    folder = output or own_subfolder(session.path, REPORT_FOLDER)
    made_at = _moment(now)
    report = WrittenReport((), *(folder / name for name in REPORT_FILES[:4]))
    paths, labels, kept = session.run_paths(), labels_of(session), list[RunFacts]()
    origins = set(_origins(paths).values())
    mark = ", simulated" if {origin.kind for origin in origins} == {"simulated"} else ""
    with _writing() as writer:
        for run in studied(paths, session.setup, result_of, detailed=layout.details, ahead=ahead):
            named = replace(run, label=labels[run.name])
            writer.put(run_section(named, session.setup) if layout.details else run_page(named))
            # figures are drawn: of hundreds of runs only the numbers stay
            kept.append(replace(named, curves=None))
            progress(_RUNS_SHARE * len(kept) / len(paths))
        facts = _facts(session, kept, made_at)
        title = f"RadarGUI report: {session.info.name}{mark}"
        writer.write(report, report_facts([facts], made_at, layout.model), layout, title, session.info.operator)
    progress(1.0)
    return replace(report, facts=(facts,))


def _moment(now: datetime | None = None) -> str:
    return (now or datetime.now().astimezone()).isoformat(sep=" ", timespec="seconds")


def _facts(session: Session, runs: Sequence[RunFacts], made_at: str) -> SessionFacts:
    return SessionFacts(session.info, tuple(runs), provenance_of(session, {run.name: run for run in runs}, made_at))


def study_session(session: Session, result_of: ResultOf, progress: Progress = silent) -> SessionFacts:
    """Return what a series needs of a session, without pages; parameters as for `write_report`."""
    paths, labels, kept = session.run_paths(), labels_of(session), list[RunFacts]()
    for run in studied(paths, session.setup, result_of, detailed=False, ahead=False):
        kept.append(replace(run, label=labels[run.name], curves=None))
        progress(len(kept) / len(paths))
    return _facts(session, kept, _moment())


def write_series_report(
    sessions: Sequence[SessionFacts], output: Path, layout: PageLayout = PageLayout()
) -> WrittenReport:
    """Write what sessions found together; the pages of single runs are in their own reports.

    Parameters
    ----------
    sessions
        At least two, as their own reports give them.
    output
        Folder of the report's files, which are replaced there.
    layout
        Paper, and the model of e against the speed.

    Raises
    ------
    FileError
        The folder cannot be written.
    """
    made_at = _moment()
    facts = report_facts(sessions, made_at, layout.model)
    report = WrittenReport(tuple(sessions), *(output / name for name in REPORT_FILES[:4]))
    operators = ", ".join(dict.fromkeys(one.info.operator for one in sessions if one.info.operator))
    with _writing() as writer:
        writer.write(report, facts, layout, f"RadarGUI series: {len(sessions)} sessions", operators)
    return report


def _origins(paths: Sequence[Path]) -> dict[str, RunOrigin]:
    origins = {}
    for path in paths:
        with suppress(RadarGuiError):
            origins[path.stem] = read_run_card(path).origin
    return origins


def labels_of(session: Session) -> dict[str, str]:
    """Return what the drops are called, also with those in mind that were rejected and keep their number."""
    rejected, origins = session.rejected, _origins(session.run_paths())
    return drop_labels(
        (path.stem, origins.get(path.stem), was_drop(rejected.get(path.name, BY_OPERATOR)))
        for path in session.run_paths(with_rejected=True)
    )


_FEWEST = 6
"""Runs from which on a process of its own costs less than it saves: it takes about a second to begin."""
_AHEAD = 3
"""Runs that wait for their page: some megabytes."""


def studied(
    paths: Sequence[Path], setup: Setup, result_of: ResultOf, *, detailed: bool, ahead: bool
) -> Iterator[RunFacts]:
    """Yield the facts of each run, in order.

    Parameters
    ----------
    paths
        Run files.
    setup, result_of, detailed
        See `study`.
    ahead
        Whether another process may read the next runs while one is drawn.
    """
    work = partial(study, setup=setup, result_of=result_of, detailed=detailed)
    if not ahead or len(paths) < _FEWEST:
        yield from map(work, paths)
        return
    context = multiprocessing.get_context("spawn")
    pool = ProcessPoolExecutor(1, context, begin_worker)
    try:
        waiting: deque[Future[RunFacts]] = deque()
        for path in paths:
            waiting.append(pool.submit(work, path))
            if len(waiting) > _AHEAD:
                yield waiting.popleft().result()
        while waiting:
            yield waiting.popleft().result()
    finally:
        pool.shutdown(cancel_futures=True)
