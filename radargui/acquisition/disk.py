"""The disk that a run is written to: how much is free, how long it lasts, when to stop."""

import shutil
import tempfile
from pathlib import Path

from radargui.model.errors import FileError

MINIMUM_FREE_BYTES = 200_000_000
"""Stays free for closing the run and storing its results; chosen by hand."""
LOW_S = 600.0
"""Recording time left at which the operator is warned: enough to end a series in order; chosen by hand."""


def free_bytes(folder: Path) -> int | None:
    """Return the free bytes of the disk that holds `folder`; None where nobody knows."""
    try:
        return shutil.disk_usage(folder).free
    except OSError:
        return None


def want_writable(folder: Path) -> None:
    """Make sure that files can be made in a folder, before anything is recorded.

    Raises
    ------
    FileError
        None can be made there.
    """
    try:
        with tempfile.TemporaryFile(dir=folder, prefix=".writable-") as probe:
            probe.write(b"0")
    except OSError as error:
        raise FileError(
            f"Nothing can be written to {folder}: {error.strerror or error}",
            reasons=("the folder is not there any more", "it belongs to somebody else", "the disk is full"),
            remedy="Choose another folder for the sessions.",
        ) from None


def low_disk_error(folder: Path, free: int, minimum: int) -> FileError:
    """Return the error that ends a recording while its file can still be closed."""
    return FileError(
        f"The disk of {folder} has only {free / 1e6:.0f} MB left, {minimum / 1e6:.0f} MB must stay free",
        remedy="Free some space or choose another folder for the sessions.",
    )
