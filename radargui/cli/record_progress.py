"""What the operator sees while runs are recorded: a status line on a terminal, one line a run elsewhere."""

from __future__ import annotations

import sys
from types import TracebackType

import typer
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

from radargui.cli.console import one_line
from radargui.experiment.event import Event, EventKind
from radargui.experiment.state import ExperimentState


class RecordProgress:
    """The listener of an experiment; a context in which the bar is on the screen.

    Parameters
    ----------
    n_runs
        How many runs are asked for.
    """

    def __init__(self, n_runs: int) -> None:
        self._n_runs = n_runs
        self._health = ""
        self._so_far = ""
        self._progress: Progress | None = None
        if sys.stderr.isatty():
            columns = (TextColumn("{task.description}", markup=False), BarColumn(), TimeElapsedColumn())
            self._progress = Progress(*columns, console=Console(stderr=True), transient=True, redirect_stdout=False)
            self._task = self._progress.add_task("", total=None)

    def __enter__(self) -> RecordProgress:
        """Show the bar."""
        if self._progress:
            self._progress.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Take the bar away."""
        if self._progress:
            self._progress.stop()

    def __call__(self, event: Event) -> None:
        """Show what happened."""
        if event.kind is EventKind.HEALTH:
            self._health = event.message
        if event.kind is EventKind.WARNING:
            self._say(f"run {event.number}: warning: {one_line(event.message)}", err=True)
        elif event.kind is EventKind.PRELIMINARY:
            self._so_far = event.message
        elif event.kind is EventKind.RUN:
            self._so_far = ""
            self._say(f"run {event.number}: {_outcome(event) or _line(event) or self._health}")
        elif self._progress:
            self._show(event)

    def _show(self, event: Event) -> None:
        bar = self._progress
        # of a run that is processed while the next one is armed nothing is said: the next one is what to watch
        if bar is None or (event.kind is EventKind.PROGRESS and event.state is not ExperimentState.PROCESSING):
            return
        text = f"run {event.number} of {self._n_runs}: {event.state.value}"
        if event.state in (ExperimentState.ARMED, ExperimentState.RECORDING) and self._health:
            text += f", {self._health}"
        if event.state is ExperimentState.PROCESSING and self._so_far:
            text += f", {self._so_far}"
        total = 1.0 if event.state is ExperimentState.PROCESSING else None
        bar.update(self._task, description=text, total=total, completed=event.fraction or 0.0)

    def _say(self, text: str, *, err: bool = False) -> None:
        if self._progress:
            self._progress.stop()
        typer.echo(text, err=err)
        if self._progress:
            self._progress.start()


def _outcome(event: Event) -> str:
    """Return what to say of a run instead of the health of its recording."""
    run = event.run
    if run is None:
        return ""
    if run.set_aside:
        return one_line(run.message)
    return ""


def _line(event: Event) -> str:
    return event.run.health_line if event.run is not None else ""
