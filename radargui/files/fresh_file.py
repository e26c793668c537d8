"""A file that appears whole or not at all, and takes the place of another only when that is wanted."""

import os
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from radargui.files.refusal import why
from radargui.model.errors import FileError


@contextmanager
def fresh_files(paths: Sequence[Path], *, force: bool = False) -> Iterator[tuple[Path, ...]]:
    """Hand out a working path for each file; they get their names when the block ends well, else they vanish.

    Parameters
    ----------
    paths
        Files to make, all in folders that are there.
    force
        Whether files that are there are replaced.

    Raises
    ------
    FileError
        One is there already, or cannot be written.
    """
    refuse_existing(paths, force=force)
    partial = tuple(path.with_name(path.name + ".part") for path in paths)
    try:
        yield partial
        for part, path in zip(partial, paths, strict=True):
            part.replace(path)
    except OSError as error:
        raise FileError(
            f"{paths[0]} cannot be written: {why(error)}",
            reasons=("the disk is full", "the folder is write protected", "another program has the file open"),
            remedy="Close programs that show the file, or choose another folder.",
        ) from error
    finally:
        for part in partial:
            with suppress(OSError):
                part.unlink()


def write_whole(path: Path, parts: Iterable[bytes]) -> None:
    """Write a file under another name, then give it its own; one that is there is replaced.

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
    with fresh_files([path], force=True) as (partial,):
        path.parent.mkdir(parents=True, exist_ok=True)
        with partial.open("wb") as file:
            file.writelines(parts)
            file.flush()
            os.fsync(file.fileno())


def refuse_existing(paths: Sequence[Path], *, force: bool) -> None:
    """Refuse to go on where a file is there already, unless `force`.

    Raises
    ------
    FileError
        One is there.
    """
    there = [path for path in paths if path.exists()]
    if there and not force:
        shown = ", ".join(str(path) for path in there[:3]) + (" ..." if len(there) > 3 else "")
        verb = "is" if len(there) == 1 else "are"
        raise FileError(f"{shown} {verb} there already.", remedy="Choose another folder, or write over with --force.")


def make_folder(folder: Path) -> None:
    """Make a folder where it is not there.

    Raises
    ------
    FileError
        It cannot be made.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FileError(f"{folder} cannot be made: {why(error)}", remedy="Choose another folder.") from error
