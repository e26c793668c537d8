"""`radargui report` and `radargui export`: what is written from sessions for others to open."""

from pathlib import Path

import typer

from radargui.cli.console import FAILED, fail, progress_bar
from radargui.files.export import EXPORT_FORMATS
from radargui.model.errors import RadarGuiError
from radargui.session.export import plan_export
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
    # an export does not need what draws figures
    from radargui.processing.result_of_run import result_of_run
    from radargui.report.report import write_report

    status = 0
    for folder in folders:
        try:
            session = Session.open(folder, write=False)
            below = output / session.path.resolve().name if output and len(folders) > 1 else output
            with progress_bar(f"Report of {session.path.name}") as report_progress:
                report = write_report(session, result_of_run, below, report_progress)
        except RadarGuiError as error:
            fail(error, str(folder))
            status = FAILED
            continue
        typer.echo(f"Report:  {report.pdf}")
        for path in (report.html, report.csv, report.json):
            typer.echo(f"         {path}")
    return status


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
    with progress_bar(f"{kind.title} of {path.name or path}") as report_progress:
        for run in plan.carry_out(report_progress):
            if run.error is not None:
                status = fail(run.error, run.run.name) and FAILED
            for made in run.paths:
                typer.echo(str(made))
    return status
