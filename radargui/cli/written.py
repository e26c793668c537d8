"""`radargui report` and `radargui export`: write reports and exports of sessions."""

from __future__ import annotations

from typing import TYPE_CHECKING

import typer

from radargui.cli.app import Export, Figures, Report
from radargui.cli.bar import Bar, progress_bar
from radargui.cli.console import FAILED, fail, fail_line
from radargui.files.formats import EXPORT_FORMATS
from radargui.model.errors import RadarGuiError, UsageError
from radargui.session.info import own_subfolder
from radargui.session.session import Session
from radargui.session.transfer import plan_export

if TYPE_CHECKING:
    from radargui.report.report import WrittenReport


def report_sessions(options: Report) -> int:
    """Write the report of each session and return the exit status; what fails, session or run, stops no other.

    With several sessions and a folder for their reports each gets a folder of its name below, and the folder itself
    the report of all together.

    Raises
    ------
    UsageError
        There is no such law.
    """
    # an export does not need what draws figures
    from radargui.processing.result_of_run import stored_or_computed
    from radargui.report.report import PageLayout, write_report, write_series_report
    from radargui.restitution.speed_models import model_names

    if options.model is not None and options.model not in model_names():
        raise UsageError(f"--law = {options.model!r}, allowed: {', '.join(model_names())}")

    status = 0
    reports: list[WrittenReport] = []
    layout = PageLayout(options.paper, options.details, options.model)
    for folder in options.sessions:
        try:
            session = Session.open(folder, write=False)
            below = options.output
            if below and len(options.sessions) > 1:
                below /= session.path.resolve().name
                # of two with one name none shall be lost
                while any(report.pdf.parent == below for report in reports):
                    below = below.with_name(f"{below.name}-2")
            with progress_bar(f"Report of {session.path.name}") as progress:
                report = write_report(session, stored_or_computed, below, progress, layout=layout, ahead=True)
        except RadarGuiError as error:
            fail(error, str(folder))
            status = FAILED
            continue
        reports.append(report)
        _show("Report:", report)
        for run in (one for facts in report.facts for one in facts.runs if one.failure):
            status = fail_line(f"{folder}: {'' if run.name in run.failure else f'{run.name}: '}{run.failure}")
    if options.output is None or len(options.sessions) < 2:
        return status
    if len(reports) < len(options.sessions):
        # a series without one of its sessions would be another series
        typer.echo("There is no report of the series: not every session could be reported.")
        return status
    sessions = [facts for report in reports for facts in report.facts]
    _show("Series:", write_series_report(sessions, options.output, layout=layout))
    return status


def draw_figures(options: Figures) -> int:
    """Write every figure of a session alone and return the exit status."""
    from radargui.processing.result_of_run import stored_or_computed
    from radargui.report.series_figures import FIGURES_FOLDER, parse_width, write_figures

    width_mm = parse_width(options.width)
    session = Session.open(options.session, write=False)
    folder = options.output or own_subfolder(session.path, FIGURES_FOLDER)
    with progress_bar(f"Figures of {session.path.name}") as progress:
        names = write_figures(session, stored_or_computed, folder, width_mm, progress)
    typer.echo(f"{len(names)} figure{'' if len(names) == 1 else 's'} as PDF, SVG and PNG: {folder}")
    return 0


def _show(title: str, report: WrittenReport) -> None:
    for number, path in enumerate((report.pdf, report.html, report.csv, report.json)):
        typer.echo(f"{'' if number else title:<9}{path}")


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
