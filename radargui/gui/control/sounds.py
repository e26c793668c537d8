"""Short sounds: the operator stands at the tracer and does not look."""

from __future__ import annotations

from PySide6.QtCore import QObject, QTimer
from PySide6.QtWidgets import QApplication

_BETWEEN_MS = 220


class Sounds(QObject):
    """The system's own sound: once for a run that is done, twice for one that was rejected."""

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.on = True

    def done(self) -> None:
        """Tell that a run is done."""
        if self.on:
            QApplication.beep()

    def rejected(self) -> None:
        """Tell that a run was rejected or set aside."""
        if self.on:
            QApplication.beep()
            QTimer.singleShot(_BETWEEN_MS, self, QApplication.beep)
