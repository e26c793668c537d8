"""A file that appears whole or not at all."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterable
from pathlib import Path

from radargui.model.errors import FileError


def partial_path(path: Path) -> Path:
    """Return the name under which a file grows until it is whole."""
    return path.with_name(path.name + ".part")


def put_in_place(path: Path) -> None:
    """Give the grown file its name; a file of that name is replaced in one step.

    Raises
    ------
    FileError
        The system refuses; the grown file is removed.
    """
    try:
        partial_path(path).replace(path)
    except OSError as error:
        forget(path)
        raise refusal(path, error) from None


def write_whole(path: Path, parts: Iterable[bytes]) -> None:
    """Write a file under another name, then give it its own.

    Parameters
    ----------
    path
        Its folder is made where it is missing.
    parts
        What to write, in order.

    Raises
    ------
    FileError
        The folder cannot be written or the disk is full; what was there before stays.
    """
    partial = partial_path(path)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with partial.open("wb") as file:
            for part in parts:
                file.write(part)
            file.flush()
            os.fsync(file.fileno())
    except OSError as error:
        forget(path)
        raise refusal(path, error) from None
    except BaseException:
        forget(path)
        raise
    put_in_place(path)


def forget(path: Path) -> None:
    """Remove what had grown of a file that will not be finished."""
    with contextlib.suppress(OSError):
        partial_path(path).unlink()


def refusal(path: Path, error: OSError) -> FileError:
    """Return what to tell the operator about a file that could not be written."""
    return FileError(
        f"{path}: cannot be written: {error.strerror or error}",
        reasons=("the disk is full", "the folder is write protected", "another program has the file open"),
        remedy="Close programs that show the file, or choose another folder.",
    )
