"""`radargui sessions`: find the sessions below a data folder by what is known of them."""

from datetime import date, datetime
from pathlib import Path

import typer

from radargui.cli.app import Recover, Sessions
from radargui.cli.bar import progress_bar, show_table
from radargui.cli.console import FAILED, fail, one_line
from radargui.experiment.reprocess import RecoveredRun, held_runs, recover_run, unfinished_runs
from radargui.files.run_card import summarise
from radargui.model.drop import restitution_words
from radargui.model.errors import RadarGuiError, UsageError
from radargui.model.rounding import UNKNOWN
from radargui.model.setup import read_setup
from radargui.restitution.series import series_of
from radargui.session.catalogue import Catalogue, Query, RunLine, SessionSummary
from radargui.session.info import default_data_folder
from radargui.session.lock import FILE_NAME as LOCK_NAME, Owner

NOTES_WIDTH = 40
"""Characters of a session's notes in its table. Chosen by hand: a session stays one line."""


def list_sessions(options: Sessions) -> int:
    """Print the sessions that were asked for as a table, the newest first, and return the exit status.

    Raises
    ------
    UsageError
        No such folder, or a day or a range that cannot be read.
    SetupError
        The setup file cannot be used.
    """
    query, folder = _query(options), options.folder or default_data_folder()
    if options.folder is not None and not folder.is_dir():
        raise UsageError(f"{folder} is no folder")
    with Catalogue(folder) as catalogue:
        with progress_bar("Reading new sessions") as report_progress:
            catalogue.refresh(report_progress)
        found = catalogue.find(query)
        if not found:
            typer.echo(f"No {'' if query == Query() else 'such '}session in {folder}.")
            return 0
        if options.runs:
            lines = [(one, run) for one in found for run in catalogue.runs(one.path)]
            show_table(("run", "started", "length", "e", "status"), [_run_row(folder, *line) for line in lines])
        else:
            header = ("session", "begun", "operator", "sample", "runs", "e", "of drops", "notes")
            show_table(header, [_row(folder, one) for one in found])
        if any(one.n_unfinished for one in found):
            typer.echo("Unfinished runs that nothing records any more: radargui recover finishes and processes them.")
    return 0


def _query(options: Sessions) -> Query:
    first, last, (e_min, e_max) = _day("--since", options.since), _day("--until", options.until), _range(options.e)
    antennas = read_setup(Path(options.setup)) if options.setup.lower().endswith(".toml") else None
    name = "" if antennas else options.setup
    return Query(first, last, options.operator, options.sample, name, antennas, e_min, e_max, options.text)


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
    wrong = UsageError(f"--e = {text!r}, allowed: LOW:HIGH, LOW: or :HIGH, like 0.7:0.9")
    try:
        least, most = float(low or "-inf"), float(high or "inf")
    except ValueError:
        raise wrong from None
    # the other way round, or no number (nan): nothing would ever be found
    if not least <= most:
        raise wrong
    return (least if low else None), (most if high else None)


def _row(folder: Path, one: SessionSummary) -> tuple[str, ...]:
    runs = f"{one.n_runs}" + (f", {one.n_unfinished} unfinished" if one.n_unfinished else "")
    runs += f", {one.n_unreadable} unreadable" if one.n_unreadable else ""
    series = series_of(one.drops)
    return (
        one.path.relative_to(folder).as_posix() if one.path != folder else one.name,
        one.created_at.replace("T", " ")[:16] or UNKNOWN,
        one_line(one.operator) or UNKNOWN,
        _short(one.sample) or UNKNOWN,
        runs,
        series.e.words(),
        f"{series.e.n} {series.mark}".rstrip(),
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


def recover_runs(options: Recover) -> int:
    """Finish and process the unfinished runs below a folder, print a table, and return the exit status.

    Raises
    ------
    UsageError
        No such file or folder.
    """
    where = options.path or default_data_folder()
    if options.path is not None and not where.exists():
        raise UsageError(f"{where}: no such file or folder")
    folder = where if where.is_dir() else where.parent
    found, held = unfinished_runs(folder), held_runs(folder)
    if where.is_file():
        found = tuple(one for one in found if one.path.name == where.name)
        held = {run: owner for run, owner in held.items() if run.name == where.name}
    for run, owner in held.items():
        typer.echo(f"{run} is left out: {owner} writes to its session. {_remedy(run, owner)}", err=True)
    if not found:
        typer.echo(f"No {'other ' if held else ''}unfinished run in {where}.")
        return 0
    if options.only_list:
        show_table(("run", "started", "length"), [_listed(one) for one in found])
        return 0
    status, rows = 0, []
    for one in found:
        try:
            with progress_bar(f"Recovery of {one.path.name}") as report_progress:
                recovered = recover_run(one.path, now=datetime.now().astimezone(), progress=report_progress)
            if recovered.error is not None:
                status = fail(recovered.error, str(one.path)) and FAILED
        except RadarGuiError as error:
            status = fail(error, str(one.path))
            continue
        rows.append((*_listed(one), *_outcome(recovered)))
    if rows:
        show_table(("run", "started", "length", "e ± u_e", "status"), rows)
    return status


def _remedy(run: Path, owner: Owner) -> str:
    if owner.is_here:
        return "Finish it there."
    return f"If that program is gone, delete {run.parent / LOCK_NAME} and recover again."


def _listed(one: RunLine) -> tuple[str, str, str]:
    return str(one.path), one.started_at or UNKNOWN, f"{one.duration_s:.2f} s"


def _outcome(recovered: RecoveredRun) -> tuple[str, str]:
    if recovered.result is None:
        return UNKNOWN, "recovered, not processed" if recovered.n_samples else "set aside: nothing was recorded"
    summary = summarise(recovered.result)
    return restitution_words(summary), f"recovered, {recovered.result.status.replace('_', ' ')}"
