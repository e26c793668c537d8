"""Output that every console can show: lines, tables, a progress bar; any error as one clear line and a status."""

import io
import logging
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager

import typer

from radargui.cli.log import log_path, start_log
from radargui.model.errors import RadarGuiError, SetupError, UsageError, fault_of
from radargui.session.ending import interrupt, on_ending

PIPE_WIDTH = 200


def make_output_safe() -> None:
    """Let a console that lacks a sign (a code page of Windows) show a replacement instead of failing."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")


def one_line(text: str) -> str:
    """Return a text without line breaks and runs of blanks."""
    return " ".join(text.split())


def show_table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Print a table; the first column to the left, the others to the right."""
    from rich.box import SIMPLE_HEAD
    from rich.console import Console
    from rich.table import Table

    table = Table(box=SIMPLE_HEAD, pad_edge=False, show_edge=False)
    for number, title in enumerate(header):
        table.add_column(title, justify="right" if number else "left", no_wrap=True)
    for row in rows:
        table.add_row(*row)
    width = None if sys.stdout.isatty() else PIPE_WIDTH
    Console(width=width, markup=False, highlight=False, emoji=False).print(table)


def figure(summary: Mapping[str, object], key: str) -> float | None:
    """Return a figure of a run's summary; None where it is not known."""
    value = summary.get(key)
    return value if isinstance(value, float) else None


@contextmanager
def progress_bar(title: str) -> Iterator[Callable[[float], None]]:
    """Give a function that takes the fraction done (0 to 1); a bar on stderr where that is a terminal."""
    if not sys.stderr.isatty():
        yield lambda fraction: None
        return
    from rich.console import Console
    from rich.progress import Progress

    with Progress(console=Console(stderr=True), transient=True) as progress:
        task = progress.add_task(title, total=1.0)
        yield lambda fraction: progress.update(task, completed=fraction)


FAILED, WRONG_USAGE = 1, 2
_log = logging.getLogger(__name__)


def guarded(app: typer.Typer, arguments: list[str] | None = None) -> int:
    """Run the command line and return the exit status: 0, 1 something failed, 2 wrong usage or bad setup."""
    make_output_safe()
    start_log()
    try:
        with on_ending(interrupt):
            # in this mode the library returns the status that the command returned, and 130 after an interrupt
            status = app(args=arguments, prog_name="radargui", standalone_mode=False)
    except RadarGuiError as error:
        return fail(error)
    except typer.TyperException as error:
        context = getattr(error, "ctx", None)
        command = context.command_path if context else "radargui"
        return _fail_line(f"{error.format_message().rstrip('.')}. See {command} --help.", error.exit_code)
    except (typer.Abort, KeyboardInterrupt):
        return _interrupted()
    except Exception as error:  # noqa: BLE001  the last door: whatever it is, the operator gets a line, the log the rest
        return fail_unexpected(error)
    return _interrupted() if status == 130 else int(status or 0)


def fail(error: RadarGuiError, what: str = "") -> int:
    """Print an error in one line, log it, and return its exit status."""
    _log.error("%s", error, exc_info=error)
    text = str(error)
    return _fail_line(f"{what}: {text}" if what and what not in text else text, status_of(error))


def fail_unexpected(error: Exception, what: str = "") -> int:
    """Print an error that nobody foresaw in one line, put the rest into the log, and return the exit status."""
    _log.error("Unexpected error %s", what, exc_info=error)
    text = f"{fault_of(error, what or 'The program')} The details are in {log_path()}"
    return _fail_line(text, FAILED)


def status_of(error: RadarGuiError) -> int:
    """Return the exit status of an error."""
    return WRONG_USAGE if isinstance(error, UsageError | SetupError) else FAILED


def _interrupted() -> int:
    return _fail_line("interrupted", FAILED)


def _fail_line(text: str, status: int) -> int:
    sys.stdout.flush()
    typer.echo(f"error: {one_line(text)}", err=True)
    return WRONG_USAGE if status == WRONG_USAGE else FAILED
