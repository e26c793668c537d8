"""The folder of a session: where it goes, made anew, under a name that every system can have."""

import re
from pathlib import Path

import platformdirs

from radargui.model.errors import SessionError

REPORT_FOLDER = "report"
NAME_FORMAT = "%Y-%m-%dT%H-%M-%S"
_UNFIT = re.compile(r'[<>:"/\\|?*\x00-\x1f]')
_RESERVED = re.compile(r"(con|prn|aux|nul|com\d|lpt\d)(\..*)?", re.IGNORECASE)


class DataFolderError(SessionError):
    """No session can be made in the folder that was chosen for sessions."""


def new_folder(parent: Path, name: str) -> Path:
    """Make a folder that was not there; where the name is taken, -2, -3, ... is added.

    Raises
    ------
    DataFolderError
        It cannot be made.
    """
    try:
        parent.mkdir(parents=True, exist_ok=True)
        for number in range(1, 10_000):
            folder = parent / (name if number == 1 else f"{name}-{number}")
            try:
                folder.mkdir()
            except FileExistsError:
                continue
            return folder
    except OSError as error:
        raise DataFolderError(
            f"No session can be made in {parent}: {error.strerror or error}.",
            reasons=("the folder cannot be written", "part of the path is a file", "the disk is full"),
            remedy="Choose another data folder.",
        ) from None
    raise DataFolderError(f"{parent} holds too many sessions named {name}.", remedy="Choose another name.")


def own_subfolder(session: Path, name: str) -> Path:
    """Return the folder of a session that results go into; it may not be there yet.

    Raises
    ------
    SessionError
        It leads out of the session: a link in a folder that came from elsewhere shall not decide where files are
        written.
    """
    folder = session / name
    if not folder.resolve().is_relative_to(session.resolve()):
        raise SessionError(
            f"{folder} is a link out of the session, to {folder.resolve()}: nothing is written there.",
            remedy="Remove the link, or name that folder with --output.",
        )
    return folder


def fit_name(name: str) -> str:
    """Return a name that every system can have.

    Raises
    ------
    SessionError
        It cannot be the name of a folder.
    """
    if not name or name != name.strip() or name.endswith(".") or _UNFIT.search(name) or _RESERVED.fullmatch(name):
        raise SessionError(
            f"{name!r} cannot be the name of a session.",
            remedy='Use letters, digits, space, "-", "_" and "." inside.',
        )
    return name


def default_data_folder() -> Path:
    """Return the folder RadarGUI in the user's documents; it may not be there yet."""
    return Path(platformdirs.user_documents_dir()) / "RadarGUI"
