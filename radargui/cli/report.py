"""`radargui report`: PDF, HTML, CSV and JSON of sessions."""

from __future__ import annotations

from pathlib import Path

import typer

from radargui.cli.console import progress_bar
from radargui.cli.guard import FAILED, fail
from radargui.model.errors import RadarGuiError
from radargui.report.report import write_report
from radargui.session.session import Session


def report_sessions(folders: tuple[Path, ...], output: Path | None) -> int:
    """Write the report of each session and return the exit status; one that fails does not stop the others.

    Parameters
    ----------
    folders
        Sessions.
    output
        Folder of the report; with several sessions each gets a folder of its name below. None: in the session.
    """
    status = 0
    for folder in folders:
        try:
            session = Session.open(folder, write=False)
            below = output / session.path.resolve().name if output and len(folders) > 1 else output
            with progress_bar(f"Report of {session.path.name}") as tell:
                report = write_report(session, below, tell)
        except RadarGuiError as error:
            fail(error, str(folder))
            status = FAILED
            continue
        typer.echo(f"Report:  {report.pdf}")
        for path in (report.html, report.csv, report.json):
            typer.echo(f"         {path}")
    return status
