"""A session folder and the record kept in it (session.json): names, words, settings, versions."""

import json
import platform
import re
from contextlib import suppress
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any, Literal, TypedDict

import platformdirs
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from radargui import __version__
from radargui.files.access import write_whole
from radargui.model.calibrated_setup import calibration_words
from radargui.model.errors import SessionError, worded
from radargui.model.setup import Setup, plain
from radargui.model.setup_error import describe

REPORT_FOLDER = "report"
NAME_FORMAT = "%Y-%m-%dT%H-%M-%S"
_UNFIT = re.compile(r'[<>:"/\\|?*\x00-\x1f]')
_RESERVED = re.compile(r"(con|prn|aux|nul|com\d|lpt\d)(\..*)?", re.IGNORECASE)


class DataFolderError(SessionError):
    """No session can be made in the folder that was chosen for sessions."""


def new_folder(parent: Path, name: str | None, now: datetime) -> Path:
    """Make a folder that was not there, named after the time where it has no name; -2, -3, ... where that is taken.

    Raises
    ------
    DataFolderError
        It cannot be made.
    SessionError
        This cannot be the name of a folder.
    """
    name = now.strftime(NAME_FORMAT) if name is None else _fit(name)
    try:
        parent.mkdir(parents=True, exist_ok=True)
        for number in range(1, 10_000):
            folder = parent / (name if number == 1 else f"{name}-{number}")
            with suppress(FileExistsError):
                folder.mkdir()
                return folder
    except OSError as error:
        raise worded(DataFolderError, "no_session", parent=parent, why=error.strerror or error) from None
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
        raise worded(SessionError, "link_out", folder=folder, target=folder.resolve())
    return folder


def _fit(name: str) -> str:
    """Return a name that every system can have."""
    if not name or name != name.strip() or name.endswith(".") or _UNFIT.search(name) or _RESERVED.fullmatch(name):
        raise worded(SessionError, "session_name", name=name)
    return name


def default_data_folder() -> Path:
    """Return the folder RadarGUI in the user's documents; it may not be there yet."""
    return Path(platformdirs.user_documents_dir()) / "RadarGUI"


_LIBRARIES = ("numpy", "scipy", "h5py", "nidaqmx")


def version_of(package: str) -> str:
    """Return the version of a package; empty where it is not installed."""
    with suppress(PackageNotFoundError):
        return version(package)
    return ""


def versions() -> dict[str, str]:
    """Return program, Python, system and libraries with their versions."""
    own = {"radargui": __version__, "python": platform.python_version(), "system": platform.platform()}
    return own | {library: found for library in _LIBRARIES if (found := version_of(library))}


FILE_NAME = "session.json"
CALIBRATION_NAME = "calibration.json"
MAXIMUM_BYTES = 10_000_000
"""More is no record of a session and is not read into memory. Chosen by hand."""
SCHEMA = 1
"""Of session.json as this version writes it."""


class _Record(BaseModel):
    """Immutable; a key of a later version is passed over."""

    model_config = ConfigDict(frozen=True, extra="ignore")


class CalibrationRecord(_Record):
    """Where the antenna calibration in the setup comes from."""

    made_at: str = ""
    """ISO 8601 date, or date and time; empty where nobody knows."""
    origin: str = ""
    """How it was made or which file it was read from."""
    file: str = ""
    """Name of the copy of it in the session's folder; empty where there is none."""


class JournalEntry(_Record):
    """A note made while the session was under way."""

    at: str
    """ISO 8601 date and time with offset from UTC."""
    text: str
    run: str = ""
    """Name of the run file that was being recorded, or that the note is about; empty between runs."""
    index: int | None = None
    """Sample of that run, counted from its first, lost ones included; None of a note about the whole run."""


class SessionInfo(_Record):
    """The facts of a session; the setup holds settings and antenna calibration with its uncertainties."""

    schema_version: Literal[1] = 1
    name: str
    created_at: str
    operator: str = ""
    sample: str = ""
    """What is measured: material, make, surface of the sphere, ..."""
    target: str = ""
    """What it falls on, or moves in."""
    notes: str = ""
    calibration: CalibrationRecord = CalibrationRecord()
    setup_name: str = ""
    """Name of the setup file, without folder and suffix, a star behind one that was edited; empty without a file."""
    source: str = ""
    """Where its samples come from: SIMULATED, REPLAY, NI Dev1; empty where no record says so."""
    journal: tuple[JournalEntry, ...] = ()
    versions: dict[str, str] = Field(default_factory=dict)
    rejected: dict[str, str] = Field(default_factory=dict)
    """Runs that were set aside, by the name of the file, each with the reason: kept, hidden, reversible."""
    setup: Setup

    def notes_of(self, run: str) -> str:
        """Return what was noted about or during a run, by the name of its file; empty where nothing was."""
        return "; ".join(entry.text for entry in self.journal if entry.run == run)


class SessionDetails(TypedDict, total=False):
    """What is known of a session when it is made, and can be told later, see `SessionInfo`; None: as it is."""

    operator: str | None
    sample: str | None
    target: str | None
    notes: str | None
    calibration: CalibrationRecord | None
    setup_name: str | None
    source: str | None


def about_setup_file(path: Path | None, *, is_edited: bool = False) -> SessionDetails:
    """Return the name and the calibration of a setup file, which is when it was last changed; nothing without one.

    A setup that was edited since it was read has a star behind the name of its file.
    """
    if path is None:
        return SessionDetails()
    try:
        changed_at = datetime.fromtimestamp(path.stat().st_mtime, UTC).astimezone().isoformat(timespec="seconds")
    except OSError:
        changed_at = ""
    edited = ", edited in the window since" if is_edited else ""
    record = CalibrationRecord(made_at=changed_at, origin=f"setup file {path.name}, as last changed then{edited}")
    return SessionDetails(calibration=record, setup_name=f"{path.stem}{'*' * is_edited}")


def copied_calibration(setup: Setup, folder: Path) -> CalibrationRecord | None:
    """Copy the calibration that a setup refers to into a session's folder; return what is said of it, None: of none.

    A file that is gone leaves what the setup carries along: values and covariance.

    Raises
    ------
    FileError
        The folder cannot be written.
    """
    own = setup.calibration
    if own.content is None:
        return None
    name, source = "", Path(own.file or "")
    with suppress(OSError):
        found = source.read_bytes()
        name = CALIBRATION_NAME
        write_whole(folder / name, [found])
    said = f"{source.name}: {calibration_words(setup)}"
    return CalibrationRecord(made_at=own.content.made_at, origin=said, file=name)


def write_info(info: SessionInfo, folder: Path) -> None:
    """Write session.json in one step: it is the old one or the new one, never half of one.

    Raises
    ------
    FileError
        The folder cannot be written.
    """
    content: dict[str, Any] = info.model_dump(mode="json", exclude={"setup"})
    content["setup"] = info.setup.model_dump(mode="json", by_alias=True, exclude_none=True)
    content["setup_given"] = plain(info.setup)
    text = json.dumps(content, indent=2, ensure_ascii=False) + "\n"
    write_whole(folder / FILE_NAME, [text.encode()])


def read_info(folder: Path) -> SessionInfo:
    """Return what session.json says.

    Raises
    ------
    SessionError
        No such file, unreadable, or not what this version knows.
    """
    path = folder / FILE_NAME
    try:
        if path.stat().st_size > MAXIMUM_BYTES:
            raise SessionError(f"{path} is larger than the record of a session can be.")
        content = json.loads(path.read_text(encoding="utf-8"))
    except (FileNotFoundError, NotADirectoryError):
        raise SessionError(f"{folder} is not a session: it holds no {FILE_NAME}.") from None
    except OSError as error:
        raise SessionError(f"{path} cannot be read: {error.strerror or error}.") from None
    except (ValueError, RecursionError) as error:
        raise worded(SessionError, "damaged_record", path=path, said=error) from None
    if not isinstance(content, dict):
        raise worded(SessionError, "damaged_record", path=path, said="it holds no table")
    schema = content.get("schema_version")
    if isinstance(schema, int) and schema > SCHEMA:
        raise worded(SessionError, "newer_version", path=path, format=schema, this="this version", known=SCHEMA)
    try:
        info = SessionInfo.model_validate(content)
    except ValidationError as error:
        raise worded(SessionError, "damaged_record", path=path, said=describe(error, SessionInfo)) from None
    return info.model_copy(update={"setup": _as_given(info.setup, content.get("setup_given"))})


def _as_given(setup: Setup, given: object) -> Setup:
    """Return the setup without the values that nobody gave: a floor that is level by default is not known to be.

    What does not say the same as the whole setup, which may have been corrected by hand, does not count.
    """
    with suppress(ValidationError):
        found = Setup.model_validate(given)
        return found if found == setup else setup
    return setup
