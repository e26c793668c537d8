"""Print tables on stdout, and a progress bar on stderr where that is a terminal."""

import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager

import typer
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.progress import Progress, ProgressColumn
from rich.table import Table

PIPE_WIDTH = 20_000
"""Columns of a table written to a file or pipe, which has no width. Chosen by hand: more than paths are long."""


def show_table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Print a table; the first column to the left, the others to the right.

    On a terminal that is too narrow the widest cells go on below: a result that is cut off is none.
    """
    table = Table(box=SIMPLE_HEAD, pad_edge=False, show_edge=False)
    for number, title in enumerate(header):
        table.add_column(title, justify="right" if number else "left", overflow="fold")
    for row in rows:
        table.add_row(*row)
    width = None if sys.stdout.isatty() else PIPE_WIDTH
    Console(width=width, markup=False, highlight=False, emoji=False).print(table)


class Bar(Progress):
    """One task with its bar; a context in which it is on the screen.

    Parameters
    ----------
    columns
        What it is made of; left out: bar, share done, time left.
    description
        What is done.
    total
        How much there is to do; None: not known yet.
    """

    def __init__(self, *columns: ProgressColumn, description: str = "", total: float | None = None) -> None:
        # lines of stdout come above the bar where both are on the terminal; elsewhere they stay what they are
        above, hidden = sys.stdout.isatty(), not sys.stderr.isatty()
        super().__init__(*columns, console=Console(stderr=True), transient=True, redirect_stdout=above, disable=hidden)
        self.shown = self.add_task(description, total=total)

    def say(self, text: str, *, err: bool = False) -> None:
        """Print a line, above the bar."""
        self.stop()
        typer.echo(text, err=err)
        self.start()


@contextmanager
def progress_bar(title: str) -> Iterator[Callable[[float], None]]:
    """Give a function that takes the fraction done (0 to 1)."""
    with Bar(description=title, total=1.0) as bar:
        yield lambda fraction: bar.update(bar.shown, completed=fraction)
