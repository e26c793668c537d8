"""A disk on which a write fails: the files that are made on it are real ones, up to that write."""

from __future__ import annotations

import errno
import io
from pathlib import Path
from typing import Any

import pytest


class FailingDisk:
    """Lets one write of the files made since fail half done, and all after it.

    Attributes
    ----------
    left
        Writes that still succeed; None: all.
    """

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.left: int | None = None
        self.is_full = False
        real, disk = Path.open, self

        class DiskFile(io.FileIO):
            """A file on this disk."""

            def write(self, data: Any, /) -> int:
                if disk.left is None:
                    return super().write(data)
                if disk.left == 0 and not disk.is_full:
                    super().write(bytes(data)[: len(data) // 2])
                    # what is put back later finds its room
                    disk.is_full, disk.left = True, None
                    raise OSError(errno.ENOSPC, "No space left on device")
                disk.left -= 1
                return super().write(data)

        def opened(path: Path, mode: str = "r", *given: Any, **options: Any) -> Any:
            return DiskFile(path, "xb+") if mode == "xb+" else real(path, mode, *given, **options)

        monkeypatch.setattr(Path, "open", opened)
