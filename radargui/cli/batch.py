"""`radargui batch`: many stored runs processed again, on all cores or on a cluster."""

from collections import Counter
from contextlib import closing
from dataclasses import replace

import typer
from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeRemainingColumn

from radargui.cli.app import Batch
from radargui.cli.bar import Bar
from radargui.cli.console import FAILED, fail
from radargui.cli.setup_choice import processing_changes
from radargui.experiment.batch.cluster import run_on_cluster
from radargui.experiment.batch.local import run_local
from radargui.experiment.batch.task import BatchOutcome, BatchTask, FoundRuns, TablesTo, find_runs
from radargui.model.drop import restitution_words
from radargui.model.errors import RadarGuiError, UsageError
from radargui.model.rounding import UNKNOWN
from radargui.model.setup_file import read_setup
from radargui.report.tables import tables_are_current, write_tables


def run_batch(options: Batch) -> int:
    """Process all runs below the paths, print each as it ends, and return the exit status.

    Raises
    ------
    UsageError
        Options that do not go together, or two runs whose tables would go to the same folder.
    SetupError
        The setup or an option instead of it is not allowed.
    RadarGuiError
        The cluster cannot be used.
    """
    if options.workers is not None and options.scheduler is not None:
        raise UsageError("--workers and --scheduler do not go together: the cluster has its own workers")
    wanted, found = processing_changes(options.correction, options.geometry), find_runs(options.paths)
    tasks = _tasks(options, wanted, found)
    for error in found.errors:
        fail(error)
    states: Counter[str] = Counter(failed=len(found.errors))
    try:
        if options.scheduler is None or not tasks:
            outcomes = run_local(tasks, options.workers)
        else:
            outcomes = run_on_cluster(tasks, options.scheduler)
        with BatchProgress(len(found.runs)) as progress, closing(outcomes):
            for outcome in outcomes:
                states[outcome.state] += 1
                progress.ended(outcome)
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


def _tasks(options: Batch, wanted: dict[str, str], found: FoundRuns) -> list[BatchTask]:
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


class BatchProgress(Bar):
    """A line for each run that ends; on a terminal also a bar with the remaining time.

    Parameters
    ----------
    n_runs
        How many there are.
    """

    def __init__(self, n_runs: int) -> None:
        columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
        super().__init__(*columns, description="runs", total=n_runs)

    def ended(self, outcome: BatchOutcome) -> None:
        """Print the outcome of a run."""
        if outcome.error is not None:
            fail(outcome.error, str(outcome.run))
        elif outcome.state == "done":
            self.say(f"{outcome.run}: {_figures(outcome)}")
        self.advance(self.shown)


def _figures(outcome: BatchOutcome) -> str:
    text = str(outcome.summary.get("status")).replace("_", " ")
    e = restitution_words(outcome.summary)
    return text if e == UNKNOWN else f"{text}, e = {e}"
