"""A session: one folder with its record and its runs."""

from __future__ import annotations

import contextlib
import json
import re
import threading
import weakref
from collections.abc import Callable, Mapping
from datetime import datetime
from pathlib import Path
from typing import TypeVar, Unpack

from radargui.files.run_layout import SUFFIX, Header, fitted
from radargui.files.run_writer import RunExistsError, RunWriter
from radargui.model.errors import FileError, SessionError
from radargui.model.recording import Digitisation
from radargui.model.setup import Setup, dump_setup
from radargui.session.info import (
    CALIBRATION_NAME,
    FILE_NAME,
    JournalEntry,
    SessionDetails,
    SessionInfo,
    copied_calibration,
    new_folder,
    read_info,
    versions,
    write_info,
)
from radargui.session.lock import FILE_NAME as LOCK_NAME, SessionLock, SessionLockedError, SessionReadOnlyError

BY_OPERATOR = "rejected by the operator"
"""Why a drop does not count that was one, alone or with what was said of it; any other reason: it was none."""


def reason_of(said: str) -> str:
    """Return the reason that is kept of a drop that the operator rejects, with what he says of it."""
    return f"{BY_OPERATOR}: {said}" if said else BY_OPERATOR


def was_drop(reason: str) -> bool:
    """Return whether a run that was set aside for this reason was a drop, which keeps its number."""
    return reason == BY_OPERATOR or reason.startswith(f"{BY_OPERATOR}: ")


_LARGEST_FACT = 16_000
"""Bytes of a text that are kept in each run file too; an attribute holds at most 64 kB."""
_T = TypeVar("_T")
_RUN = re.compile(r"run-(\d{4,})" + re.escape(SUFFIX))


class Session:
    """A session on disk: `session.json` and run-0001.h5, run-0002.h5, ...

    Made by `create` or `open`. One program at a time writes to it; in a second one it is read-only.

    Attributes
    ----------
    path
        The folder.
    info
        What session.json says.
    """

    _changing = threading.RLock()

    def __init__(self, path: Path, info: SessionInfo, lock: SessionLock | SessionError) -> None:
        self.path = path
        self.info = info
        self._right = lock
        self._writer: weakref.ref[RunWriter] | None = None
        self._begun: Path | None = None

    @classmethod
    def create(
        cls, parent: Path, setup: Setup, *, name: str | None = None, now: datetime, **about: Unpack[SessionDetails]
    ) -> Session:
        """Make the folder and write its record, before anything is recorded.

        Parameters
        ----------
        parent
            Folder of sessions; made where it is not there.
        setup
            Settings and antenna calibration.
        name
            Name of the folder; None: the date and time. Where it is taken, -2, -3, ... is added.
        now
            Date and time with offset from UTC.
        about
            operator, sample, target, notes: who; what is measured; what it falls on; what else is worth knowing.
            calibration, setup_name: date and origin of the antenna calibration in the setup; name of its file, without
            folder and suffix.

        Raises
        ------
        SessionError
            The folder cannot be made or written, or the name cannot be one of a folder.
        """
        folder = new_folder(parent, name, now)
        try:
            lock = SessionLock(folder)
        except SessionError:
            # a full disk holds a folder, but not a file: nothing is left of it
            with contextlib.suppress(OSError):
                (folder / LOCK_NAME).unlink(missing_ok=True)
                folder.rmdir()
            raise
        created_at = (now if now.tzinfo else now.astimezone()).isoformat(timespec="seconds")
        info = SessionInfo(name=folder.name, created_at=created_at, versions=versions(), setup=setup)
        info = info.model_copy(update=_given(about))
        session = cls(folder, info, lock)
        try:
            session._write(info)
        except SessionError:
            session.discard_empty()
            raise
        if calibration := session._tried(lambda: copied_calibration(setup, folder)):
            session._write(info.model_copy(update={"calibration": calibration}))
        return session

    @classmethod
    def open(cls, path: Path, *, write: bool = True) -> Session:
        """Return the session in a folder.

        Parameters
        ----------
        path
            The folder.
        write
            Whether runs or changes are to come. Where another program writes to it, or the disk is read-only, it is
            opened all the same, for looking: `read_only` says why.

        Raises
        ------
        SessionError
            No session there, or its record is damaged.
        """
        info = read_info(path)
        if not write:
            return cls(path, info, SessionReadOnlyError(f"{path} was opened for looking only."))
        try:
            return cls(path, info, SessionLock(path))
        except (SessionLockedError, SessionReadOnlyError) as error:
            return cls(path, info, error)

    @property
    def read_only(self) -> str:
        """Why nothing can be written, for people; empty where it can."""
        return "" if isinstance(self._right, SessionLock) else str(self._right)

    def close(self) -> None:
        """Let other programs write to it; idempotent. What this one does later fails."""
        if isinstance(self._right, SessionLock):
            self._right.release()
            self._right = SessionReadOnlyError(f"{self.path} was closed.", remedy="Open it again.")

    def discard_empty(self) -> bool:
        """Close it and take its folder away where it holds nothing but its record; return whether it is gone.

        One that holds more stays open: a series goes on after a device that failed.
        """
        if not isinstance(self._right, SessionLock) or self.info.journal or run_paths(self.path):
            return False
        self.close()
        with contextlib.suppress(OSError):
            if {path.name for path in self.path.iterdir()} <= {FILE_NAME, CALIBRATION_NAME}:
                for name in (CALIBRATION_NAME, FILE_NAME):
                    (self.path / name).unlink(missing_ok=True)
                self.path.rmdir()
                return True
        return False

    @property
    def setup(self) -> Setup:
        """The setup the session was begun with."""
        return self.info.setup

    def update(self, **about: Unpack[SessionDetails]) -> None:
        """Change what the record says; what is None stays.

        Raises
        ------
        SessionError
            The folder cannot be written.
        """
        self._change(lambda _: _given(about))

    def mark(self, text: str, *, now: datetime, about: Path | None = None) -> JournalEntry:
        """Keep a note of this moment: in the journal, and as a marker in the run that is being recorded.

        Waits for the disk; not to be called from the thread that draws.

        Parameters
        ----------
        text, now
            The note; date and time.
        about
            The run that the note is about, and not the moment; None: the one that is being recorded.

        Raises
        ------
        SessionError
            The folder cannot be written.
        """
        self._want_right()
        run, index = "" if about is None else self._own(about), None
        if about is None and (writer := self._recorder()) is not None:
            # the run has ended just now, or its disk failed: the recorder tells
            with contextlib.suppress(FileError):
                run, index = writer.path.name, writer.mark(text)
        at = (now if now.tzinfo else now.astimezone()).isoformat(timespec="milliseconds")
        entry = JournalEntry(at=at, text=text, run=run, index=index)
        self._change(lambda info: {"journal": (*info.journal, entry)})
        return entry

    @property
    def recording(self) -> Path | None:
        """The run that is being recorded through this session; None between runs."""
        writer = self._recorder()
        return None if writer is None else writer.path

    def _recorder(self) -> RunWriter | None:
        writer = None if self._writer is None else self._writer()
        return None if writer is None or writer.closed else writer

    def records(self, run: Path) -> bool:
        """Return whether a run is being recorded through this session; true from before its file is there."""
        return run in (self._begun, self.recording)

    @property
    def rejected(self) -> Mapping[str, str]:
        """Runs that were set aside, by the name of the file, each with the reason."""
        return dict(self.info.rejected)

    def reject(self, run: Path, reason: str) -> None:
        """Set a run aside: it is kept, but hidden from lists, report and statistics, until `restore`.

        Raises
        ------
        SessionError
            No such run here, or the folder cannot be written.
        """
        name = self._own(run)
        self._change(lambda info: {"rejected": {**info.rejected, name: reason}})

    def restore(self, run: Path) -> None:
        """Take back that a run was set aside; idempotent.

        Raises
        ------
        SessionError
            No such run here, or the folder cannot be written.
        """
        name = self._own(run)
        self._change(lambda info: {"rejected": {key: why for key, why in info.rejected.items() if key != name}})

    def new_run(
        self, digitisation: Digitisation, make: Callable[..., RunWriter] = RunWriter, **header: Unpack[Header]
    ) -> RunWriter:
        """Return the writer of a new run file with the next free number; a folder that was taken away is made again.

        Parameters
        ----------
        digitisation
            How the samples are meant.
        make
            Makes the writer; raises RunExistsError where the file is there.
        header
            Facts of the run.

        Raises
        ------
        SessionError
            The session is read-only.
        FileError
            The file cannot be made.
        """
        self._want_right()
        if not self.path.is_dir():
            self._make_again()
        numbers = [int(match[1]) for path in run_paths(self.path) if (match := _RUN.fullmatch(path.name))]
        header["setup_toml"] = dump_setup(self.setup)
        header["attributes"] = {**self._facts(), **header.get("attributes", {})}
        number = max(numbers, default=0)
        while True:
            number += 1
            # said before it is there: who lists the runs meanwhile would find an empty file
            self._begun = self.path / f"run-{number:04d}{SUFFIX}"
            try:
                writer = make(self._begun, digitisation, **header)
                self._writer = weakref.ref(writer)
            except RunExistsError:
                # Taken between looking and making, by whoever does not heed the lock.
                continue
            finally:
                self._begun = None
            return writer

    def run_paths(self, *, with_rejected: bool = False) -> tuple[Path, ...]:
        """Return the run files in the order of their numbers, those that were set aside only where asked for."""
        hidden = {} if with_rejected else self.info.rejected
        return tuple(path for path in run_paths(self.path) if path.name not in hidden)

    def _facts(self) -> dict[str, str]:
        """Return what each run file says about its session, so that it can be understood alone."""
        info = self.info
        facts = {
            "session": info.name,
            **info.model_dump(include={"operator", "sample", "target", "notes"}),
            "calibration": info.calibration.model_dump_json(),
            "versions": json.dumps(info.versions, ensure_ascii=False),
        }
        return {key: fitted(text, _LARGEST_FACT).decode("utf-8") for key, text in facts.items()}

    def _want_right(self) -> None:
        right = self._right
        if not isinstance(right, SessionLock):
            raise type(right)(right.message, reasons=right.reasons, remedy=right.remedy)

    def _make_again(self) -> None:
        # a failure is reported in the words of what needs the folder
        with contextlib.suppress(OSError):
            self.path.mkdir(parents=True, exist_ok=True)
            self._write(self.info)

    def _own(self, run: Path) -> str:
        if run.name not in {path.name for path in run_paths(self.path)}:
            raise SessionError(f"{self.path} holds no run {run.name}.")
        return run.name

    def _change(self, change: Callable[[SessionInfo], dict[str, object]]) -> None:
        """Change the record as it is on the disk now: another part of this program may have changed it."""
        self._want_right()
        with self._changing:
            info = read_info(self.path)
            self._write(info.model_copy(update=change(info)))

    def _write(self, info: SessionInfo) -> None:
        self._tried(lambda: write_info(info, self.path))
        self.info = info

    def _tried(self, step: Callable[[], _T]) -> _T:
        try:
            return step()
        except FileError as error:
            raise SessionError(error.message, reasons=error.reasons, remedy="Choose another data folder.") from None


def is_run_name(name: str) -> bool:
    """Return whether a file of that name is a run."""
    return _RUN.fullmatch(name) is not None


def run_paths(folder: Path) -> tuple[Path, ...]:
    """Return all run files in a folder in the order of their numbers."""
    with contextlib.suppress(OSError):
        found = [(int(match[1]), path) for path in folder.iterdir() if (match := _RUN.fullmatch(path.name))]
        return tuple(path for _, path in sorted(found))
    return ()


def _given(about: SessionDetails) -> dict[str, object]:
    return {key: value for key, value in about.items() if value is not None}
