"""A bar on stderr where that is a terminal, nothing elsewhere; what it shows while runs are recorded."""

import sys

import typer
from rich.console import Console
from rich.progress import BarColumn, Progress, ProgressColumn, TextColumn, TimeElapsedColumn

from radargui.cli.console import one_line
from radargui.experiment.event import Event, EventKind, ExperimentState, RecordedRun


class Bar(Progress):
    """One task with its bar; a context in which it is on the screen.

    Parameters
    ----------
    columns
        What it is made of.
    description
        What is done.
    total
        How much there is to do; None: not known yet.
    """

    def __init__(self, *columns: ProgressColumn, description: str = "", total: float | None = None) -> None:
        console, hidden = Console(stderr=True), not sys.stderr.isatty()
        super().__init__(*columns, console=console, transient=True, redirect_stdout=False, disable=hidden)
        self.shown = self.add_task(description, total=total)

    def say(self, text: str, *, err: bool = False) -> None:
        """Print a line, above the bar."""
        self.stop()
        typer.echo(text, err=err)
        self.start()


class RecordProgress(Bar):
    """The listener of an experiment.

    Parameters
    ----------
    n_runs
        How many runs are asked for.
    """

    def __init__(self, n_runs: int) -> None:
        super().__init__(TextColumn("{task.description}", markup=False), BarColumn(), TimeElapsedColumn())
        self._n_runs = n_runs
        self._health = ""
        self._so_far = ""

    def __call__(self, event: Event) -> None:
        """Show what happened."""
        if event.kind is EventKind.HEALTH:
            self._health = event.message
        if event.kind is EventKind.WARNING:
            self.say(f"run {event.number}: warning: {one_line(event.message)}", err=True)
        elif event.kind is EventKind.PRELIMINARY:
            self._so_far = event.message
        elif event.kind is EventKind.RUN:
            self._so_far = ""
            self.say(f"run {event.number}: {_outcome(event.run) or self._health}")
        elif event.kind is not EventKind.RECORDED:
            self._show(event)

    def _show(self, event: Event) -> None:
        # of a run that is processed while the next one is armed nothing is said: the next one is what to watch
        if event.kind is EventKind.PROGRESS and event.state is not ExperimentState.PROCESSING:
            return
        text = f"run {event.number} of {self._n_runs}: {event.state.value}"
        if event.state in (ExperimentState.ARMED, ExperimentState.RECORDING) and self._health:
            text += f", {self._health}"
        if event.state is ExperimentState.PROCESSING and self._so_far:
            text += f", {self._so_far}"
        total = 1.0 if event.state is ExperimentState.PROCESSING else None
        self.update(self.shown, description=text, total=total, completed=event.fraction or 0.0)


def _outcome(run: RecordedRun | None) -> str:
    """Return what to say of a run: why it is set aside, else the health of its recording."""
    if run is None:
        return ""
    return one_line(run.message) if run.set_aside else run.health_line
