"""`radargui sessions`: the sessions below a data folder, found by what is known of them."""

from datetime import date
from pathlib import Path

import typer

from radargui.cli.console import one_line, progress_bar, show_table
from radargui.model.drop import restitution_words
from radargui.model.errors import UsageError
from radargui.model.rounding import UNKNOWN
from radargui.model.setup_file import read_setup
from radargui.restitution.series import series_of
from radargui.session.catalogue import Catalogue, Query, RunLine, SessionSummary
from radargui.session.folder import default_data_folder

NOTES_WIDTH = 40


def list_sessions(folder: Path | None, query: Query, *, runs: bool) -> int:
    """Print the sessions that were asked for as a table, the newest first.

    Parameters
    ----------
    folder
        Where they are; None: the data folder of the user.
    query
        Which ones.
    runs
        Show each run.

    Raises
    ------
    UsageError
        No such folder.
    """
    if folder is not None and not folder.is_dir():
        raise UsageError(f"{folder} is no folder")
    folder = folder or default_data_folder()
    with Catalogue(folder) as catalogue:
        with progress_bar("Reading new sessions") as report_progress:
            catalogue.refresh(report_progress)
        found = catalogue.find(query, refresh=False)
        if not found:
            typer.echo(f"No such session in {folder}.")
            return 0
        if runs:
            lines = [(one, run) for one in found for run in catalogue.runs(one.path)]
            show_table(("run", "started", "length", "e", "status"), [_run_row(folder, *line) for line in lines])
        else:
            header = ("session", "begun", "operator", "sample", "runs", "e", "of drops", "notes")
            show_table(header, [_row(folder, one) for one in found])
        if any(one.n_unfinished for one in found):
            typer.echo("Unfinished runs that nothing records any more: radargui recover finishes and processes them.")
    return 0


def asked(since: str | None, until: str | None, setup: str, e: str | None, **words: str) -> Query:
    """Return what options ask for; `words` as of `Query`: operator, sample, text.

    Raises
    ------
    UsageError
        A day or a range that cannot be read.
    SetupError
        The setup file cannot be used.
    """
    first, last, (e_min, e_max) = _day("--since", since), _day("--until", until), _range(e)
    name, antennas = ("", read_setup(Path(setup))) if setup.lower().endswith(".toml") else (setup, None)
    return Query(first, last, setup_name=name, antennas=antennas, e_min=e_min, e_max=e_max, **words)


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
    runs = f"{one.n_runs}" + (f", {one.n_unfinished} unfinished" if one.n_unfinished else "")
    series = series_of(one.drops)
    return (
        one.path.relative_to(folder).as_posix() if one.path != folder else one.name,
        one.created_at.replace("T", " ")[:16] or UNKNOWN,
        one_line(one.operator) or UNKNOWN,
        _short(one.sample) or UNKNOWN,
        runs,
        series.e.words(),
        f"{series.e.n}{'' if series.kind in (None, 'measured') else f' {series.kind}'}",
        _short(one.problem or one.notes),
    )


def _run_row(folder: Path, session: SessionSummary, run: RunLine) -> tuple[str, ...]:
    status = str(run.summary.get("status") or "not processed").replace("_", " ")
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
        restitution_words(run.summary),
        _short(run.problem) or status,
    )


def _short(text: str) -> str:
    text = one_line(text)
    return text if len(text) <= NOTES_WIDTH else text[: NOTES_WIDTH - 1] + "…"
