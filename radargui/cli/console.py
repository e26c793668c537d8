"""Print what every console can show, and turn any error into one clear line and an exit status."""

import errno
import io
import logging
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from logging.handlers import RotatingFileHandler

import typer

from radargui.model.errors import FileError, RadarGuiError, SetupError, UsageError, fault_of
from radargui.session.ending import interrupt, on_ending
from radargui.system.resources import LOG_FORMAT, log_path


def make_output_safe() -> None:
    """Let a console that lacks a sign (a code page of Windows) show a replacement instead of failing."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")


def one_line(text: str) -> str:
    """Return a text without line breaks and runs of blanks."""
    return " ".join(text.split())


FAILED, WRONG_USAGE, INTERRUPTED = 1, 2, 130
"""Exit codes: of any error, of wrong usage as in click and Unix shells, and 128 + 2 for the signal SIGINT."""
_log = logging.getLogger(__name__)


def guarded(app: typer.Typer, arguments: list[str] | None = None) -> int:
    """Run the command line and return the exit status: 0, 1 something failed, 2 wrong usage or bad setup."""
    make_output_safe()
    start_log()
    try:
        with on_ending(interrupt), _file_warnings_shown():
            # in this mode the library returns the status that the command returned, or that of an interrupt
            status = app(args=arguments, prog_name="radargui", standalone_mode=False)
    except RadarGuiError as error:
        return fail(error)
    except typer.TyperException as error:
        context = getattr(error, "ctx", None)
        command = context.command_path if context else "radargui"
        said = error.format_message().replace("Value error, ", "").rstrip(".")
        return fail_line(f"{said}. See {command} --help.", error.exit_code)
    except (typer.Abort, KeyboardInterrupt):
        status = INTERRUPTED
    except Exception as error:  # noqa: BLE001  the last door: whatever it is, the operator gets a line, the log the rest
        return fail_unexpected(error)
    return fail_line("interrupted") if status == INTERRUPTED else int(status or 0)


class _Shown(logging.Handler):
    """Prints warnings as lines on stderr."""

    def emit(self, record: logging.LogRecord) -> None:
        """Print one."""
        typer.echo(f"warning: {one_line(record.getMessage())}", err=True)


@contextmanager
def _file_warnings_shown() -> Iterator[None]:
    """Show meanwhile what the readers of files warn of (another rate than the file's own, bytes left out)."""
    shown, of_files = _Shown(logging.WARNING), logging.getLogger("radargui.files")
    of_files.addHandler(shown)
    try:
        yield
    finally:
        of_files.removeHandler(shown)


def fail(error: RadarGuiError, what: str = "") -> int:
    """Print an error in one line, log it, and return its exit status."""
    _log.error("%s", error, exc_info=error)
    text = str(error)
    status = WRONG_USAGE if isinstance(error, UsageError | SetupError) else FAILED
    return fail_line(f"{what}: {text}" if what and what not in text else text, status)


def fail_unexpected(error: Exception, what: str = "") -> int:
    """Print an error that nobody foresaw in one line, put the rest into the log, and return the exit status."""
    if isinstance(error, OSError) and error.errno == errno.ENAMETOOLONG:
        # whoever first looks at a path that was given meets it
        return fail(FileError(f"{error.filename} is a longer path than this system allows.", remedy="Shorten it."))
    _log.error("Unexpected error %s", what, exc_info=error)
    text = f"{fault_of(error, what or 'The program')} The details are in {log_path()}"
    return fail_line(text)


def fail_line(text: str, status: int = FAILED) -> int:
    """Print what failed in one line and return its exit status."""
    sys.stdout.flush()
    typer.echo(f"error: {one_line(text)}", err=True)
    return WRONG_USAGE if status == WRONG_USAGE else FAILED


MAXIMUM_BYTES = 1_000_000
"""Of the log file; then a new one is begun."""
OLD_FILES = 3
"""Kept beside the present one: 4 MB in all. Chosen by hand."""


class _QuietHandler(RotatingFileHandler):
    """A file handler that never disturbs the command: a full disk or a locked file costs the entry only."""

    def handleError(self, record: logging.LogRecord) -> None:  # noqa: N802  name of the library
        """Drop the entry."""


def start_log() -> None:
    """Send log entries and library warnings to the file; where none can be made one line says so, and none is kept."""
    root = logging.getLogger()
    if any(isinstance(handler, _QuietHandler | logging.NullHandler) for handler in root.handlers):
        return
    path = log_path()
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.open("ab").close()
        handler = _QuietHandler(path, maxBytes=MAXIMUM_BYTES, backupCount=OLD_FILES, encoding="utf-8", delay=True)
    except OSError as error:
        # without any handler the entries would go to the terminal, with tracebacks
        root.addHandler(logging.NullHandler())
        sys.stderr.write(f"note: no log is kept: {path} cannot be written ({error.strerror or error})\n")
        return
    handler.setFormatter(logging.Formatter(LOG_FORMAT))
    root.addHandler(handler)
    logging.getLogger("radargui").setLevel(logging.INFO)
    logging.captureWarnings(capture=True)
