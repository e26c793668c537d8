"""From any error to one clear line on stderr and an exit status; never a traceback."""

from __future__ import annotations

import logging
import sys

import typer

from radargui.cli.console import make_output_safe, one_line
from radargui.cli.log import log_path, start_log
from radargui.model.errors import RadarGuiError, SetupError, UsageError, fault_of
from radargui.session.ending import interrupt, on_ending

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
