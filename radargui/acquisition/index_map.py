"""From the count of samples pushed into a processor to absolute indices, lost samples counted."""

from __future__ import annotations

from collections import deque

import numpy as np

from radargui.model.arrays import IntArray

_BREAKS_KEPT = 64


class IndexMap:
    """Remembers where samples were missing between those pushed."""

    def __init__(self) -> None:
        self._pushed = 0
        self._breaks: deque[tuple[int, int]] = deque(maxlen=_BREAKS_KEPT)

    @property
    def pushed(self) -> int:
        """Samples pushed so far."""
        return self._pushed

    def push(self, first_index: int, count: int) -> None:
        """Tell that samples first_index : first_index + count were pushed."""
        offset = first_index - self._pushed
        if not self._breaks or self._breaks[-1][1] != offset:
            self._breaks.append((self._pushed, offset))
        self._pushed += count

    def absolute(self, pushed_index: int) -> int:
        """Return the absolute index of a sample by its count of pushed samples."""
        return int(self.absolutes(np.array([pushed_index]))[0])

    def absolutes(self, pushed_index: IntArray) -> IntArray:
        """Return absolute indices, shape as given."""
        if not self._breaks:
            return np.asarray(pushed_index)
        starts = np.array([start for start, _ in self._breaks])
        offsets = np.array([offset for _, offset in self._breaks])
        piece = np.maximum(np.searchsorted(starts, pushed_index, side="right") - 1, 0)
        return np.asarray(pushed_index + offsets[piece], dtype=np.intp)
