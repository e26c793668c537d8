"""`radargui recover`: runs that a crash left unfinished are finished and processed."""

from datetime import datetime
from pathlib import Path

import typer

from radargui.cli.console import FAILED, fail, progress_bar, show_table
from radargui.experiment.reprocess import RecoveredRun, recover_run
from radargui.files.run_card import summarise
from radargui.model.drop import restitution_words
from radargui.model.errors import RadarGuiError, UsageError
from radargui.model.rounding import UNKNOWN
from radargui.session.catalogue import RunLine
from radargui.session.folder import default_data_folder
from radargui.session.recovery import unfinished_runs


def recover_runs(path: Path | None, *, only_list: bool = False) -> int:
    """Finish and process the unfinished runs below a folder, print a table, and return the exit status.

    Parameters
    ----------
    path
        Data folder, session or run file; None: the data folder of the user.
    only_list
        Show them, change nothing.

    Raises
    ------
    UsageError
        No such file or folder.
    """
    where = path or default_data_folder()
    if path is not None and not path.exists():
        raise UsageError(f"{path}: no such file or folder")
    found = unfinished_runs(where if where.is_dir() else where.parent)
    if where.is_file():
        found = tuple(one for one in found if one.path.name == where.name)
    if not found:
        typer.echo(f"No unfinished run in {where}.")
        return 0
    if only_list:
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
        rows.append((*_listed(one), *_told(recovered)))
    if rows:
        show_table(("run", "started", "length", "e ± u_e", "status"), rows)
    return status


def _listed(one: RunLine) -> tuple[str, str, str]:
    return str(one.path), one.started_at or UNKNOWN, f"{one.duration_s:.2f} s"


def _told(recovered: RecoveredRun) -> tuple[str, str]:
    if recovered.result is None:
        return UNKNOWN, "recovered, not processed" if recovered.n_samples else "set aside: nothing was recorded"
    summary = summarise(recovered.result)
    return restitution_words(summary), f"recovered, {recovered.result.status.replace('_', ' ')}"
