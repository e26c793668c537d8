"""Plots of each receiver that are made when they are first looked at: plots are what a new window waits for."""

from PySide6.QtGui import QShowEvent
from PySide6.QtWidgets import QWidget


class PerReceiver(QWidget):
    """A widget whose plots depend on how many receivers there are; what inherits from it makes them."""

    def __init__(self) -> None:
        super().__init__()
        self._count = self._made = 0

    def set_receivers(self, count: int) -> None:
        """Show so many receivers."""
        self._count = count
        if self.isVisible():
            self._make()

    def showEvent(self, event: QShowEvent) -> None:  # noqa: N802 - Qt's name
        """Make what is still missing."""
        super().showEvent(event)
        self._make()

    def make_plots(self, count: int) -> None:
        """Replace the plots there are by those of so many receivers."""
        raise NotImplementedError

    def _make(self) -> None:
        if self._made != self._count:
            self._made = self._count
            self.make_plots(self._count)
