"""Every figure of a session and of its runs alone, in the width of a column, as PDF, SVG and PNG."""

import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from matplotlib.figure import Figure

from radargui.files.access import Progress, fresh_files, silent
from radargui.model.errors import UsageError
from radargui.report.facts import SessionFacts, report_facts
from radargui.report.plots import MM_PER_INCH, page_style
from radargui.report.run_facts import ResultOf, RunFacts, study
from radargui.report.run_figures import single_figures
from radargui.report.series_figures import falls_figure, speeds_figure, spread_figure
from radargui.session.session import Session

FIGURES_FOLDER = "figures"
FORMATS = ("pdf", "svg", "png")
_DPI = 600
"""Of the PNG (chosen by hand): the thinnest lines, of 0.25 points, are two pixels wide; 86 mm are 2031."""
_LENGTH = re.compile(r"(\d+(?:\.\d+)?)\s*(mm|cm|in)")
_UNITS_MM = {"mm": 1.0, "cm": 10.0, "in": MM_PER_INCH}  # what people write widths in
_NARROWEST_MM, _WIDEST_MM = 60.0, 250.0
"""Of a figure: in a narrower one titles meet the names beside them; more than 210 is beyond A4."""


def parse_width(text: str) -> float:
    """Return a length in mm; raises UsageError where the text is none that a column can have."""
    found = _LENGTH.fullmatch(text.strip())
    width_mm = float(found[1]) * _UNITS_MM[found[2]] if found else 0.0
    if not _NARROWEST_MM <= width_mm <= _WIDEST_MM:
        allowed = f"{_NARROWEST_MM:g}mm to {_WIDEST_MM:g}mm, also in cm or in"
        raise UsageError(f"--width = {text!r}, allowed: {allowed}")
    return width_mm


def write_figures(
    session: Session,
    result_of: ResultOf,
    folder: Path,
    width_mm: float,
    progress: Progress = silent,
    *,
    dpi: int = _DPI,
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
    dpi
        Pixels per inch of the PNG.

    Raises
    ------
    FileError
        The folder cannot be written.
    """
    paths, kept, names = session.run_paths(), list[RunFacts](), list[str]()

    def write(figures: Iterator[tuple[str, Figure]]) -> None:
        for name, figure in figures:
            files = [folder / f"{name}.{kind}" for kind in FORMATS]
            with fresh_files(files, force=True) as parts:
                folder.mkdir(parents=True, exist_ok=True)
                for path, kind in zip(parts, FORMATS, strict=True):
                    figure.savefig(path, format=kind, dpi=dpi)
            names.append(name)

    with page_style():
        for number, path in enumerate(paths, 1):
            run = study(path, session.setup, result_of)
            kept.append(replace(run, curves=None))
            if run.curves:
                write(single_figures(run.name, run.curves, width_mm))
            progress(number / (len(paths) + 1))
        write(session_figures(SessionFacts(session.info, tuple(kept)), width_mm))
    progress(1.0)
    return names


def session_figures(session: SessionFacts, width_mm: float) -> Iterator[tuple[str, Figure]]:
    """Yield the figures of a session, as wide as a column, with their names."""
    facts = report_facts([session], "")
    yield "restitution", speeds_figure(facts, (width_mm, 0.8 * width_mm))
    if any(one.distribution for one in facts.findings.sessions):
        yield "distribution", spread_figure(facts, (width_mm, 0.6 * width_mm))
    if any(run.falls for run in session.runs):
        yield "falls", falls_figure([session.runs], (width_mm, width_mm))
