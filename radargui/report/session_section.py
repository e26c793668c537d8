"""The report's first section: who, when, all runs in one table, statistics and figure of the series, setup."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

from matplotlib.figure import Figure

from radargui import __version__
from radargui.model.drop import gravity_words, restitution_words
from radargui.model.rounding import UNKNOWN, plain
from radargui.report.document import Chapter, Content, Facts, Grid, Note, Picture
from radargui.report.run_facts import RunFacts, all_simulated
from radargui.report.setup_blocks import setup_blocks
from radargui.report.sheet import RECEIVER_COLOURS, add_axes, legend, new_page
from radargui.restitution.series import Series, Statistics, series_of
from radargui.session.info import SessionInfo


def session_section(info: SessionInfo, runs: Sequence[RunFacts], made_at: str) -> Chapter:
    """Return the section about the session as a whole."""
    imported = bool(runs) and all(run.origin for run in runs)
    simulated = all_simulated(runs)
    versions = ", ".join(f"{name} {text}" for name, text in info.versions.items())
    rows = (
        ("Session", info.name),
        ("Begun", info.created_at),
        ("Operator", info.operator or UNKNOWN),
        ("Sample", info.sample or UNKNOWN),
        ("Target", info.target or UNKNOWN),
        ("Notes", info.notes or UNKNOWN),
        (
            "Calibration",
            ", ".join(part for part in (info.calibration.origin, info.calibration.made_at) if part) or UNKNOWN,
        ),
        ("Imported with" if imported else "Recorded with", versions or UNKNOWN),
        ("Report", f"made {made_at} with radargui {__version__}, as all its results"),
    )
    notes = tuple((entry.at.replace("T", " ")[:19], entry.text) for entry in info.journal)
    blocks: list[Content] = [Facts(rows)]
    if notes:
        blocks.append(Facts(notes, title="Noted meanwhile"))
    if not runs:
        blocks.append(Note("This session holds no run.", warning=True))
    else:
        blocks += [*_preliminary(runs), _summary(runs), *_statistics(runs)]
    blocks += setup_blocks(info.setup, recorded=not imported and not simulated, simulated=simulated)
    return Chapter(f"Session {info.name}{', simulated' if simulated else ''}", tuple(blocks), _pictures(runs))


def _preliminary(runs: Sequence[RunFacts]) -> list[Content]:
    names = ", ".join(run.name for run in runs if run.preliminary)
    said = f"Preliminary, because the correction was stopped before it ended: {names}. radargui batch makes up for it."
    return [Note(said, warning=True)] if names else []


def _summary(runs: Sequence[RunFacts]) -> Grid:
    rows = (
        {
            "drop": run.label,
            "run": run.name,
            "drop height / mm": plain(run.figure("drop_height_m"), 4, scale=1e3),
            "impact speed / (m/s)": plain(run.figure("impact_speed_m_s"), 4),
            "e": restitution_words(run.figures),
            "g / (m/s²)": gravity_words(run.figures),
            "impacts": str(len(run.bounces.impacts)) if run.figures else UNKNOWN,
            "verdict": run.said,
        }
        for run in runs
    )
    return Grid.of(rows, "Runs (± is the combined standard uncertainty of each run)", left=(0, 1, 7))


def _statistics(runs: Sequence[RunFacts]) -> list[Content]:
    series = series_of([run.drop for run in runs])
    found: tuple[tuple[str, Statistics, float], ...] = (
        ("e of the first bounce", series.e, 1.0),
        ("g / (m/s²)", series.g_m_s2, 1.0),
        ("drop height / mm", series.drop_height_m, 1e3),
    )
    header = ("quantity", "n", "mean ± combined u", "standard error", "standard deviation")
    rows = tuple(
        (
            text,
            str(one.n),
            one.words(scale),
            plain(one.standard_error, 2, scale=scale),
            plain(one.standard_deviation, 2, scale=scale),
        )
        for text, one, scale in found
    )
    of = {"measured": "", "simulated": "simulated ", "replay": "replayed "}[series.kind or "measured"]
    title = f"Statistics of the {of}series (runs whose rest before the fall was recorded; of one run its own ±)"
    return [Grid(header, rows, title), *_left_out(series)]


def _left_out(series: Series) -> list[Content]:
    said = "; ".join(f"{name}: {why}" for name, why in series.left_out.items())
    return [Note(f"Not in the statistics: {said}.")] if said else []


def _pictures(runs: Sequence[RunFacts]) -> tuple[Picture, ...]:
    points = points_of(runs)
    return (Picture("restitution against impact speed", partial(series_page, points)),) if points else ()


_MOST_NAMED = 8
_MARKERS = "osD^v<>P"
_WORST_SHARE = 0.1
"""An e known to no better than this would stretch the axis of all others."""


@dataclass(frozen=True, slots=True)
class RunPoints:
    """Valid impacts of one run: speeds before, e and its standard uncertainty."""

    name: str
    speed_m_s: tuple[float, ...]
    e: tuple[float, ...]
    u_e: tuple[float, ...]


def points_of(runs: Sequence[RunFacts]) -> tuple[RunPoints, ...]:
    """Return the points of the runs that have a valid impact; an e that is hardly known is left out."""
    found = []
    for run in runs:
        impacts = [
            impact
            for impact in run.bounces.impacts
            if impact.valid and math.isfinite(impact.e) and impact.u_e < _WORST_SHARE * impact.e
        ]
        if impacts:
            columns = zip(*((impact.speed_before_m_s, impact.e, impact.u_e) for impact in impacts), strict=True)
            found.append(RunPoints(run.name, *columns))
    return tuple(found)


def series_page(points: Sequence[RunPoints]) -> Figure:
    """Return the page: e with bars of two standard uncertainties against the speed before the impact."""
    figure = new_page()
    axes = add_axes(figure, 26.0, 32.0, 170.0, 100.0)
    axes.set_title("Coefficient of restitution of every valid impact, bars ± 2 u (statistical)")
    axes.set_xlabel("speed before the impact / (m/s)")
    axes.set_ylabel("e")
    for number, run in enumerate(points):
        axes.errorbar(
            run.speed_m_s,
            run.e,
            yerr=[2.0 * u for u in run.u_e],
            fmt=_MARKERS[number % len(_MARKERS)],
            color=RECEIVER_COLOURS[number % len(RECEIVER_COLOURS)],
            markersize=3.0,
            elinewidth=0.6,
            capsize=1.5,
            capthick=0.6,
            label=run.name if number < _MOST_NAMED else None,
        )
    axes.margins(0.05, 0.1)
    axes.set_xlim(left=0.0)
    if len(points) <= _MOST_NAMED:
        legend(axes)
    return figure
