"""Garbage is collected at a safe moment of the window's thread, and never anywhere else."""

from __future__ import annotations

import gc

from PySide6.QtCore import QObject, QTimer

LOOK_MS = 500


class GarbageKeeper(QObject):
    """Turns Python's own collection off for good and collects by a timer instead.

    Left to itself the collector runs wherever memory happens to be taken: in a worker, where it would free objects of
    Qt in the wrong thread, or inside Qt while it frees an object under one of its locks (PySide looks for an overridden
    `disconnectNotify` there), where freeing another object waits for that lock for ever. Both were seen.
    """

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        gc.disable()
        self._thresholds = gc.get_threshold()
        self._timer = QTimer(self)
        self._timer.setInterval(LOOK_MS)
        self._timer.timeout.connect(self.look)
        self._timer.start()

    def look(self) -> None:
        """Collect the generations that are due, by Python's own thresholds."""
        counts = gc.get_count()
        if counts[0] <= self._thresholds[0]:
            return
        generation = 0
        for older in (1, 2):
            if counts[older] <= self._thresholds[older]:
                break
            generation = older
        gc.collect(generation)
