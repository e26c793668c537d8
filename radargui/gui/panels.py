"""What the window can do and what it holds: actions with their keys and menus, the dockable panels, what Help tells."""

import platform
from functools import partial
from operator import attrgetter
from pathlib import Path

import pyqtgraph
from PySide6 import QtGui, QtWidgets, __version__ as pyside_version
from PySide6.QtCore import QEvent, QObject, QSize, Qt, QUrl
from PySide6.QtWidgets import QHBoxLayout, QTextBrowser, QWidget

from radargui import __version__
from radargui.gui.control.state import AppState
from radargui.gui.dialog import Dialog, fit_screen
from radargui.gui.layout import Scroll, button, fill, having, takes_tab
from radargui.gui.mnemonics import letter_menu
from radargui.gui.plots.plot import Plot
from radargui.gui.settings import LAYOUT_VERSION, Settings
from radargui.gui.theme import CHOICES, Theme, scaled_px
from radargui.model.resources import help_page, resource_table

TITLES = {
    "hardware": "Hardware setup",
    "antennas": "Antenna calibration",
    "session": "Session",
    "scopes": "IQ scopes",
    "planes": "IQ plane",
    "track": "Track",
    "runs": "Runs",
    "run": "Run",
    "series": "Series",
}
"""Kept names and the words shown; a name must never change, layouts are remembered by it."""


_FORMS = ("hardware", "antennas", "session")
_WIDEST_FORM = 520
"""In pixels at the usual font. Lines of numbers do not get better by being wider; what is left belongs to the plots."""
_LEAST_ROOM = QSize(230, 116)
"""Of a panel: three beside each other and two above each other fit 960 x 540 (1920 x 1080 at scale 2)."""
_TITLE_PX = 24
"""Height of a panel's title, and of the line between two panels."""
_NARROW = 1100
"""Of a window: below it three panels beside each other are too small for plots, and one stands behind another."""
_FIRST_SIZE = (1440, 900)
"""Of the window at the first start where the screen has room: two plots of 500 pixels beside the forms."""

NO_HELP = (
    f"The help of RadarGUI {__version__} was not installed with it. Its texts are in the folder docs of the source; "
    "begin with docs/tutorial.md. Installed from there anew, F1 opens them."
)


def belongs(widget: QtWidgets.QWidget, window: QtWidgets.QWidget) -> bool:
    """Return whether a widget stands in a window or in a panel that was torn off it."""
    return widget.window() is window or isinstance(widget.window(), QtWidgets.QDockWidget)


class FocusMark(QtWidgets.QFocusFrame):
    """Follows the keys through a window, and stays away where they have left it."""

    def __init__(self, window: QtWidgets.QWidget, application: QtWidgets.QApplication) -> None:
        super().__init__(window)
        self._window = window
        self.hide()
        application.focusChanged.connect(self._follow)

    def paintEvent(self, _event: QtGui.QPaintEvent) -> None:  # noqa: N802 - Qt's name
        """Draw the frame; Qt lets through only its edge."""
        painter = QtGui.QPainter(self)
        painter.fillRect(self.rect(), self.palette().color(QtGui.QPalette.ColorRole.Highlight))

    def _follow(self, _old: QtWidgets.QWidget | None, now: QtWidgets.QWidget | None) -> None:
        mine = now is not None and belongs(now, self._window)
        self.setWidget(now if mine else None)  # type: ignore[arg-type]
        if now is not None and mine and now.visibleRegion().isEmpty():
            # whoever comes from outside into what was scrolled: Qt scrolls only for steps inside
            for room in (one for one in self._window.findChildren(Scroll) if one.isAncestorOf(now)):
                room.ensureWidgetVisible(now)


class Room(Scroll):
    """What a dock holds: scrolls where the screen is too small for it, so that it never makes the window larger."""

    def __init__(self, panel: QtWidgets.QWidget) -> None:
        super().__init__(panel, across=True)
        self.setSizePolicy(having(self.sizePolicy(), retainSizeWhenHidden=True))

    def minimumSizeHint(self) -> QSize:  # noqa: N802 - Qt's name
        """Return the size below which nothing can be read in it."""
        return self.content.minimumSizeHint().boundedTo(_LEAST_ROOM)

    def sizeHint(self) -> QSize:  # noqa: N802 - Qt's name
        """Return what the panel wants."""
        return self.content.sizeHint()


class Panels(QtWidgets.QMainWindow):
    """Holds one dock a panel; sits inside the window so that state, messages and health stay where they are.

    Qt keeps a dock that stands behind another "visible", away from the screen, where Tab and keys reach its fields:
    what such a dock holds is hidden here, and keeps its room. The panels come in the order of `TITLES`, and are `held`.
    """

    def __init__(self, *widgets: QtWidgets.QWidget) -> None:
        super().__init__(None, Qt.WindowType.Widget)
        self.setDockNestingEnabled(True)
        self.setTabPosition(Qt.DockWidgetArea.AllDockWidgetAreas, QtWidgets.QTabWidget.TabPosition.North)
        self.docks: dict[str, QtWidgets.QDockWidget] = {}
        self.held = dict(zip(TITLES, widgets, strict=True))
        for name, title in TITLES.items():
            dock = having(QtWidgets.QDockWidget(title), objectName=name, widget=Room(self.held[name]))
            dock.visibilityChanged.connect(partial(self._show_content, dock))
            if name in _FORMS:
                dock.setMaximumWidth(scaled_px(_WIDEST_FORM))
            self.docks[name] = dock
            self.addDockWidget(Qt.DockWidgetArea.LeftDockWidgetArea, dock)

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
        narrow = self.width() < scaled_px(_NARROW)
        if narrow:
            self.tabifyDockWidget(docks["scopes"], docks["planes"])
        else:
            self.splitDockWidget(docks["runs"], docks["planes"], across)
        for front, behind in (("hardware", "antennas"), ("antennas", "session"), ("scopes", "run"), ("run", "series")):
            self.tabifyDockWidget(docks[front], docks[behind])
        for dock in docks.values():
            dock.show()
        for name in ("hardware", "scopes"):
            docks[name].raise_()
        width, height = self.width(), self.height()
        # wider only where large letters need it
        most = max(400, min(scaled_px(400), width // 3))
        side = min(most, max(28 * width // 100, self.held["antennas"].minimumSizeHint().width() + 6))
        rest = width - side
        self.resizeDocks([docks["hardware"], docks["scopes"], docks["track"]], [side, rest // 2, rest // 2], across)
        if not narrow:
            self.resizeDocks([docks["runs"], docks["planes"]], [68 * rest // 100, 32 * rest // 100], across)
        # what the track needs is left for it, so that it need not scroll, while the runs keep three rows
        least = self.held["track"].minimumSizeHint().height() + _TITLE_PX
        low = min(scaled_px(280), 3 * height // 8, max(scaled_px(3 * height // 10), height - least))
        self.resizeDocks([docks["scopes"], docks["runs"]], [height - low, low], down)

    def fill(self, menu: QtWidgets.QMenu) -> None:
        """Add one action a panel to a menu, which shows it in front whatever it was before."""
        for number, (name, title) in enumerate(TITLES.items(), start=1):
            menu.addAction(title, QtGui.QKeySequence(f"Alt+{number}"), partial(self.go_to, name))

    def go_to(self, name: str) -> None:
        """Show a panel in front, also one that was closed, and let the keys go to its first field."""
        dock = self.docks[name]
        dock.show()
        dock.raise_()
        dock.activateWindow()
        self._show_content(dock, True)
        for one in dock.widget().findChildren(QtWidgets.QWidget):
            if takes_tab(one) and one.isVisible() and one.isEnabled():
                one.setFocus(Qt.FocusReason.ShortcutFocusReason)
                break

    def next_plot(self) -> None:
        """Give the keys to the next plot that is seen, so that it is zoomed and copied without a mouse."""
        plots = [plot for plot in self.findChildren(Plot) if plot.isVisible()]
        if plots:
            at = next((place for place, plot in enumerate(plots) if plot.hasFocus()), -1)
            plots[(at + 1) % len(plots)].setFocus(Qt.FocusReason.ShortcutFocusReason)

    def bring_up(self, name: str) -> None:
        """Show a panel in front, unless the operator closed it, or follows the series where it would stand."""
        dock, series = self.docks[name], self.docks["series"]
        beside = self.tabifiedDockWidgets(dock)
        follows_series = name != "series" and series.widget().isVisible() and series in beside
        if not follows_series and (beside or not dock.isHidden()):
            dock.raise_()

    def _show_content(self, dock: QtWidgets.QDockWidget, visible: bool) -> None:
        dock.widget().setVisible(visible)
        for tabs in self.findChildren(QtWidgets.QTabBar, options=Qt.FindChildOption.FindDirectChildrenOnly):
            # the panels have keys of their own; Qt keeps bars of former layouts, which Tab would enter unseen
            tabs.setFocusPolicy(Qt.FocusPolicy.NoFocus)

    def restore_within(self, window: QtWidgets.QMainWindow, settings: Settings) -> None:
        """Take size and layout of the last time, where that cannot be used one that fits the screen."""
        geometry, layout = settings.blob("geometry"), settings.blob("layout")
        if geometry.isEmpty() or not window.restoreGeometry(geometry):
            fit_screen(window, *_FIRST_SIZE)
        self.resize(window.size())
        if layout.isEmpty() or not self.restoreState(layout, LAYOUT_VERSION):
            self.reset()
        settings.restore_sizes(window)


class Actions:
    """One attribute an action, named as in `resources/window/actions.toml`, which has their words and keys."""

    def __init__(self, window: QtWidgets.QMainWindow) -> None:
        self._entries = resource_table("window/actions")["actions"]
        self._made: dict[str, QtGui.QAction] = {}
        reach = Qt.ShortcutContext
        for name, entry in self._entries.items():
            words, keys = entry["words"], entry["keys"]
            action = self._made[name] = QtGui.QAction(words, window, checkable=entry.get("checkable", False))
            action.setShortcuts([QtGui.QKeySequence(key) for key in keys])
            action.setToolTip(f"{entry.get('tip') or words.rstrip('…')} ({', '.join(keys)})")
            action.setShortcutContext(reach.WindowShortcut if entry.get("in_window") else reach.ApplicationShortcut)
            window.addAction(action)
        for action in (self.start, self.record, self.stop):
            having(action, iconText=f"{action.text()}\n{action.shortcut().toString()}", autoRepeat=False)
        self.in_space.setEnabled(False)

    def __getattr__(self, name: str) -> QtGui.QAction:
        """Return an action by its name."""
        if name.startswith("_") or name not in self._made:
            raise AttributeError(f"no action is named {name}")
        return self._made[name]

    def connect_to(self, window: QtWidgets.QMainWindow) -> None:
        """Let each action call what the table says, once all parts of the window are there."""
        for name, entry in self._entries.items():
            if "calls" in entry:
                self._made[name].triggered.connect(attrgetter(entry["calls"])(window))

    def enable(self, state: AppState, *, valid: bool) -> None:
        """Let be chosen what can be done in a state, with a setup that is `valid` or not."""
        rest = not state.running
        now = {"at rest": rest, "at rest or live": rest or state is AppState.LIVE, "running": not rest, "right": valid}
        for name, entry in self._entries.items():
            if "needs" in entry:
                self._made[name].setEnabled(all(now[one] for one in entry["needs"]))


class RunKeys(QObject):
    """Lets Space, R and Esc do in every panel what stands on the buttons; Enter presses what has the keys instead.

    Only where words are typed Space and R are letters; a number has none, so there they act as well.
    """

    def __init__(self, window: QtWidgets.QMainWindow, application: QtWidgets.QApplication) -> None:
        super().__init__(window)
        self._window = window
        application.focusChanged.connect(self._follow)

    def eventFilter(self, widget: QObject, event: QEvent) -> bool:  # noqa: N802 - Qt's name
        """Keep a key from what has the focus."""
        if not isinstance(widget, QWidget) or not isinstance(event, QtGui.QKeyEvent):
            return False
        kind = event.type()
        if kind == QEvent.Type.KeyRelease or event.modifiers() != Qt.KeyboardModifier.NoModifier:
            return False
        acts = event.key() in (Qt.Key.Key_Space, Qt.Key.Key_R) and not _takes_words(widget)
        if kind == QEvent.Type.ShortcutOverride:
            if acts:
                event.ignore()
            return acts
        if event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter):
            if isinstance(widget, QtWidgets.QAbstractButton):
                widget.click()
            elif isinstance(widget, QtWidgets.QComboBox):
                widget.showPopup()
        # while Start or Record cannot be chosen, their keys press nothing else
        return acts

    def _follow(self, old: QtWidgets.QWidget | None, now: QtWidgets.QWidget | None) -> None:
        if old is not None:
            old.removeEventFilter(self)
        if now is not None and belongs(now, self._window):
            now.installEventFilter(self)


def _takes_words(widget: QtWidgets.QWidget) -> bool:
    numbers = Qt.InputMethodHint.ImhDigitsOnly | Qt.InputMethodHint.ImhFormattedNumbersOnly
    typed = widget.testAttribute(Qt.WidgetAttribute.WA_InputMethodEnabled)
    return typed and not widget.inputMethodHints() & numbers


def fill_menus(
    bar: QtWidgets.QMenuBar, does: Actions, panels: Panels, theme: Theme, settings: Settings
) -> QtGui.QActionGroup:
    """Fill the bar; return the group that chooses the look, each action's data is its choice."""
    group = QtGui.QActionGroup(bar)

    def add_looks(view: QtWidgets.QMenu) -> None:
        menu = view.addMenu("Theme")
        for choice in CHOICES:
            action = QtGui.QAction(choice.capitalize(), group, checkable=True, checked=choice == theme.choice)
            action.setData(choice)
            menu.addAction(action)

    def choose_look(action: QtGui.QAction) -> None:
        theme.apply(action.data())
        settings.put("theme", action.data())

    group.triggered.connect(choose_look)
    several = {"panels": panels.fill, "looks": add_looks}
    for title, parts in resource_table("window/actions")["menus"].items():
        menu = bar.addMenu(title)
        for part in parts:
            if menu.actions():
                menu.addSeparator()
            for name in part:
                several[name](menu) if name in several else menu.addAction(getattr(does, name))
        letter_menu(menu)
    return group


class About(Dialog):
    """The facts, to be copied."""

    def __init__(self, opengl: str, data_folder: Path, setup_file: Path | None, parent: QWidget) -> None:
        super().__init__("About RadarGUI", (560, 220), parent)
        lines = (
            f"RadarGUI {__version__}",
            f"Python {platform.python_version()}, PySide6 {pyside_version}, pyqtgraph {pyqtgraph.__version__}",
            f"System: {platform.platform()}",
            f"Track in 3D: {opengl}",
            f"Data folder: {data_folder}",
            f"Setup file: {setup_file or 'none'}",
        )
        view = QtWidgets.QPlainTextEdit("\n".join(lines), readOnly=True)
        self.lay_out(view, fill(QtWidgets.QHBoxLayout(), 1, button("Close", self.reject, default=True)))


def show_help(parent: QWidget, settings: Settings | None = None) -> None:
    """Open the help; without a browser it is shown here."""
    page = help_page()
    url = QUrl.fromLocalFile(str(page))
    if page.suffix != ".html" or not QtGui.QDesktopServices.openUrl(url):
        HelpBrowser(url, parent, settings).show()


class HelpBrowser(Dialog):
    """One page after the other, as their links lead."""

    def __init__(self, url: QUrl, parent: QWidget, settings: Settings | None) -> None:
        super().__init__("Help", (930, 720), parent, "help", settings)
        self.pages = QTextBrowser(openExternalLinks=True)
        if Path(url.toLocalFile()).is_file():
            self.pages.setSource(url)
        else:
            self.pages.setPlainText(NO_HELP)
        back = button("Back", self.pages.backward)
        self.lay_out(self.pages, fill(QHBoxLayout(), back, 1, button("Close", self.reject, default=True)))
