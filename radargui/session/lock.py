"""The lock of a session folder: one program writes, others read.

`session.lock` is held by the system's lock (`filelock`), which ends with the process, also after a crash or a kill, and
names its owner: computer, process, time. A file left behind by a dead process of this computer is taken over; one left
behind by another computer is not, for nobody can know from here whether its owner lives. Where the file system knows no
locks, a marker file beside it is the lock, which counts while the process that it names runs.
"""

import contextlib
import errno
import json
import os
import platform
import threading
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from filelock import BaseFileLock, FileLock, SoftFileLock, Timeout

from radargui.model.errors import SessionError, worded

FILE_NAME = "session.lock"
_MARKER_NAME = "session.lock.held"
_MAXIMUM_BYTES = 10_000  # read of it: its owner is told in some hundred (chosen by hand)
_PATIENCE_S = 0.1
"""A program that only looks holds the lock for some microseconds: chosen by hand, a thousand times as long."""
_NO_LOCKS = {errno.ENOSYS, errno.EOPNOTSUPP, errno.ENOTSUP, errno.ENOLCK}
_guard = threading.RLock()
"""Taken again where the collector comes in between."""


class SessionLockedError(SessionError):
    """Another program writes to the session."""


class SessionReadOnlyError(SessionError):
    """The folder of the session cannot be written."""


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
    def is_me(self) -> bool:
        """Whether it is this program."""
        return self.is_here and self.process == os.getpid()

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
        self._lock: BaseFileLock | None = None
        self._path = folder / FILE_NAME
        with _guard:
            lock = _acquired(folder, _PATIENCE_S)
            if lock.lock_counter == 1:
                try:
                    _sign(self._path)
                except (OSError, SessionLockedError) as error:
                    lock.release()
                    raise _unwritable(self._path, error) if isinstance(error, OSError) else error from None
            self._lock = lock

    def release(self) -> None:
        """Let go; idempotent."""
        with _guard:
            lock, self._lock = self._lock, None
            if lock is None:
                return
            is_last = lock.lock_counter == 1
            # Where open files can be taken away this comes first: whoever opened it meanwhile sees that it is gone.
            if is_last:
                _remove(self._path)
            lock.release()
            if is_last and os.name == "nt":
                _remove(self._path)

    def __del__(self) -> None:
        """Let go of what nobody uses any more."""
        if getattr(self, "_lock", None) is not None:
            self.release()


def owner_of(folder: Path) -> Owner | None:
    """Return who writes to a session now; None where nobody does."""
    path = folder / FILE_NAME
    if not path.exists():
        return None
    owner = _read(path)
    try:
        with _guard:
            lock = _acquired(folder, 0.0)
            is_mine = lock.lock_counter > 1
            lock.release()
    except SessionLockedError:
        return owner or Owner("an unknown computer", 0, "an unknown time")
    except SessionReadOnlyError:
        # nobody writes on a read-only disk
        return None
    return owner if owner is not None and (is_mine or not owner.is_here) else None


def _acquired(folder: Path, patience_s: float) -> BaseFileLock:
    """Return the lock of a folder, held once more by this process, whose parts all get the same object."""
    path = os.path.realpath(folder / FILE_NAME)
    native = FileLock(path, thread_local=False, is_singleton=True, fallback_to_soft=False)
    marker = SoftFileLock(
        os.path.realpath(folder / _MARKER_NAME), thread_local=False, is_singleton=True, fallback_to_soft=False
    )
    try:
        try:
            native.acquire(patience_s, poll_interval=0.01)
        except OSError as error:
            if error.errno not in _NO_LOCKS:
                raise
            marker.acquire(patience_s, poll_interval=0.01)
            return marker
    except Timeout:
        raise _refused(folder, _read(folder / FILE_NAME)) from None
    except OSError as error:
        raise _unwritable(folder / FILE_NAME, error) from None
    return native


def _sign(path: Path) -> None:
    owner = _read(path)
    if owner is not None and not owner.is_here:
        raise _refused(path.parent, owner)
    now = datetime.now(UTC).astimezone().isoformat(timespec="seconds")
    text = json.dumps({"computer": platform.node(), "process": os.getpid(), "since": now})
    path.touch()
    with path.open("r+b", buffering=0) as file:
        # Windows locks the first byte, also against reading: the text begins behind it
        file.seek(1)
        file.write(text.encode())
        file.truncate()


def _read(path: Path) -> Owner | None:
    with contextlib.suppress(OSError, ValueError, KeyError, TypeError, RecursionError):
        with path.open("rb", buffering=0) as file:
            file.seek(1)
            # 0.1 began with the first byte
            content = json.loads(b"{" + file.read(_MAXIMUM_BYTES).lstrip(b"{"))
        return Owner(str(content["computer"]), int(content["process"]), str(content["since"]))
    return None


def _remove(path: Path) -> None:
    with contextlib.suppress(OSError):
        path.unlink()


def _unwritable(path: Path, error: OSError) -> SessionReadOnlyError:
    return worded(SessionReadOnlyError, "read_only", folder=path.parent, why=error.strerror or error)


def _refused(folder: Path, owner: Owner | None) -> SessionLockedError:
    remedy = "It is opened for looking only; close it there to add to it."
    if owner is not None and not owner.is_here:
        remedy += f" If that program is gone, delete {FILE_NAME} in the folder."
    return worded(SessionLockedError, "session_locked", folder=folder, owner=owner or "unknown", remedy=remedy)
