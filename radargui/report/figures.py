"""Every figure of a session alone, as wide as a column of a journal."""

import re
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path

from matplotlib.figure import Figure

from radargui.files.access import Progress, fresh_files, silent
from radargui.model.errors import UsageError
from radargui.report import sheet
from radargui.report.canvas import Canvas
from radargui.report.curves import RunCurves
from radargui.report.facts import SessionFacts, report_facts
from radargui.report.run_facts import ResultOf, RunFacts, study
from radargui.report.run_figures import correction, fall, iq_rows, phase
from radargui.report.series_figures import draw_falls, draw_speeds
from radargui.report.sheet import Area
from radargui.session.session import Session

FIGURES_FOLDER = "figures"
FORMATS = ("pdf", "svg", "png")
_DPI = 600
_LENGTH = re.compile(r"(\d+(?:\.\d+)?)\s*(mm|cm|in)")
_UNITS_MM = {"mm": 1.0, "cm": 10.0, "in": sheet.MM_PER_INCH}
_NARROWEST_MM, _WIDEST_MM = 60.0, 250.0
_LEFT_MM, _RIGHT_MM, _TOP_MM, _BOTTOM_MM = 9.5, 1.5, 4.0, 8.0

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
        names += [_write(folder, one, width_mm) for one in _of_session(session, kept)]
    progress(1.0)
    return names


def _of_run(name: str, curves: RunCurves) -> Iterator[_Named]:
    for one in curves.receivers:
        own = f"{name}-receiver-{one.name}"
        yield f"{own}-iq", 0.6, _on_canvas(partial(iq_rows, curves=curves, receivers=(one,)))
        if one.steps or one.circles:
            yield f"{own}-correction", 0.7, _on_canvas(partial(correction, curves=curves, receivers=(one,)))
    if any(one.phase.largest for one in curves.receivers):
        yield f"{name}-phase", 0.7, _on_canvas(partial(phase, curves=curves))
    if curves.track is not None:
        yield f"{name}-fall", 0.8, _on_canvas(partial(fall, curves=curves, track=curves.track))


def _of_session(session: Session, runs: list[RunFacts]) -> Iterator[_Named]:
    facts = report_facts([SessionFacts(session.info, tuple(runs))], "")
    yield "restitution", 0.7, partial(draw_speeds, facts=facts)
    if any(run.falls for run in runs):
        yield "falls", 0.9, partial(draw_falls, runs=runs)


def _on_canvas(draw: Callable[[Canvas, Area], None]) -> Draw:
    return lambda figure, area: draw(Canvas(figure), area)


def _write(folder: Path, named: _Named, width_mm: float) -> str:
    name, shape, draw = named
    inner = width_mm - _LEFT_MM - _RIGHT_MM
    height = shape * inner
    figure = sheet.new_figure(width_mm, _TOP_MM + height + _BOTTOM_MM)
    draw(figure, Area(_LEFT_MM, _TOP_MM, inner, height))
    paths = [folder / f"{name}.{kind}" for kind in FORMATS]
    with fresh_files(paths, force=True) as files:
        folder.mkdir(parents=True, exist_ok=True)
        for path, kind in zip(files, FORMATS, strict=True):
            figure.savefig(path, format=kind, dpi=_DPI)
    return name
