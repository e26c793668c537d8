"""A file for parsers that believe sizes in headers: it never makes room for more than it holds."""

from __future__ import annotations

import io
from pathlib import Path


class BoundedFile(io.BufferedReader):
    """A file opened for reading whose `read` allocates what is left in it at most.

    Python makes room for all that is asked for before it reads; a damaged size of four gigabytes would fill memory.

    Parameters
    ----------
    path
        File to open.
    """

    def __init__(self, path: Path) -> None:
        super().__init__(io.FileIO(path, "r"))
        self._size = path.stat().st_size

    def read(self, size: int | None = -1, /) -> bytes:
        """Return the next bytes, at most `size`; all that is left where it is negative or None."""
        left = max(self._size - self.tell(), 0)
        return super().read(left if size is None or size < 0 else min(size, left))
