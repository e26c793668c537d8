"""The lock of a session folder: one program writes, others read.

`session.lock` names its owner: computer, process, time. The owner also holds the system's lock on it, which ends with
the process, also after a crash or a kill. A file left behind by a dead process of this computer is taken over; one left
behind by another computer is not, for it cannot be told from here whether its owner lives.
"""

from __future__ import annotations

import contextlib
import json
import os
import platform
import threading
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from radargui.model.errors import SessionError
from radargui.session.file_lock import try_lock
from radargui.session.process_life import is_running

FILE_NAME = "session.lock"
_MAXIMUM_BYTES = 10_000
_TRIES = 50
_PAUSE_S = 0.01
_guard = threading.RLock()
"""Taken again where the collector comes in between."""
_held: dict[str, _Held] = {}


class SessionLockedError(SessionError):
    """Another program writes to the session."""


class SessionReadOnlyError(SessionError):
    """The folder of the session cannot be written."""


@dataclass(slots=True)
class _Held:
    """A lock of this process, shared by all that work on the folder."""

    descriptor: int
    path: Path
    n_users: int


@dataclass(frozen=True, slots=True)
class Owner:
    """Who holds, or held, a lock."""

    computer: str
    process: int
    since: str

    def __str__(self) -> str:
        where = "this computer" if self.is_here else self.computer
        return f"process {self.process} on {where} since {self.since}"

    @property
    def is_here(self) -> bool:
        """Whether it is a process of this computer."""
        return self.computer == platform.node()


class SessionLock:
    """The right to write to a session folder; let go by `release`, when collected, or when the process ends.

    Several of one process share it.

    Parameters
    ----------
    folder
        The session.

    Raises
    ------
    SessionLockedError
        Another program has it.
    SessionReadOnlyError
        The folder cannot be written.
    """

    def __init__(self, folder: Path) -> None:
        self._key: str | None = None
        key = _key(folder)
        with _guard:
            held = _held.get(key)
            if held is None:
                _held[key] = _taken(folder)
            else:
                held.n_users += 1
            self._key = key

    def release(self) -> None:
        """Let go; idempotent."""
        with _guard:
            key, self._key = self._key, None
            held = None if key is None else _held.get(key)
            if key is None or held is None:
                return
            held.n_users -= 1
            if held.n_users:
                return
            _let_go(_held.pop(key))

    def __del__(self) -> None:
        """Let go of what nobody uses any more."""
        if getattr(self, "_key", None) is not None:
            self.release()


def owner_of(folder: Path) -> Owner | None:
    """Return who writes to a session now; None where nobody does."""
    path = folder / FILE_NAME
    if _key(folder) in _held:
        return _read(path)
    try:
        descriptor = os.open(path, os.O_RDWR)
    except OSError:
        # not there, or on a read-only disk, where nobody writes
        return None
    try:
        owner, locked = _read(path), try_lock(descriptor)
        if locked is False:
            return owner or Owner("an unknown computer", 0, "an unknown time")
        return owner if owner is not None and _may_live(owner, locks_work=bool(locked)) else None
    finally:
        os.close(descriptor)


def _key(folder: Path) -> str:
    return os.path.normcase(os.path.realpath(folder))


def _taken(folder: Path) -> _Held:
    path = folder / FILE_NAME
    for _ in range(_TRIES):
        descriptor = _opened(path)
        locked = try_lock(descriptor)
        owner = _read(path)
        if locked is False and (owner is None or (owner.is_here and not is_running(owner.process))):
            # held only for the moment of a look, or let go just now
            os.close(descriptor)
            threading.Event().wait(_PAUSE_S)
            continue
        if locked is False or (owner is not None and _may_live(owner, locks_work=bool(locked))):
            os.close(descriptor)
            raise _refused(folder, owner)
        if not _is_still_there(descriptor, path):
            # its owner let go, and took the file away, between opening and locking
            os.close(descriptor)
            continue
        try:
            _sign(descriptor)
        except OSError as error:
            os.close(descriptor)
            raise _unwritable(path, error) from None
        return _Held(descriptor, path, 1)
    raise _refused(folder, _read(path))


def _opened(path: Path) -> int:
    try:
        return os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
    except OSError as error:
        raise _unwritable(path, error) from None


def _unwritable(path: Path, error: OSError) -> SessionReadOnlyError:
    return SessionReadOnlyError(
        f"{path.parent} cannot be written: {error.strerror or error}.",
        reasons=("it is on a read-only disk", "it belongs to somebody else", "the disk is full"),
        remedy="It can be looked at; copy it to another folder to add to it.",
    )


def _may_live(owner: Owner, *, locks_work: bool) -> bool:
    """Whether the owner named in a file that nobody seems to lock may be alive all the same."""
    if not owner.is_here:
        return True
    return not locks_work and owner.process != os.getpid() and is_running(owner.process)


def _sign(descriptor: int) -> None:
    text = json.dumps(
        {
            "computer": platform.node(),
            "process": os.getpid(),
            "since": datetime.now(UTC).astimezone().isoformat(timespec="seconds"),
        }
    )
    os.ftruncate(descriptor, 0)
    os.lseek(descriptor, 0, os.SEEK_SET)
    os.write(descriptor, text.encode("utf-8"))


def _read(path: Path) -> Owner | None:
    try:
        with path.open("rb") as file:
            content = json.loads(file.read(_MAXIMUM_BYTES))
        return Owner(str(content["computer"]), int(content["process"]), str(content["since"]))
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return None


def _is_still_there(descriptor: int, path: Path) -> bool:
    try:
        return os.path.samestat(os.fstat(descriptor), path.stat())
    except OSError:
        return False


def _let_go(held: _Held) -> None:
    with contextlib.suppress(OSError):
        os.ftruncate(held.descriptor, 0)
    # Where open files can be taken away it comes first: whoever opened it meanwhile sees that it is gone.
    with contextlib.suppress(OSError):
        held.path.unlink()
    with contextlib.suppress(OSError):
        os.close(held.descriptor)
    if os.name == "nt":
        with contextlib.suppress(OSError):
            held.path.unlink()


def _refused(folder: Path, owner: Owner | None) -> SessionLockedError:
    remedy = "It is opened for looking only; close it there to add to it."
    if owner is not None and not owner.is_here:
        remedy += f" If that program is gone, delete {FILE_NAME} in the folder."
    return SessionLockedError(
        f"{folder} is being written by another program ({owner or 'unknown'}).",
        reasons=("a second window has it open", "it is recording"),
        remedy=remedy,
    )
