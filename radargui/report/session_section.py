"""The report's first section: who, when, all runs in one table, statistics of the series, setup."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from radargui import __version__
from radargui.model.rounding import UNKNOWN, plain, quantity
from radargui.report.document import Chapter, Content, Facts, Grid, Note, Picture
from radargui.report.figure_series import points_of, series_page
from radargui.report.run_facts import RunFacts, all_simulated
from radargui.report.setup_blocks import setup_blocks
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
    header = ("drop", "run", "drop height / mm", "impact speed / (m/s)", "e", "g / (m/s²)", "impacts", "verdict")
    rows = tuple(
        (
            run.label,
            run.name,
            plain(run.figure("drop_height_m"), 4, scale=1e3),
            plain(run.figure("impact_speed_m_s"), 4),
            quantity(run.figure("e"), run.figure("u_e")),
            quantity(run.figure("g_m_s2"), run.figure("u_g_m_s2")),
            str(len(run.bounces.impacts)) if run.figures else UNKNOWN,
            run.said,
        )
        for run in runs
    )
    return Grid(header, rows, "Runs (± is the standard uncertainty of each run)", left=(0, 1, 7))


def _statistics(runs: Sequence[RunFacts]) -> list[Content]:
    series = series_of([run.drop for run in runs])
    found: tuple[tuple[str, Statistics, float], ...] = (
        ("e of the first bounce", series.e, 1.0),
        ("g / (m/s²)", series.g_m_s2, 1.0),
        ("drop height / mm", series.drop_height_m, 1e3),
    )
    header = ("quantity", "n", "mean ± standard error", "standard deviation")
    rows = tuple(
        (text, str(one.n), one.words(scale), plain(one.standard_deviation, 2, scale=scale))
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
