"""The log file: what happened in detail, kept small by rotation."""

import logging
import sys
from logging.handlers import RotatingFileHandler
from pathlib import Path

import platformdirs

MAXIMUM_BYTES = 1_000_000
OLD_FILES = 3
"""Kept beside the present one: 4 MB in all. Chosen by hand."""


class _QuietHandler(RotatingFileHandler):
    """A file handler that never disturbs the command: a full disk or a locked file costs the entry only."""

    def handleError(self, record: logging.LogRecord) -> None:  # noqa: N802  name of the library
        """Drop the entry."""


def log_path() -> Path:
    """Return the log file's path."""
    return platformdirs.user_log_path("radargui", appauthor=False) / "radargui.log"


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
    handler.setFormatter(logging.Formatter("%(asctime)s %(levelname)s %(name)s: %(message)s"))
    root.addHandler(handler)
    logging.getLogger("radargui").setLevel(logging.INFO)
    logging.captureWarnings(capture=True)
