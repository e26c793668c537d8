"""The words in which a library's complaint reaches the operator."""

import errno
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from radargui.model.errors import FileError, RadarGuiError

SHOWN_NAMES = 24
"""Names in one message: three receivers four times over. Chosen by hand."""


def why(error: BaseException) -> str:
    """Return one short line on what a library or the system said."""
    if isinstance(error, OSError) and error.errno in (errno.ENOSPC, errno.EDQUOT):
        return "the disk is full."
    if isinstance(error, OSError) and error.strerror and error.errno:
        said = error.strerror
    else:
        said = " ".join(str(error).split()) or type(error).__name__
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
    except PermissionError as error:
        raise FileError(f"{path} cannot be opened: {why(error)}") from None
    except Exception as error:
        raise FileError(
            f"{path} cannot be read as {what}: {why(error)}",
            reasons=("it is damaged or cut off", "it is another kind of file"),
        ) from error
