"""A session: one folder with its record and its runs."""

from __future__ import annotations

import platform
import re
from collections.abc import Mapping
from datetime import datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from radargui import __version__
from radargui.files.run_layout import SUFFIX
from radargui.files.run_writer import RunExistsError, RunWriter
from radargui.model.digitisation import Digitisation
from radargui.model.errors import SessionError
from radargui.model.setup import Setup
from radargui.model.setup_file import dump_setup
from radargui.session.info import SessionInfo, read_info, write_info

NAME_FORMAT = "%Y-%m-%dT%H-%M-%S"
_RUN = re.compile(r"run-(\d{4,})" + re.escape(SUFFIX))
_UNFIT = re.compile(r'[<>:"/\\|?*\x00-\x1f]')
_RESERVED = re.compile(r"(con|prn|aux|nul|com\d|lpt\d)(\..*)?", re.IGNORECASE)
_LIBRARIES = ("numpy", "scipy", "h5py", "nidaqmx")


class Session:
    """A session on disk: `session.json` and run-0001.h5, run-0002.h5, ...

    Made by `create` or `open`.
    """

    def __init__(self, path: Path, info: SessionInfo) -> None:
        self._path = path
        self._info = info

    @classmethod
    def create(
        cls,
        parent: Path,
        setup: Setup,
        *,
        operator: str = "",
        notes: str = "",
        name: str | None = None,
        now: datetime,
    ) -> Session:
        """Make the folder and write its record, before anything is recorded.

        Parameters
        ----------
        parent
            Folder of sessions; made where it is not there.
        setup
            Settings and antenna calibration.
        operator, notes
            Who, and what is worth knowing.
        name
            Name of the folder; None: the date and time. Where it is taken, -2, -3, ... is added.
        now
            Date and time with offset from UTC.

        Raises
        ------
        SessionError
            The folder cannot be made or written, or the name cannot be one of a folder.
        """
        wanted = now.strftime(NAME_FORMAT) if name is None else _fit(name)
        folder = _new_folder(parent, wanted)
        created_at = (now if now.tzinfo else now.astimezone()).isoformat(timespec="seconds")
        info = SessionInfo(
            name=folder.name,
            created_at=created_at,
            operator=operator,
            notes=notes,
            versions=_versions(),
            setup=setup,
        )
        session = cls(folder, info)
        session._write(info)
        return session

    @classmethod
    def open(cls, path: Path) -> Session:
        """Return the session in a folder.

        Raises
        ------
        SessionError
            No session there, or its record is damaged.
        """
        return cls(path, read_info(path))

    @property
    def path(self) -> Path:
        """The folder."""
        return self._path

    @property
    def info(self) -> SessionInfo:
        """What session.json says."""
        return self._info

    @property
    def setup(self) -> Setup:
        """The setup the session was begun with."""
        return self._info.setup

    def update(self, *, operator: str | None = None, notes: str | None = None) -> None:
        """Change operator or notes; what is None stays.

        Raises
        ------
        SessionError
            The folder cannot be written.
        """
        given = {"operator": operator, "notes": notes}
        self._write(self._info.model_copy(update={key: text for key, text in given.items() if text is not None}))

    def new_run(
        self,
        digitisation: Digitisation,
        *,
        started_at: str,
        trigger_index: int | None = None,
        attributes: Mapping[str, str | float | int] | None = None,
    ) -> RunWriter:
        """Return the writer of a new run file with the next free number.

        Raises
        ------
        FileError
            The file cannot be made.
        """
        numbers = [int(match[1]) for path in self.run_paths() if (match := _RUN.fullmatch(path.name))]
        number = max(numbers, default=0)
        setup_toml = dump_setup(self.setup)
        while True:
            number += 1
            try:
                return RunWriter(
                    self._path / f"run-{number:04d}{SUFFIX}",
                    digitisation,
                    started_at=started_at,
                    trigger_index=trigger_index,
                    setup_toml=setup_toml,
                    attributes=attributes,
                )
            except RunExistsError:
                # Taken between looking and making, by another program recording into the same session.
                continue

    def run_paths(self) -> tuple[Path, ...]:
        """Return the run files in the order of their numbers."""
        return run_paths(self._path)

    def _write(self, info: SessionInfo) -> None:
        try:
            write_info(info, self._path)
        except OSError as error:
            raise SessionError(
                f"{self._path} cannot be written: {error.strerror or error}.",
                reasons=("the disk is full", "the folder belongs to somebody else"),
                remedy="Choose another data folder.",
            ) from None
        self._info = info


def run_paths(folder: Path) -> tuple[Path, ...]:
    """Return the run files in a folder in the order of their numbers."""
    try:
        found = [(int(match[1]), path) for path in folder.iterdir() if (match := _RUN.fullmatch(path.name))]
    except OSError:
        return ()
    return tuple(path for _, path in sorted(found))


def _new_folder(parent: Path, name: str) -> Path:
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
        raise SessionError(
            f"No session can be made in {parent}: {error.strerror or error}.",
            reasons=("the folder cannot be written", "part of the path is a file", "the disk is full"),
            remedy="Choose another data folder.",
        ) from None
    raise SessionError(f"{parent} holds too many sessions named {name}.", remedy="Choose another name.")


def _fit(name: str) -> str:
    if not name or name != name.strip() or name.endswith(".") or _UNFIT.search(name) or _RESERVED.fullmatch(name):
        raise SessionError(
            f"{name!r} cannot be the name of a session.",
            remedy='Use letters, digits, space, "-", "_" and "." inside.',
        )
    return name


def _versions() -> dict[str, str]:
    found = {"radargui": __version__, "python": platform.python_version(), "system": platform.platform()}
    for library in _LIBRARIES:
        try:
            found[library] = version(library)
        except PackageNotFoundError:
            continue
    return found
