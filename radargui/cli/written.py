"""`radargui report` and `radargui export`: what is written from sessions for others to open."""

import typer

from radargui.cli.app import Export, Report
from radargui.cli.bar import Bar, progress_bar
from radargui.cli.console import FAILED, fail
from radargui.files.formats import EXPORT_FORMATS
from radargui.model.errors import RadarGuiError
from radargui.session.session import Session
from radargui.session.transfer import plan_export


def report_sessions(options: Report) -> int:
    """Write the report of each session and return the exit status; one that fails does not stop the others.

    With several sessions and a folder for their reports each gets a folder of its name below.
    """
    # an export does not need what draws figures
    from radargui.processing.result_of_run import result_of_run
    from radargui.report.report import write_report

    status = 0
    for folder in options.sessions:
        try:
            session = Session.open(folder, write=False)
            output = options.output
            below = output / session.path.resolve().name if output and len(options.sessions) > 1 else output
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


def export_runs(options: Export) -> int:
    """Export the runs, print the files made, and return the exit status; one that fails does not stop the others.

    Raises
    ------
    SessionError
        There are no runs.
    FileError
        A file is there already, and not `force`.
    """
    kind, path = EXPORT_FORMATS[options.format_name], options.path
    plan = plan_export(path, kind, options.output, force=options.force)
    status = 0
    with Bar(description=f"{kind.title} of {path.name or path}", total=1.0) as bar:
        for run in plan.carry_out(lambda share: bar.update(bar.shown, completed=share)):
            if run.error is not None:
                status = fail(run.error, run.run.name) and FAILED
            for made in run.value or ():
                bar.say(str(made))
    return status
