"""A run file written anew with a change, put in place of the old one in one step: a crash cannot spoil a recording."""

import contextlib
import itertools
import os
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

import h5py

from radargui.files import hdf5
from radargui.files.refusal import why
from radargui.files.run_header import is_run
from radargui.files.staged_file import StagedFile
from radargui.model.errors import FileError

_LEFT_BEHIND_S = 86_400.0
"""Age of a half-written copy that nobody can be working on any more: no rewriting takes a day."""
_numbers = itertools.count(1)


@contextmanager
def rewritten(path: Path, said: str) -> Iterator[tuple[Any, Any]]:
    """Hand out a run file and an empty new one, which takes the place of the first when the block ends well.

    Parameters
    ----------
    path
        Run file.
    said
        What a refusal says cannot be done.

    Raises
    ------
    FileError
        The run cannot be read or the folder cannot be written; the recording is as it was.
    """
    partial: Path | None = None
    try:
        with hdf5.opened(path, "a run file", is_run) as source:
            try:
                staged = _new_file(path)
                partial = Path(staged.name)
                with closing(staged):
                    with h5py.File(staged, "w") as target:
                        yield source, target
                    staged.commit()
                    staged.sync()
            except (OSError, RuntimeError, ValueError, TypeError) as error:
                raise _refused(path, said, error) from error
        try:
            partial.replace(path)
        except OSError as error:
            raise _refused(path, said, error) from error
    except BaseException:
        if partial is not None:
            with contextlib.suppress(OSError):
                partial.unlink(missing_ok=True)
        raise


def copy_attribute(source: Any, target: Any, key: str) -> None:
    """Copy one attribute, texts with fixed length."""
    value = source[key]
    if isinstance(value, bytes):
        hdf5.put_text(target, key, value.decode("utf-8", "replace"))
    else:
        target[key] = value


def _new_file(path: Path) -> StagedFile:
    """Make a working file under a name of its own: two programs that write results must not share one."""
    for old in path.parent.glob(f"{path.name}.*.part"):
        with contextlib.suppress(OSError):
            if time.time() - old.stat().st_mtime > _LEFT_BEHIND_S:
                # what a crash left behind is a copy
                old.unlink()
    while True:
        partial = path.with_name(f"{path.name}.{os.getpid()}-{next(_numbers)}.part")
        try:
            return StagedFile(partial, automatic=True)
        except FileExistsError:
            continue


def _refused(path: Path, said: str, error: Exception) -> FileError:
    return FileError(
        f"{path}: {said}: {why(error)} The recording is as it was.",
        reasons=("the disk is full", "another program has the file open", "the folder cannot be written"),
        remedy="Try again once that is settled.",
    )
