"""A bar on stderr where that is a terminal; nothing elsewhere."""

from __future__ import annotations

import sys

import typer
from rich.console import Console
from rich.progress import Progress, ProgressColumn


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
