"""A bar on stderr where that is a terminal; nothing elsewhere."""

from __future__ import annotations

import sys
from types import TracebackType
from typing import Self

import typer
from rich.console import Console
from rich.progress import Progress, ProgressColumn


class Bar:
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
        self._progress: Progress | None = None
        if sys.stderr.isatty():
            self._progress = Progress(*columns, console=Console(stderr=True), transient=True, redirect_stdout=False)
            self._task = self._progress.add_task(description, total=total)

    def __enter__(self) -> Self:
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

    def show(self, description: str, *, total: float | None, completed: float) -> None:
        """Show what is done and how far it is."""
        if self._progress:
            self._progress.update(self._task, description=description, total=total, completed=completed)

    def advance(self) -> None:
        """Show that one more is done."""
        if self._progress:
            self._progress.advance(self._task)

    def say(self, text: str, *, err: bool = False) -> None:
        """Print a line, above the bar."""
        if self._progress:
            self._progress.stop()
        typer.echo(text, err=err)
        if self._progress:
            self._progress.start()
