"""The report's first section: who, when, all runs in one table, statistics of the series, setup."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from radargui import __version__
from radargui.report.document import Block, Facts, Grid, Note, Picture, Section
from radargui.report.figure_series import points_of, series_page
from radargui.report.rounding import UNKNOWN, plain, quantity
from radargui.report.run_facts import RunFacts
from radargui.report.setup_blocks import setup_blocks
from radargui.report.statistics import Statistics, statistics_of
from radargui.session.info import SessionInfo


def series_statistics(runs: Sequence[RunFacts]) -> dict[str, Statistics]:
    """Return the statistics of the first bounce's e, of g and of the drop height over runs whose release was seen."""
    falls = [run.fall for run in runs if run.fall is not None]
    return {
        "e_first_bounce": statistics_of(run.first_e for run in runs),
        "g_m_s2": statistics_of(fall.g_m_s2 for fall in falls),
        "drop_height_m": statistics_of(fall.drop_height_m for fall in falls),
    }


def session_section(info: SessionInfo, runs: Sequence[RunFacts], made_at: str) -> Section:
    """Return the section about the session as a whole."""
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
        ("Recorded with", versions or UNKNOWN),
        ("Report", f"made {made_at} with radargui {__version__}, as all its results"),
    )
    notes = tuple((entry.at.replace("T", " ")[:19], entry.text) for entry in info.journal)
    blocks: list[Block] = [Facts(rows)]
    if notes:
        blocks.append(Facts(notes, title="Noted meanwhile"))
    if not runs:
        blocks.append(Note("This session holds no run.", warning=True))
    else:
        blocks += [*_preliminary(runs), _summary(runs), _statistics(series_statistics(runs))]
    blocks += setup_blocks(info.setup)
    return Section(f"Session {info.name}", tuple(blocks), _pictures(runs))


def _preliminary(runs: Sequence[RunFacts]) -> list[Block]:
    names = ", ".join(run.name for run in runs if run.preliminary)
    said = f"Preliminary, because the correction was stopped before it ended: {names}. radargui batch makes up for it."
    return [Note(said, warning=True)] if names else []


def _summary(runs: Sequence[RunFacts]) -> Grid:
    header = ("run", "drop height / mm", "impact speed / (m/s)", "e", "g / (m/s²)", "impacts", "verdict")
    rows = tuple(
        (
            run.name,
            plain(run.figure("drop_height_m"), 4, scale=1e3),
            plain(run.figure("impact_speed_m_s"), 4),
            quantity(run.figure("e"), run.figure("u_e")),
            quantity(run.figure("g_m_s2"), run.figure("u_g_m_s2")),
            str(len(run.bounces.impacts)) if run.figures else UNKNOWN,
            run.verdict,
        )
        for run in runs
    )
    return Grid(header, rows, "Runs (± is the standard uncertainty of each run)", left=(0, 6))


def _statistics(series: dict[str, Statistics]) -> Grid:
    header = ("quantity", "n", "mean ± standard error", "standard deviation")
    names = (
        ("e_first_bounce", "e of the first bounce", 1.0),
        ("g_m_s2", "g / (m/s²)", 1.0),
        ("drop_height_m", "drop height / mm", 1e3),
    )
    rows = tuple(
        (
            text,
            str(series[key].n),
            quantity(series[key].mean, series[key].standard_error, scale=scale),
            plain(series[key].standard_deviation, 2, scale=scale),
        )
        for key, text, scale in names
    )
    return Grid(header, rows, "Statistics of the series (runs whose rest before the fall was recorded)")


def _pictures(runs: Sequence[RunFacts]) -> tuple[Picture, ...]:
    points = points_of(runs)
    return (Picture("restitution against impact speed", partial(series_page, points)),) if points else ()
