"""`radargui sessions`: the sessions below a data folder, found by what is known of them."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import date
from pathlib import Path

import typer

from radargui.cli.console import one_line, progress_bar, show_table
from radargui.model.errors import UsageError
from radargui.model.setup_file import read_setup
from radargui.report.rounding import UNKNOWN
from radargui.session.catalogue import Catalogue, Query, RunLine, SessionSummary
from radargui.session.data_folder import default_data_folder

NOTES_WIDTH = 40


@dataclass(frozen=True, slots=True)
class SessionsOptions:
    """What the command line asked for; None and empty where nothing was said."""

    folder: Path | None = None
    since: str | None = None
    until: str | None = None
    operator: str = ""
    sample: str = ""
    setup: str = ""
    e: str | None = None
    text: str = ""
    runs: bool = False


def list_sessions(options: SessionsOptions) -> int:
    """Print the sessions that were asked for as a table, the newest first.

    Raises
    ------
    UsageError
        A day or a range that cannot be read, or no such folder.
    SetupError
        The setup file cannot be used.
    """
    query = _query(options)
    folder = options.folder or default_data_folder()
    if options.folder is not None and not folder.is_dir():
        raise UsageError(f"{folder} is no folder")
    with Catalogue(folder) as catalogue:
        with progress_bar("Reading new sessions") as tell:
            catalogue.refresh(tell)
        found = catalogue.find(query, refresh=False)
        if not found:
            typer.echo(f"No such session in {folder}.")
            return 0
        if options.runs:
            lines = [(one, run) for one in found for run in catalogue.runs(one.path)]
            show_table(("run", "started", "length", "e", "status"), [_run_row(folder, *line) for line in lines])
        else:
            header = ("session", "begun", "operator", "sample", "runs", "e", "range", "notes")
            show_table(header, [_row(folder, one) for one in found])
        if any(one.n_unfinished for one in found):
            typer.echo("Unfinished runs that nothing records any more: radargui recover finishes and processes them.")
    return 0


def _query(options: SessionsOptions) -> Query:
    e_min, e_max = _range(options.e)
    file = Path(options.setup)
    is_file = options.setup.lower().endswith(".toml")
    return Query(
        since=_day("--since", options.since),
        until=_day("--until", options.until),
        operator=options.operator,
        sample=options.sample,
        setup_name="" if is_file else options.setup,
        antennas=read_setup(file) if is_file else None,
        e_min=e_min,
        e_max=e_max,
        text=options.text,
    )


def _day(name: str, text: str | None) -> date | None:
    if text is None:
        return None
    try:
        return date.fromisoformat(text)
    except ValueError:
        raise UsageError(f"{name} = {text!r}, allowed: a day like 2026-11-20") from None


def _range(text: str | None) -> tuple[float | None, float | None]:
    if text is None:
        return None, None
    low, _, high = text.partition(":")
    try:
        return (float(low) if low else None), (float(high) if high else None)
    except ValueError:
        raise UsageError(f"--e = {text!r}, allowed: LOW:HIGH, LOW: or :HIGH, like 0.7:0.9") from None


def _row(folder: Path, one: SessionSummary) -> tuple[str, ...]:
    told = f"{one.n_runs}" + (f", {one.n_unfinished} unfinished" if one.n_unfinished else "")
    has_range = one.e_min is not None and one.e_max is not None
    return (
        one.path.relative_to(folder).as_posix() if one.path != folder else one.name,
        one.created_at.replace("T", " ")[:16] or UNKNOWN,
        one_line(one.operator) or UNKNOWN,
        _short(one.sample) or UNKNOWN,
        told,
        UNKNOWN if one.e_mean is None else f"{one.e_mean:.3f}",
        f"{one.e_min:.3f} to {one.e_max:.3f}" if has_range else UNKNOWN,
        _short(one.problem or one.notes),
    )


def _run_row(folder: Path, session: SessionSummary, run: RunLine) -> tuple[str, ...]:
    e, status = run.summary.get("e"), str(run.summary.get("status") or "not processed").replace("_", " ")
    if not run.finished:
        status = "unfinished"
    elif run.recovered_at:
        status = f"recovered, {status}"
    if run.rejected:
        status = f"set aside: {_short(run.rejected)}"
    return (
        run.path.relative_to(folder).as_posix() if session.path != folder else run.path.name,
        run.started_at.replace("T", " ")[:19] or UNKNOWN,
        f"{run.duration_s:.2f} s",
        f"{e:.4f}" if isinstance(e, float) else UNKNOWN,
        _short(run.problem) or status,
    )


def _short(text: str) -> str:
    text = one_line(text)
    return text if len(text) <= NOTES_WIDTH else text[: NOTES_WIDTH - 1] + "…"
