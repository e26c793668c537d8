"""The commands for many stored runs: batch processes them again, compare shows old and new side by side."""

from collections import Counter
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import typer
from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeRemainingColumn

from radargui.cli.app import Batch, Compare
from radargui.cli.bar import Bar, progress_bar, show_table
from radargui.cli.console import FAILED, fail
from radargui.cli.setup_choice import processing_changes
from radargui.experiment.batch import BatchOutcome, BatchTask, FoundRuns, TablesTo, find_runs, run_local, run_on_cluster
from radargui.experiment.compare import ComparedFigure, RunComparison, compare_stored, compare_with
from radargui.files.access import Progress, each_run, want_room_for
from radargui.model.drop import restitution_words
from radargui.model.errors import RadarGuiError, UsageError
from radargui.model.rounding import UNKNOWN, alone, quantity
from radargui.model.setup import read_setup
from radargui.report.tables import tables_are_current, write_tables
from radargui.restitution.statistics import statistics_of


def run_batch(options: Batch) -> int:
    """Process all runs below the paths, print each as it ends, and return the exit status.

    Raises
    ------
    UsageError
        Options that do not go together, or two runs whose tables would go to the same folder.
    SetupError
        The setup or an option instead of it is not allowed.
    RadarGuiError
        The output cannot be written, or the cluster cannot be used.
    """
    if options.workers is not None and options.scheduler is not None:
        raise UsageError("--workers and --scheduler do not go together: the cluster has its own workers")
    wanted, found = processing_changes(options.correction, options.geometry), find_runs(options.paths)
    tasks = _tasks(options, wanted, found)
    if options.output is not None and options.scheduler is None:
        # runs may be computed for hours; of a cluster only its workers know what they can write
        want_room_for(options.output / "track.csv")
    for error in found.errors:
        fail(error)
    states: Counter[str] = Counter(failed=len(found.errors))
    try:
        if options.scheduler is None or not tasks:
            outcomes = run_local(tasks, options.workers)
        else:
            outcomes = run_on_cluster(tasks, options.scheduler)
        columns = TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn()
        with Bar(*columns, description="runs", total=len(found.runs)) as bar, closing(outcomes):
            for outcome in outcomes:
                states[outcome.state] += 1
                if outcome.error is not None:
                    fail(outcome.error, str(outcome.run))
                elif outcome.state == "done":
                    bar.say(f"{outcome.run}: {_figures(outcome)}")
                bar.advance(bar.shown)
    except KeyboardInterrupt:
        left = len(found.runs) - states["done"] - states["skipped"]
        fail(RadarGuiError(f"interrupted with {left} runs left.", remedy="The same command goes on from there."))
        return FAILED
    finally:
        if found.runs:
            typer.echo(
                f"{states['done']} processed, {states['skipped']} were up to date, {states['failed']} failed"
                f" of {len(found.runs)} runs"
            )
    return FAILED if states["failed"] or states["stopped"] else 0


def _tasks(options: Batch, wanted: dict[str, str | int], found: FoundRuns) -> list[BatchTask]:
    setup = read_setup(options.setup) if options.setup else None
    tasks = [BatchTask(one.path, setup, wanted, options.force) for one in found.runs]
    if options.output is None:
        return tasks
    folders = [options.output.absolute() / one.place for one in found.runs]
    # a system that takes upper and lower case for the same would write one over the other
    twice = [folder for folder, times in Counter(str(one).casefold() for one in folders).items() if times > 1]
    if twice:
        remedy = "Give the folder that holds them all as PATH."
        raise UsageError(f"The tables of several runs would go to {twice[0]}", remedy=remedy)
    to = [TablesTo(folder, write_tables, tables_are_current) for folder in folders]
    return [replace(task, tables=tables) for task, tables in zip(tasks, to, strict=True)]


def _figures(outcome: BatchOutcome) -> str:
    text = str(outcome.summary.get("status")).replace("_", " ")
    e = restitution_words(outcome.summary)
    return text if e == UNKNOWN else f"{text}, e = {e}"


def compare_runs(options: Compare) -> int:
    """Print the old and the new result of each run, what was set differently, and return the exit status.

    Where nothing else is set, the stored results are compared.

    Raises
    ------
    UsageError
        Options that do not go together.
    SetupError
        The setup or an option instead of it is not allowed.
    """
    wanted = processing_changes(options.correction, options.geometry)
    if options.keep and not (wanted or options.setup):
        raise UsageError("--keep, allowed: together with --setup, --correction or --geometry")
    setup = read_setup(options.setup) if options.setup else None
    found = find_runs(options.paths)
    status = max(map(fail, found.errors), default=0)
    runs = [one.path for one in found.runs]

    def compared(run: Path, report: Progress) -> RunComparison | None:
        if setup is None and not wanted:
            return compare_stored(run)
        return compare_with(run, report, setup=setup, changes=wanted, keep=options.keep)

    with progress_bar("compare") as report:
        outcomes = [*each_run(runs, compared, report)]
    for outcome in outcomes:
        if outcome.error is not None:
            status = fail(outcome.error, str(outcome.run)) and FAILED
        elif outcome.value is None:
            typer.echo(f"{outcome.run}: no result before the present one")
    _show([outcome.value for outcome in outcomes if outcome.value is not None])
    return status


def _show(compared: list[RunComparison]) -> None:
    if not compared:
        return
    header = ("run", "e before", "e after", "difference", "g before", "g after", "status before", "status after")
    show_table(header, [_row(one) for one in compared])
    pairs = [(e.before, e.after) for one in compared if (e := _figure(one, "e")).difference is not None]
    if len(pairs) > 1:
        before, after = (statistics_of(side) for side in zip(*pairs, strict=True))
        change = statistics_of(e.difference for one in compared if (e := _figure(one, "e")))
        typer.echo(
            f"mean e of {len(pairs)} runs: {before.words()} before, {after.words()} after, "
            f"{alone(change.mean, after.standard_error, signed=True)}"
        )
    shown = None
    for one in compared:
        settings = [*map(str, one.settings)]
        if settings != shown:
            typer.echo(f"set differently ({one.run.name}): " + ("; ".join(settings) or "nothing"))
        shown = settings


def _row(one: RunComparison) -> tuple[str, ...]:
    e, g = _figure(one, "e"), _figure(one, "g_m_s2")
    of_e, of_g = ((quantity(x.before, x.u_before), quantity(x.after, x.u_after)) for x in (e, g))
    return (
        f"{one.run.parent.name}/{one.run.stem}",
        *of_e,
        alone(e.difference, e.u_difference, signed=True),
        *of_g,
        *(str(side.summary.get("status", UNKNOWN)).replace("_", " ") for side in (one.before, one.after)),
    )


def _figure(one: RunComparison, name: str) -> ComparedFigure:
    return next(figure for figure in one.figures if figure.name == name)
