"""The dockable panels: their names, where they stand at first, and how the layout is kept."""

from __future__ import annotations

from PySide6.QtCore import QByteArray, Qt
from PySide6.QtGui import QKeySequence
from PySide6.QtWidgets import QDockWidget, QMainWindow, QMenu, QTabWidget, QWidget

from radargui.gui.settings import LAYOUT_VERSION

TITLES = {
    "hardware": "Hardware setup",
    "antennas": "Antenna calibration",
    "session": "Session",
    "scopes": "IQ scopes",
    "planes": "IQ plane",
    "track": "Track",
    "runs": "Runs",
    "run": "Run",
}
"""Kept names and the words shown; a name must never change, layouts are remembered by it."""


_FORMS = ("hardware", "antennas", "session")
_WIDEST_FORM = 520


class Panels(QMainWindow):
    """Holds one dock a panel; sits inside the window so that state, messages and health stay where they are."""

    def __init__(self, widgets: dict[str, QWidget]) -> None:
        super().__init__(None, Qt.WindowType.Widget)
        self.setDockNestingEnabled(True)
        self.setTabPosition(Qt.DockWidgetArea.AllDockWidgetAreas, QTabWidget.TabPosition.North)
        self.docks: dict[str, QDockWidget] = {}
        for name, title in TITLES.items():
            dock = QDockWidget(title)
            dock.setObjectName(name)
            dock.setWidget(widgets[name])
            if name in _FORMS:
                dock.setMaximumWidth(_WIDEST_FORM)
            dock.toggleViewAction().setShortcut(QKeySequence(f"Alt+{len(self.docks) + 1}"))
            self.docks[name] = dock
            self.addDockWidget(Qt.DockWidgetArea.LeftDockWidgetArea, dock)
        self.reset()

    def reset(self) -> None:
        """Put every panel where it stood at first."""
        docks = self.docks
        for dock in docks.values():
            dock.setFloating(False)
            self.removeDockWidget(dock)
        self.addDockWidget(Qt.DockWidgetArea.LeftDockWidgetArea, docks["hardware"])
        across, down = Qt.Orientation.Horizontal, Qt.Orientation.Vertical
        self.splitDockWidget(docks["hardware"], docks["scopes"], across)
        self.splitDockWidget(docks["scopes"], docks["runs"], down)
        self.splitDockWidget(docks["scopes"], docks["track"], across)
        self.splitDockWidget(docks["runs"], docks["planes"], across)
        self.tabifyDockWidget(docks["hardware"], docks["antennas"])
        self.tabifyDockWidget(docks["antennas"], docks["session"])
        self.tabifyDockWidget(docks["scopes"], docks["run"])
        for dock in docks.values():
            dock.show()
        for name in ("hardware", "scopes"):
            docks[name].raise_()
        width, height = max(self.width(), 1200), max(self.height(), 700)
        side = min(360, width // 4)
        rest = width - side
        self.resizeDocks([docks["hardware"], docks["scopes"], docks["track"]], [side, rest // 2, rest // 2], across)
        self.resizeDocks([docks["runs"], docks["planes"]], [57 * rest // 100, 43 * rest // 100], across)
        low = min(280, height // 3)
        self.resizeDocks([docks["scopes"], docks["runs"]], [height - low, low], down)

    def fill(self, menu: QMenu) -> None:
        """Add the switches of all panels to a menu."""
        for dock in self.docks.values():
            menu.addAction(dock.toggleViewAction())

    def bring_up(self, name: str) -> None:
        """Show a panel in front, unless the operator closed it."""
        dock = self.docks[name]
        if not dock.isHidden() or self.tabifiedDockWidgets(dock):
            dock.raise_()

    def keep(self) -> QByteArray:
        """Return the layout to be remembered."""
        return self.saveState(LAYOUT_VERSION)

    def restore(self, layout: QByteArray) -> bool:
        """Take a remembered layout; False, and the first layout, where it cannot be used."""
        if not layout.isEmpty() and self.restoreState(layout, LAYOUT_VERSION):
            return True
        self.reset()
        return False
