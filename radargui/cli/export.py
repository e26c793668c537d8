"""`radargui export`: a session or a run in formats that others open."""

from __future__ import annotations

from pathlib import Path

import typer

from radargui.cli.console import progress_bar
from radargui.cli.guard import FAILED, fail
from radargui.files.export import EXPORT_FORMATS
from radargui.session.export import plan_export


def export_runs(path: Path, format_name: str, output: Path | None, *, force: bool) -> int:
    """Export the runs, print the files made, and return the exit status; one that fails does not stop the others.

    Raises
    ------
    SessionError
        There are no runs.
    FileError
        A file is there already, and not `force`.
    """
    kind = EXPORT_FORMATS[format_name]
    plan = plan_export(path, kind, output, force=force)
    status = 0
    with progress_bar(f"{kind.title} of {path.name or path}") as tell:
        for run in plan.carry_out(tell):
            if run.error is not None:
                status = fail(run.error, run.run.name) and FAILED
            for made in run.paths:
                typer.echo(str(made))
    return status
