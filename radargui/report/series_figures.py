"""Draw the figures of a series: e against the impact speed and other variables, its distribution, all falls.

Every figure of a session and of its runs alone, in the width of a column, as PDF, SVG and PNG.
"""

import re
import textwrap
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from radargui.files.access import Progress, fresh_files, silent
from radargui.model.arrays import FloatArray
from radargui.model.errors import UsageError
from radargui.model.rounding import COVERAGE, plain
from radargui.report.curves import Curve
from radargui.report.facts import (
    MAX_LOOKS,
    WORST_SHARE,
    ReportFacts,
    SessionFacts,
    dependences_on,
    e_label,
    e_span,
    histogram_of,
    mean_gravity,
    points_of,
    report_facts,
    session_look,
    shown_fits,
    speed_points,
)
from radargui.report.plots import (
    DASHED,
    DOTTED,
    FIT_COLOUR,
    FRAME_COLOUR,
    MM_PER_INCH,
    RECEIVER_COLOURS,
    THIN,
    curve,
    frames,
    largest,
    page_style,
    say,
    scaled,
    span_of,
)
from radargui.report.run_facts import ResultOf, RunFacts, study
from radargui.report.run_figures import single_figures
from radargui.restitution.dependence import COVARIATES
from radargui.restitution.speed_models import SpeedFit, title_of
from radargui.session.session import Session

_MARKS = "os^Dv"
_GAP_MM = 10.0
"""Between the falls and what they leave: numbers, and a title (chosen by hand)."""
_LETTERS_A_MM = 0.62
"""Of a title, at 6.5 points (chosen by hand)."""
_NAME_LETTERS = 24
"""Of a session's name, in a figure."""


def speeds_figure(facts: ReportFacts, size_mm: tuple[float, float]) -> Figure:
    """Return e against the impact speed with bars, one colour a session, and the model of each sample."""
    groups = [speed_points(one.runs) for one in facts.sessions]
    every = np.concatenate(groups, axis=1)
    figure, ((axes,),) = frames(size_mm)
    if not every.size:
        say(axes, "no valid impact")
        axes.set(title="e", xticks=[], yticks=[])
        return figure
    low, high = e_span(every)
    n_outside = int(np.count_nonzero((every[1] < low) | (every[1] > high)))
    n_valid = sum(impact.valid for one in facts.sessions for run in one.runs for impact in run.bounces.impacts)
    names = [one.name for one in facts.findings.sessions]
    for fit in shown_fits(facts):
        _draw_fit(axes, fit)
    for number, group in enumerate(groups):
        _draw_points(axes, group, number, names[number] if 1 < len(groups) <= MAX_LOOKS else "")
    axes.set(xlim=(0.0, 1.08 * float(every[0].max())), ylim=(low, high), xlabel="speed before the impact / (m/s)")
    unnamed = f"; {len(groups)} sessions" if len(groups) > MAX_LOOKS else ""
    outside = f"; {n_outside} outside" if n_outside else ""
    n_vague = n_valid - every.shape[1]
    vague = f"; {n_vague} with u > {100.0 * WORST_SHARE:g} % of e left out" if n_vague else ""
    title = f"e of valid impacts, bars ± {COVERAGE:g} statistical u{unnamed}{outside}{vague}"
    axes.set_title(textwrap.fill(title, int(_LETTERS_A_MM * size_mm[0])))
    handles = {label: handle for handle, label in zip(*axes.get_legend_handles_labels(), strict=True)}
    if handles:
        # as many beside each other as the figure is wide
        columns = max(1, int(_LETTERS_A_MM * size_mm[0] / (max(map(len, handles)) + 6)))
        figure.legend(handles.values(), handles.keys(), loc="outside lower center", ncols=columns)
    return figure


def _draw_points(axes: Axes, points: FloatArray, number: int, name: str = "") -> None:
    x, e, u = points
    bars: dict[str, Any] = {
        "fmt": _MARKS[session_look(number)[1]],
        "color": _colour(number),
        "markersize": 2.5,
        "elinewidth": 0.6,
    }
    axes.errorbar(x, e, COVERAGE * u, **bars, label=name[:_NAME_LETTERS].lstrip("_"))


def _draw_fit(axes: Axes, fit: SpeedFit) -> None:
    speed = np.linspace(max(fit.speed_low_m_s, 1e-3), fit.speed_high_m_s, 80)
    e, u = fit.e(speed)
    axes.plot(
        speed, e, color=FIT_COLOUR, linewidth=0.9, linestyle=DASHED, label=f"{title_of(fit.model)} ± {COVERAGE:g} u"
    )
    further = fit.prediction(speed)
    for ends, dashes, name in ((COVERAGE * u, "-", ""), (further, DOTTED, "one more impact, 95 %")):
        axes.plot(speed, e - ends, color=FIT_COLOUR, linewidth=THIN, linestyle=dashes, label=name)
        axes.plot(speed, e + ends, color=FIT_COLOUR, linewidth=THIN, linestyle=dashes)


def spread_figure(facts: ReportFacts, size_mm: tuple[float, float]) -> Figure:
    """Return how e is distributed, p(e) one colour a session, and e against what it depends on besides the speed."""
    spreads = [(number, one.distribution) for number, one in enumerate(facts.findings.sessions)]
    shown = [(number, one) for number, one in spreads if one is not None]
    drawn = {on: known for on in COVARIATES if (known := dependences_on(facts, on))}
    figure, (row,) = frames(size_mm, 1, bool(shown) + len(drawn))
    places = iter(row)
    if shown:
        axes = next(places)
        for number, one in shown:
            axes.plot(one.at, one.density, color=_colour(number), linewidth=0.9)
        if len(shown) == 1:
            axes.plot(*histogram_of(shown[0][1]), color=_colour(shown[0][0]), linewidth=0.5)
        axes.set(title="p(e), first impacts", xlabel="e")
        axes.set_ylim(bottom=0.0)
    for on, found in drawn.items():
        covariate, axes = COVARIATES[on], next(places)
        every = []
        for number, dependence in enumerate(found):
            x, e, u = points_of(dependence)
            every.append(np.stack([x, e, u]))
            _draw_points(axes, np.stack([covariate.scale * x, e, u]), number)
            ends = np.array([x.min(), x.max()])
            axes.plot(covariate.scale * ends, dependence.line(ends), color=FIT_COLOUR, linewidth=0.9, linestyle=DASHED)
        axes.set_ylim(*e_span(np.concatenate(every, axis=1)))
        axes.margins(x=0.06)
        title = f"{e_label(found)}, bars ± {COVERAGE:g} u"
        axes.set_title(textwrap.fill(title, int(_LETTERS_A_MM * size_mm[0] / len(row))))
        axes.set_xlabel(covariate.label.replace("[", "/ ").replace("]", ""))
    return figure


def tracks_figure(sessions: Sequence[Sequence[RunFacts]], size_mm: tuple[float, float]) -> Figure:
    """Return the height of the sphere against time of every run that has a track, as coloured as its falls."""
    figure, ((axes,),) = frames(size_mm, fixed_mm=0.0)
    runs = [(run, run.height, colour) for run, colour in _coloured(sessions) if run.height is not None]
    for _, height, colour in runs:
        curve(axes, height, colour, 0.5, factor=1e3)
    axes.set_title(f"Height / mm, {len(runs)} run{'s' * (len(runs) > 1)}")
    since = {run.since for run, _, _ in runs}
    axes.set_xlabel(f"time after {since.pop()} / s" if len(since) == 1 else "time / s")
    return figure


def falls_figure(sessions: Sequence[Sequence[RunFacts]], size_mm: tuple[float, float]) -> Figure:
    """Return the way fallen of every run against the time from its vertex on over g t² / 2, and what the fits leave.

    Of several sessions each has one colour, which is that of `speeds_figure`.
    """
    falls = [(*run.falls, colour) for run, colour in _coloured(sessions) if run.falls is not None]
    figure, ((upper,), (lower,)) = frames(size_mm, 2, fixed_mm=_GAP_MM, heights=(1.6, 1.0))
    t = np.linspace(0.0, max(float(np.nanmax(fallen.x)) for fallen, _, _ in falls), 100)
    mean = mean_gravity([run for session in sessions for run in session])
    label = f"g t² / 2, g = {plain(mean, 5)} m/s²"
    upper.plot(t, 500.0 * mean * t**2, color=FRAME_COLOUR, linewidth=1.4, linestyle=DASHED, label=label)
    factor, unit = scaled("m", largest([left for _, left, _ in falls]))
    for fallen, left, colour in falls:
        curve(upper, fallen, colour, factor=1e3)
        curve(lower, left, colour, THIN, factor=factor)
    upper.legend(loc="upper left")
    upper.set(title=f"Way fallen / mm, {len(falls)} fall{'s' * (len(falls) > 1)}")
    upper.set_ylim(*span_of([Curve(fallen.x, fallen.y) for fallen, _, _ in falls], 1e3))
    lower.set(title=f"Residual of each fit / {unit}", xlabel="time from the vertex / s")
    for axes in (upper, lower):
        axes.set_xlim(0.0, 1.05 * t[-1])
    return figure


def _coloured(sessions: Sequence[Sequence[RunFacts]]) -> list[tuple[RunFacts, str]]:
    """Return runs with their colours: of several sessions each has one, of a single one its falls are told apart."""
    if len(sessions) > 1:
        return [(run, _colour(number)) for number, session in enumerate(sessions) for run in session]
    return [(run, _colour(number)) for number, run in enumerate(run for session in sessions for run in session)]


def _colour(number: int) -> str:
    return RECEIVER_COLOURS[session_look(number)[0]]


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
