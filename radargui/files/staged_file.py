"""A staged file: HDF5 writes into memory, and whole states of the file go to the disk.

HDF5 does not survive a disk that fills up: the file it was writing cannot be opened again and the process crashes when
its handles are let go. Here the library never meets an error. What it wrote since the last commit is put on the disk in
one go: first what lies behind the end of the file, which may fail for want of room and then is cut off again, and only
then the few places within it that change.
"""

import io
import os
from contextlib import suppress
from pathlib import Path
from typing import Any

_LARGEST_STAGE = 16_000_000
"""Bytes held in memory by a file that commits by itself. Chosen by hand."""


class TakenAwayError(OSError):
    """Somebody deleted, replaced or cut the file while it was open."""


class StagedFile(io.RawIOBase):
    """A binary file for `h5py.File`, made anew.

    Parameters
    ----------
    path
        File to make; kept as an attribute.
    automatic
        Commit by itself whenever much is staged: for files that nobody reads before they are whole.

    Raises
    ------
    OSError
        The file cannot be made; FileExistsError where it is there.
    """

    def __init__(self, path: Path, *, automatic: bool = False) -> None:
        super().__init__()
        self.path = path
        self._file = path.open("xb+", buffering=0)
        self._automatic = automatic
        self._staged: list[tuple[int, bytes]] = []
        self._n_staged = 0
        self._place = 0
        self._size = 0
        self._on_disk = 0
        # Bytes of the disk's content that still count: less than are there once the file was cut and grew again.
        self._counting = 0
        self._error: OSError | None = None

    def commit(self) -> None:
        """Put everything staged on the disk.

        Raises
        ------
        OSError
            The disk is full or failed; then the file is as it was after the commit before, and stays so.
        TakenAwayError
            The file is not there any more, or shorter than it was.
        """
        if self._error is not None:
            raise self._error
        self._want_in_place()
        before: list[tuple[int, bytes]] = []
        try:
            if self._size > self._on_disk:
                self._put(self._on_disk, self._held(self._on_disk, self._size - self._on_disk))
            for place, data in self._changes():
                before.append((place, self._on_disk_bytes(place, len(data))))
                self._put(place, data)
            if self._size < self._on_disk:
                self._file.truncate(self._size)
        except OSError as error:
            self._error = error
            self._take_back(before)
            raise
        self._on_disk = self._counting = self._size
        self._staged, self._n_staged = [], 0

    def sync(self) -> None:
        """Make sure that what was committed is on the disk itself.

        Raises
        ------
        OSError
            The disk failed.
        """
        os.fsync(self._file.fileno())

    def close(self) -> None:
        """Close without a commit; idempotent."""
        self._file.close()
        super().close()

    def write(self, data: Any) -> int:
        """Stage bytes at the present place."""
        taken = bytes(data)
        self._staged.append((self._place, taken))
        self._n_staged += len(taken)
        self._place += len(taken)
        self._size = max(self._size, self._place)
        if self._automatic and self._n_staged > _LARGEST_STAGE and self._error is None:
            # the error is kept: the commit at the end raises it again
            with suppress(OSError):
                self.commit()
        return len(taken)

    def readinto(self, buffer: Any) -> int:
        """Read what is staged over what is on the disk; bytes never written are 0."""
        view = memoryview(buffer).cast("B")
        first, count = self._place, max(min(len(view), self._size - self._place), 0)
        view[:count] = self._held(first, count)
        self._place += count
        return count

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        """Go to a place."""
        start = {os.SEEK_SET: 0, os.SEEK_CUR: self._place, os.SEEK_END: self._size}[whence]
        self._place = start + offset
        return self._place

    def truncate(self, size: int | None = None) -> int:
        """Set the size, as of the next commit."""
        self._size = self._place if size is None else size
        self._counting = min(self._counting, self._size)
        self._staged = [(place, data[: self._size - place]) for place, data in self._staged if place < self._size]
        return self._size

    def flush(self) -> None:
        """Do nothing: `commit` is called from outside, where an error may be raised."""

    def _held(self, first: int, count: int) -> bytes:
        held = bytearray(count)
        if first < self._counting:
            found = self._on_disk_bytes(first, min(count, self._counting - first))
            held[: len(found)] = found
        for place, data in self._staged:
            low, high = max(place, first), min(place + len(data), first + count)
            if low < high:
                held[low - first : high - first] = data[low - place : high - place]
        return bytes(held)

    def _want_in_place(self) -> None:
        """Make sure that what is written can be found again: an open file takes writes also when it was deleted."""
        here = os.fstat(self._file.fileno())
        try:
            there = self.path.stat()
        except OSError:
            self._error = TakenAwayError("was deleted or moved")
            raise self._error from None
        if not os.path.samestat(here, there):
            self._error = TakenAwayError("was replaced by another file")
        elif here.st_size < self._on_disk:
            self._error = TakenAwayError("was cut off")
        if self._error is not None:
            raise self._error

    def _changes(self) -> list[tuple[int, bytes]]:
        """Return what is to be written within the present end of the file on the disk, from its start on.

        The first thing in an HDF5 file is how far it reaches: a crash between two of these writes then leaves
        references to what is there already.
        """
        end = min(self._on_disk, self._size)
        spans = [(place, min(place + len(data), end)) for place, data in self._staged if place < end]
        spans += [(self._counting, end)] if self._counting < end else []
        joined: list[tuple[int, int]] = []
        for first, last in sorted(spans):
            if joined and first <= joined[-1][1]:
                first, last = joined[-1][0], max(joined.pop()[1], last)
            joined.append((first, last))
        return [(first, self._held(first, last - first)) for first, last in joined]

    def _on_disk_bytes(self, place: int, count: int) -> bytes:
        self._file.seek(place)
        return self._file.read(count) or b""

    def _put(self, place: int, data: bytes) -> None:
        view = memoryview(data)
        self._file.seek(place)
        while len(view):
            view = view[self._file.write(view) or 0 :]

    def _take_back(self, before: list[tuple[int, bytes]]) -> None:
        with suppress(OSError):
            for place, data in reversed(before):
                self._put(place, data)
            self._file.truncate(self._on_disk)
