"""Write the files of a report: PDF, HTML, CSV, JSON, LaTeX and BibTeX of one session or a series, or figures."""

import multiprocessing
import re
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, replace
from datetime import datetime
from functools import partial
from pathlib import Path

from matplotlib.figure import Figure

from radargui.files.access import Progress, fresh_files, silent
from radargui.files.run_card import read_run_card
from radargui.model.drop import RunOrigin
from radargui.model.errors import RadarGuiError, UsageError
from radargui.model.setup import Setup
from radargui.model.workers import begin_worker
from radargui.report import sheet
from radargui.report.canvas import Canvas
from radargui.report.curves import RunCurves
from radargui.report.document import Chapter
from radargui.report.facts import ReportFacts, SessionFacts, report_facts
from radargui.report.findings_section import front_chapters
from radargui.report.numbers import FILES, write_numbers
from radargui.report.provenance import provenance_of
from radargui.report.rendering import PdfFile, section_html, write_html
from radargui.report.run_facts import ResultOf, RunFacts, study
from radargui.report.run_figures import RunDrawing
from radargui.report.run_section import run_page, run_section
from radargui.report.series_figures import draw_falls, draw_speeds, draw_spread
from radargui.report.sheet import Area, Paper
from radargui.restitution.series import drop_labels
from radargui.restitution.speed_models import ModelName
from radargui.session.info import REPORT_FOLDER, own_subfolder
from radargui.session.session import BY_OPERATOR, Session, was_drop

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
    """PDF and HTML of a report while it grows: runs go out as they come, what stands before them is written last."""

    def __init__(self, pdf: PdfFile) -> None:
        self._pdf = pdf
        self.sections: list[tuple[str, str, str]] = []

    def put(self, chapter: Chapter, kind: str = "run") -> None:
        self._pdf.put(chapter)
        name = f"{kind}-{len(self.sections) + 1}"
        self.sections.append((name, chapter.title, section_html(chapter, name)))

    def put_front(self, facts: ReportFacts) -> None:
        runs, self.sections = self.sections, []
        with self._pdf.in_front():
            for chapter in front_chapters(facts):
                self.put(chapter, "part")
        self.sections += runs


@contextmanager
def _writing(report: WrittenReport, layout: PageLayout, title: str, author: str) -> Iterator[_Writer]:
    """Hand out what writes PDF and HTML; they are put in place when all went well, else they vanish."""
    with sheet.page_style(), fresh_files((report.pdf, report.html), force=True) as (pdf, html):
        report.pdf.parent.mkdir(parents=True, exist_ok=True)
        with PdfFile(pdf, layout.paper, title, author) as file:
            writer = _Writer(file)
            yield writer
        write_html(html, title, writer.sections)


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
        The folder cannot be written.
    SessionError
        The session's own report folder is a link out of the session.
    """
    folder = output or own_subfolder(session.path, REPORT_FOLDER)
    made_at = _moment(now)
    report = WrittenReport((), *(folder / name for name in REPORT_FILES[:4]))
    paths, labels, kept = session.run_paths(), labels_of(session), list[RunFacts]()
    origins = set(_origins(paths).values())
    mark = ", simulated" if {origin.kind for origin in origins} == {"simulated"} else ""
    with _writing(report, layout, f"RadarGUI report: {session.info.name}{mark}", session.info.operator) as writer:
        for run in studied(paths, session.setup, result_of, detailed=layout.details, ahead=ahead):
            named = replace(run, label=labels[run.name])
            writer.put(run_section(named, session.setup) if layout.details else run_page(named))
            # figures are drawn: of hundreds of runs only the numbers stay
            kept.append(replace(named, curves=None))
            progress(_RUNS_SHARE * len(kept) / len(paths))
        facts = _facts(session, kept, made_at)
        of_report = report_facts([facts], made_at, layout.model)
        writer.put_front(of_report)
        write_numbers(of_report, folder)
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
    with _writing(report, layout, f"RadarGUI series: {len(sessions)} sessions", operators) as writer:
        writer.put_front(facts)
        write_numbers(facts, output)
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


FIGURES_FOLDER = "figures"
FORMATS = ("pdf", "svg", "png")
_DPI = 600
"""Of the PNG (chosen by hand): the thinnest lines, of 0.25 points, are two pixels wide; 86 mm are 2031."""
_LENGTH = re.compile(r"(\d+(?:\.\d+)?)\s*(mm|cm|in)")
_UNITS_MM = {"mm": 1.0, "cm": 10.0, "in": sheet.MM_PER_INCH}  # what people write widths in
_NARROWEST_MM, _WIDEST_MM = 60.0, 250.0
"""Of a figure: at 54 mm numbers of neighbouring ticks meet, from 55 mm on no texts do (60 leaves some room for more
digits); more than 210 is beyond A4."""
_LEFT_MM, _RIGHT_MM, _TOP_MM, _BOTTOM_MM = 9.5, 1.5, 4.0, 8.0
"""About the frames: −1000 at 6 points, half of the last number, the title, then numbers and name of the axis."""

Draw = Callable[[Figure, Area], None]
_Named = tuple[str, float, Draw]
"""Name, height over width of the frames, and what draws a figure."""


def parse_width(text: str) -> float:
    """Return a length in mm; raises UsageError where the text is none that a column can have."""
    found = _LENGTH.fullmatch(text.strip())
    width_mm = float(found[1]) * _UNITS_MM[found[2]] if found else 0.0
    if not _NARROWEST_MM <= width_mm <= _WIDEST_MM:
        allowed = f"{_NARROWEST_MM:g}mm to {_WIDEST_MM:g}mm, also in cm or in"
        raise UsageError(f"--width = {text!r}, allowed: {allowed}")
    return width_mm


def write_figures(
    session: Session, result_of: ResultOf, folder: Path, width_mm: float, progress: Progress = silent
) -> list[str]:
    """Write every figure of a session and of its runs, each as PDF, SVG and PNG, and return their names.

    Parameters
    ----------
    session
        A run of it that cannot be read has no figures.
    result_of
        Gives the result of each run, see `study`.
    folder
        Files of these names in it are replaced.
    width_mm
        Of each figure.
    progress
        Called with the share done, 0 to 1; what it raises ends the work.

    Raises
    ------
    FileError
        The folder cannot be written.
    """
    paths, kept, names = session.run_paths(), list[RunFacts](), list[str]()
    with sheet.page_style():
        for number, path in enumerate(paths, 1):
            run = study(path, session.setup, result_of)
            kept.append(replace(run, curves=None))
            names += [_write(folder, one, width_mm) for one in _of_run(run.name, run.curves)] if run.curves else []
            progress(number / (len(paths) + 1))
        names += [_write(folder, one, width_mm) for one in _of_session(SessionFacts(session.info, tuple(kept)))]
    progress(1.0)
    return names


def _of_run(name: str, curves: RunCurves) -> Iterator[_Named]:
    for one in curves.receivers:
        own = f"{name}-receiver-{one.name}"
        yield f"{own}-iq", 0.6, _of(curves, RunDrawing.iq_rows, receivers=(one,))
        if one.steps or one.circles:
            yield f"{own}-correction", 0.7, _of(curves, RunDrawing.correction, receivers=(one,))
    if curves.has_phase:
        yield f"{name}-phase", 0.7, _of(curves, RunDrawing.phase)
    if curves.track is not None:
        yield f"{name}-fall", 0.8, _of(curves, RunDrawing.fall, track=curves.track)


def _of_session(session: SessionFacts) -> Iterator[_Named]:
    facts = report_facts([session], "")
    yield "restitution", 0.7, partial(draw_speeds, facts=facts)
    if any(one.distribution for one in facts.findings.sessions):
        yield "distribution", 0.5, partial(draw_spread, facts=facts)
    if any(run.falls for run in session.runs):
        yield "falls", 0.9, partial(draw_falls, sessions=[session.runs])


def _of(curves: RunCurves, part: Callable[..., None], **what: object) -> Draw:
    return lambda figure, area: part(RunDrawing(figure, curves), area, **what)


def _drawn(shape: float, draw: Draw, width_mm: float) -> Figure:
    """Draw a figure, once more where its numbers want more room: of an e that hardly changes they have many digits."""
    left, right = _LEFT_MM, _RIGHT_MM
    for _ in range(2):
        inner = width_mm - left - right
        height = shape * inner
        figure = sheet.new_figure(width_mm, _TOP_MM + height + _BOTTOM_MM)
        draw(figure, Area(left, _TOP_MM, inner, height))
        words = [word for one in figure.get_children() if isinstance(one, Canvas) for word in one.words]
        outside = max(0.0, *(-word[0] for word in words)), max(0.0, *(word[1] - width_mm for word in words))
        if not any(outside):
            break
        left, right = left + outside[0], right + outside[1]
    return figure


def _write(folder: Path, named: _Named, width_mm: float) -> str:
    name, shape, draw = named
    figure = _drawn(shape, draw, width_mm)
    paths = [folder / f"{name}.{kind}" for kind in FORMATS]
    with fresh_files(paths, force=True) as files:
        folder.mkdir(parents=True, exist_ok=True)
        for path, kind in zip(files, FORMATS, strict=True):
            figure.savefig(path, format=kind, dpi=_DPI)
    return name
