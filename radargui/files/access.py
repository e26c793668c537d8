"""Open files for reading and writing, with one wording of errors, and never leave a file half written."""

import errno
import hashlib
import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Generic, TypeVar

from radargui.model.errors import FileError, RadarGuiError, worded

Progress = Callable[[float], None]
"""Takes the share done, 0 to 1."""


def silent(share: float) -> None:
    """Take the share done and report it to nobody."""


Made = TypeVar("Made")
Made_co = TypeVar("Made_co", covariant=True)


@dataclass(frozen=True, slots=True)
class Outcome(Generic[Made_co]):
    """What came of one run: a value, or why not."""

    run: Path
    value: Made_co | None = None
    error: RadarGuiError | None = None


def each_run(
    runs: Sequence[Path], work: Callable[[Path, Progress], Made], progress: Progress = silent
) -> Iterator[Outcome[Made]]:
    """Yield what `work` makes of each run, in order; one that fails does not stop the others.

    Parameters
    ----------
    runs
        Run files.
    work
        Called with a run and what takes the share of it that is done.
    progress
        Called with the share of all that is done; what it raises ends the work.
    """
    for done, run in enumerate(runs):

        def share_of_all(share: float, done: int = done) -> None:
            progress((done + share) / len(runs))

        share_of_all(0.0)
        try:
            yield Outcome(run, work(run, share_of_all))
        except RadarGuiError as error:
            yield Outcome(run, error=error)


SHOWN_NAMES = 24
"""Names in one message: three receivers four times over. Chosen by hand."""


def why(error: BaseException) -> str:
    """Return one short line on what a library or the system said."""
    if isinstance(error, OSError) and error.errno in (errno.ENOSPC, errno.EDQUOT):
        return "the disk is full."
    of_system = error.strerror if isinstance(error, OSError) and error.errno else ""
    said = of_system or " ".join(str(error).split()) or type(error).__name__
    said = said if len(said) <= 160 else said[:157] + "..."
    return said if said.endswith(".") else said + "."


def listed(names: Sequence[str]) -> str:
    """Return names for a message, not more than fit into it."""
    more = len(names) - SHOWN_NAMES
    return ", ".join(names[:SHOWN_NAMES]) + (f" and {more} more" if more > 0 else "")


def resolved(path: Path, names: Sequence[str], present: Sequence[str], shown: Sequence[str] | None = None) -> list[str]:
    """Return names as a file has them; runs of blanks count as one, for messages and shells show them so.

    Parameters
    ----------
    path
        The file.
    names
        What is wanted.
    present
        What can be found.
    shown
        What a refusal names instead of all that is present.

    Raises
    ------
    FileError
        The file holds no such name.
    """
    loose = {" ".join(name.split()): name for name in reversed(present)}
    found = [name if name in present else loose.get(" ".join(name.split())) for name in names]
    there = listed(present if shown is None else shown) or "no channel"
    for name, own in zip(names, found, strict=True):
        if not own:
            raise FileError(f"{path} holds no {name}; it holds {there}.", remedy="Correct --channels.")
    return [own for own in found if own]


def want_file(path: Path) -> None:
    """Refuse, with a FileError, a path where no file is."""
    if path.is_dir():
        raise FileError(f"{path} is a folder, not a file.")
    if not path.is_file():
        raise FileError(f"{path}: no such file.", remedy="Check the path.")


def sha256_of(path: Path) -> str:
    """Return the checksum of a whole file, in hexadecimal digits."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


@contextmanager
def reading(path: Path, what: str) -> Iterator[None]:
    """Turn whatever a library says about a damaged file into a FileError.

    Parsers of foreign formats fail on hostile bytes in any way they like; the operator shall read one clear sentence.

    Raises
    ------
    FileError
        Missing, empty, damaged, or another kind of file.
    """
    want_file(path)
    if path.stat().st_size == 0:
        raise FileError(f"{path} is empty.")
    try:
        yield
    except RadarGuiError:
        raise
    except MemoryError:
        raise FileError(f"{path} does not fit into the memory of this computer.") from None
    except PermissionError:
        # a library adds its own names and flags to what the system says
        said = f"{path} cannot be opened: {os.strerror(errno.EACCES)}."
        raise FileError(said, remedy="Ask whom it belongs to for the right to read it.") from None
    except Exception as error:
        raise worded(FileError, "unreadable", path=path, what=what, why=why(error)) from error


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
        raise _unwritable(paths[0], error) from error
    finally:
        for part in partial:
            with suppress(OSError):
                part.unlink()


def write_whole(path: Path, parts: Iterable[bytes | bytearray]) -> None:
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


def want_room_for(path: Path) -> None:
    """Refuse, before the work whose results go there, a file that cannot be written; its folder is made.

    Raises
    ------
    FileError
        Its folder cannot be made or written, or a folder has its name.
    """
    if path.is_dir():
        raise FileError(f"{path} is a folder, not a file.")
    make_folder(path.parent)
    probe = path.with_name(f".{os.getpid()}.part")
    try:
        probe.touch()
        probe.unlink()
    except OSError as error:
        raise _unwritable(path, error) from error


def _unwritable(path: Path, error: OSError) -> FileError:
    if isinstance(error, NotADirectoryError | FileExistsError):
        return worded(FileError, "path_is_file", path=path)
    is_denied = isinstance(error, PermissionError)
    return worded(FileError, "write_protected" if is_denied else "unwritable", path=path, why=why(error))
