"""`radargui compare`: results of runs side by side, stored ones or such with other settings."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from statistics import fmean

import typer

from radargui.cli.console import progress_bar, show_table
from radargui.cli.guard import FAILED, fail
from radargui.cli.setup_choice import override
from radargui.experiment.batch.find import find_runs
from radargui.experiment.compare import ComparedFigure, Comparison, compare_stored, compare_with
from radargui.model.errors import RadarGuiError, UsageError
from radargui.model.resources import default_setup_path
from radargui.model.setup import Setup
from radargui.model.setup_file import read_setup
from radargui.report.rounding import UNKNOWN, quantity


@dataclass(frozen=True, slots=True)
class CompareOptions:
    """What the command line asked for; None where nothing was said."""

    paths: tuple[Path, ...]
    setup: Path | None = None
    correction: str | None = None
    geometry: str | None = None
    keep: bool = False


def compare_runs(options: CompareOptions) -> int:
    """Print the old and the new result of each run, what was set differently, and return the exit status.

    Raises
    ------
    UsageError
        Options that do not go together.
    SetupError
        The setup or an option instead of it is not allowed.
    """
    changes = {"processing.correction": options.correction, "processing.geometry": options.geometry}
    wanted = {key: value for key, value in changes.items() if value is not None}
    if options.keep and not (wanted or options.setup):
        raise UsageError("--keep, allowed: together with --setup, --correction or --geometry")
    override(read_setup(default_setup_path()), changes)
    setup = read_setup(options.setup) if options.setup else None
    found = find_runs(options.paths)
    status = 0
    for error in found.errors:
        status = fail(error)
    compared: list[Comparison] = []
    for one in found.runs:
        try:
            comparison = _compared(one.path, setup, wanted, keep=options.keep)
        except RadarGuiError as error:
            fail(error, str(one.path))
            status = FAILED
            continue
        if comparison is None:
            typer.echo(f"{one.path}: no result before the present one")
        else:
            compared.append(comparison)
    _show(compared)
    return status


def _compared(run: Path, setup: Setup | None, changes: dict[str, str], *, keep: bool) -> Comparison | None:
    if setup is None and not changes:
        return compare_stored(run)
    with progress_bar(f"Processing {run.name}") as tell:
        return compare_with(run, setup, changes, keep=keep, progress=tell)


def _show(compared: list[Comparison]) -> None:
    if not compared:
        return
    header = ("run", "e before", "e after", "difference", "g before", "g after", "status before", "status after")
    show_table(header, [_row(one) for one in compared])
    pairs = [(e.before, e.after) for one in compared if (e := _figure(one, "e")).difference is not None]
    if len(pairs) > 1:
        before, after = (fmean(float(pair[side] or 0.0) for pair in pairs) for side in (0, 1))
        typer.echo(f"mean e of {len(pairs)} runs: {before:.4f} before, {after:.4f} after, {after - before:+.4f}")
    shown = None
    for one in compared:
        settings = [f"{each.key}: {_value(each.before)} -> {_value(each.after)}" for each in one.settings]
        if settings != shown:
            typer.echo(f"set differently ({one.run.name}): " + ("; ".join(settings) or "nothing"))
        shown = settings


def _row(one: Comparison) -> tuple[str, ...]:
    e, g = _figure(one, "e"), _figure(one, "g_m_s2")
    return (
        f"{one.run.parent.name}/{one.run.stem}",
        quantity(e.before, e.u_before),
        quantity(e.after, e.u_after),
        UNKNOWN if e.difference is None else f"{e.difference:+.4f}",
        quantity(g.before, g.u_before),
        quantity(g.after, g.u_after),
        *(str(side.summary.get("status", UNKNOWN)).replace("_", " ") for side in (one.before, one.after)),
    )


def _figure(one: Comparison, name: str) -> ComparedFigure:
    return next(figure for figure in one.figures if figure.name == name)


def _value(value: object) -> str:
    return "left out" if value is None else str(value)
