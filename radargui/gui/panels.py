"""The dockable panels: their names, where they stand at first, and how the layout is kept."""

from functools import partial

from PySide6.QtCore import QByteArray, QSize, Qt
from PySide6.QtGui import QKeySequence, QPainter, QPaintEvent, QPalette
from PySide6.QtWidgets import (
    QApplication,
    QDockWidget,
    QFocusFrame,
    QFrame,
    QMainWindow,
    QMenu,
    QScrollArea,
    QTabBar,
    QTabWidget,
    QWidget,
)

from radargui.gui.layout import fit_screen
from radargui.gui.settings import LAYOUT_VERSION, Settings

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
"""Lines of numbers do not get better by being wider; what is left belongs to the plots."""
_LEAST_ROOM = QSize(230, 116)
"""Of a panel: three beside each other and two above each other fit 960 x 540 (1920 x 1080 at scale 2)."""
_NARROW = 1100
"""Of a window: below it three panels beside each other are too small for plots, and one stands behind another."""
_FIRST_SIZE = (1440, 900)
"""Of the window at the first start where the screen has room: two plots of 500 pixels beside the forms."""


def belongs(widget: QWidget, window: QWidget) -> bool:
    """Return whether a widget stands in a window or in a panel that was torn off it."""
    return widget.window() is window or isinstance(widget.window(), QDockWidget)


class FocusMark(QFocusFrame):
    """Follows the keys through a window, and stays away where they have left it."""

    def __init__(self, window: QWidget, application: QApplication) -> None:
        super().__init__(window)
        self._window = window
        self.hide()
        application.focusChanged.connect(self._follow)

    def paintEvent(self, _event: QPaintEvent) -> None:  # noqa: N802 - Qt's name
        """Draw the frame; Qt lets through only its edge."""
        painter = QPainter(self)
        painter.fillRect(self.rect(), self.palette().color(QPalette.ColorRole.Highlight))
        painter.end()

    def _follow(self, _old: QWidget | None, now: QWidget | None) -> None:
        self.setWidget(now if now is not None and belongs(now, self._window) else None)  # type: ignore[arg-type]


class Room(QScrollArea):
    """What a dock holds: scrolls where the screen is too small for it, so that it never makes the window larger."""

    def __init__(self, panel: QWidget) -> None:
        super().__init__()
        self._panel = panel
        self.setWidget(panel)
        self.setWidgetResizable(True)
        self.setFrameShape(QFrame.Shape.NoFrame)
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        policy = self.sizePolicy()
        policy.setRetainSizeWhenHidden(True)
        self.setSizePolicy(policy)

    def minimumSizeHint(self) -> QSize:  # noqa: N802 - Qt's name
        """Return the size below which nothing can be read in it."""
        return self._panel.minimumSizeHint().boundedTo(_LEAST_ROOM)

    def sizeHint(self) -> QSize:  # noqa: N802 - Qt's name
        """Return what the panel wants."""
        return self._panel.sizeHint()


class Panels(QMainWindow):
    """Holds one dock a panel; sits inside the window so that state, messages and health stay where they are.

    Qt keeps a dock that stands behind another "visible", away from the screen, where Tab and keys reach its fields:
    what such a dock holds is hidden here, and keeps its room. The panels come in the order of `TITLES`.
    """

    def __init__(self, *widgets: QWidget) -> None:
        super().__init__(None, Qt.WindowType.Widget)
        self.setDockNestingEnabled(True)
        self.setTabPosition(Qt.DockWidgetArea.AllDockWidgetAreas, QTabWidget.TabPosition.North)
        self.docks: dict[str, QDockWidget] = {}
        self._panels = dict(zip(TITLES, widgets, strict=True))
        for name, title in TITLES.items():
            dock = QDockWidget(title)
            dock.setObjectName(name)
            dock.setWidget(Room(self._panels[name]))
            dock.visibilityChanged.connect(partial(self._show_content, dock))
            if name in _FORMS:
                dock.setMaximumWidth(_WIDEST_FORM)
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
        narrow = self.width() < _NARROW
        if narrow:
            self.tabifyDockWidget(docks["scopes"], docks["planes"])
        else:
            self.splitDockWidget(docks["runs"], docks["planes"], across)
        self.tabifyDockWidget(docks["hardware"], docks["antennas"])
        self.tabifyDockWidget(docks["antennas"], docks["session"])
        self.tabifyDockWidget(docks["scopes"], docks["run"])
        for dock in docks.values():
            dock.show()
        for name in ("hardware", "scopes"):
            docks[name].raise_()
        width, height = self.width(), self.height()
        side = min(400, max(28 * width // 100, self._panels["antennas"].minimumSizeHint().width() + 6))
        rest = width - side
        self.resizeDocks([docks["hardware"], docks["scopes"], docks["track"]], [side, rest // 2, rest // 2], across)
        if not narrow:
            self.resizeDocks([docks["runs"], docks["planes"]], [68 * rest // 100, 32 * rest // 100], across)
        low = min(280, 3 * height // 8)
        self.resizeDocks([docks["scopes"], docks["runs"]], [height - low, low], down)

    def fill(self, menu: QMenu) -> None:
        """Add one action a panel to a menu, which shows it in front whatever it was before."""
        for number, (name, title) in enumerate(TITLES.items(), start=1):
            action = menu.addAction(title)
            action.setShortcut(QKeySequence(f"Alt+{number}"))
            action.triggered.connect(partial(self.go_to, name))

    def go_to(self, name: str) -> None:
        """Show a panel in front, also one that was closed, and let the keys go to its first field."""
        dock = self.docks[name]
        dock.show()
        dock.raise_()
        dock.activateWindow()
        self._show_content(dock, True)
        fields = (one for one in dock.widget().findChildren(QWidget) if one.isVisible() and one.isEnabled())
        takes_tab = Qt.FocusPolicy.TabFocus
        first = next((one for one in fields if one.focusPolicy() & takes_tab and one.focusProxy() is None), None)
        if first is not None:
            first.setFocus(Qt.FocusReason.ShortcutFocusReason)

    def bring_up(self, name: str) -> None:
        """Show a panel in front, unless the operator closed it."""
        dock = self.docks[name]
        if not dock.isHidden() or self.tabifiedDockWidgets(dock):
            dock.raise_()

    def _show_content(self, dock: QDockWidget, visible: bool) -> None:
        dock.widget().setVisible(visible)
        for tabs in self.findChildren(QTabBar, options=Qt.FindChildOption.FindDirectChildrenOnly):
            # the panels have keys of their own; Qt keeps bars of former layouts, which Tab would enter unseen
            tabs.setFocusPolicy(Qt.FocusPolicy.NoFocus)

    def keep(self) -> QByteArray:
        """Return the layout to be remembered."""
        return self.saveState(LAYOUT_VERSION)

    def restore_within(self, window: QMainWindow, settings: Settings) -> None:
        """Take size and layout of the last time, where that cannot be used one that fits the screen."""
        geometry, layout = settings.blob("geometry"), settings.blob("layout")
        if geometry.isEmpty() or not window.restoreGeometry(geometry):
            fit_screen(window, *_FIRST_SIZE)
        self.resize(window.size())
        if layout.isEmpty() or not self.restoreState(layout, LAYOUT_VERSION):
            self.reset()
        settings.restore_sizes(window)
