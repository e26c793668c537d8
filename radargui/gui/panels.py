"""What the window can do and what it holds: actions with their keys and menus, the dockable panels, what Help tells."""

import platform
from collections.abc import Callable
from functools import partial
from itertools import pairwise
from operator import attrgetter
from pathlib import Path
from typing import NamedTuple

import pyqtgraph
from PySide6 import QtGui, QtWidgets, __version__ as pyside_version
from PySide6.QtCore import QByteArray, QEvent, QObject, QRect, QSize, Qt, QUrl, Signal
from PySide6.QtWidgets import QHBoxLayout, QTextBrowser, QWidget

from radargui import __version__
from radargui.gui.control.state import AppState
from radargui.gui.dialog import Dialog, fit_screen
from radargui.gui.layout import Scroll, button, fill, having, takes_tab
from radargui.gui.mnemonics import letter_menu
from radargui.gui.plots.plot import Plot
from radargui.gui.settings import LAYOUT_VERSION, Settings
from radargui.gui.theme import CHOICES, Theme, scaled_px
from radargui.system.resources import help_page, resource_table

TITLES = {
    "hardware": "Hardware setup",
    "antennas": "Antenna calibration",
    "session": "Session",
    "scopes": "IQ scopes",
    "planes": "IQ plane",
    "track": "Track",
    "runs": "Runs",
    "run": "Run",
    "result": "Result",
    "browser": "All sessions",
    "drops": "Last drops",
    "geometry": "Geometry",
    "channels": "Channels",
}
"""Kept names and the words shown; a name must never change, layouts are remembered by it."""


class Workspace(NamedTuple):
    """What is done one after another in the laboratory, and the panels for it.

    Attributes
    ----------
    title
        On its tab.
    own, guests
        Names of its panels, of which the guests belong to another workspace as well: that one is gone to for them.
    """

    title: str
    own: tuple[str, ...]
    guests: tuple[str, ...] = ()


WORKSPACES = {
    "prepare": Workspace("Prepare", ("hardware", "antennas", "geometry", "channels")),
    "measure": Workspace("Measure", ("track", "scopes", "planes", "drops"), ("runs", "session")),
    "analyse": Workspace("Analyse", ("runs", "run", "result")),
    "sessions": Workspace("Sessions", ("session", "browser")),
}
"""By the names under which their layouts are remembered, in the order of their keys."""


class Split(NamedTuple):
    """Parts of a workspace beside each other, or one beneath another; each is a group of tabs or split once more.

    Attributes
    ----------
    across
        Whether beside each other.
    parts, shares
        From the left or the top; each with its share of the room in percent.
    """

    across: bool
    parts: tuple["Split | tuple[str, ...]", ...]
    shares: tuple[int, ...]

    @property
    def first(self) -> str:
        """Name of the panel in the corner."""
        return _first(self.parts[0])


def _first(part: Split | tuple[str, ...]) -> str:
    return part.first if isinstance(part, Split) else part[0]


def _arrangement(name: str, *, narrow: bool) -> Split:
    """Return where the panels of a workspace stand at first."""
    if name == "prepare":
        seen = Split(False, (("geometry",), ("channels",)), (83, 17))
        return Split(True, (("hardware", "antennas"), seen), (27, 73))
    if name == "sessions":
        return Split(True, (("session",), ("browser",)), (30, 70))
    if name == "analyse":
        if narrow:
            return Split(False, (("runs",), Split(True, (("run",), ("result",)), (65, 35))), (30, 70))
        return Split(True, (("runs",), ("run",), ("result",)), (_RUNS[0], 100 - _RUNS[0] - _RESULT, _RESULT))
    lists = ("drops", "runs", "session")
    if narrow:
        return Split(True, (("track",), Split(False, (("scopes", "planes"), lists), (65, 35))), (62, 38))
    return Split(True, (("track",), Split(False, (("scopes",), ("planes",), lists), (42, 27, 31))), (71, 29))


_FORMS = ("hardware", "antennas", "session")
_WIDEST_FORM = 520
"""In pixels at the usual font. Lines of numbers do not get better by being wider; what is left belongs to the plots."""
_RUNS = (12, 46)
"""Width of the list of runs in percent: as pictures, and as a table."""
_RESULT = 28
"""Width of the result in percent: at 1366 pixels its figures stand in one line each."""
_MIN_ROOM = QSize(230, 116)
"""Of a panel: three beside each other and two above each other fit 960 x 540 (1920 x 1080 at scale 2)."""
_N_DIGITS = 10
"""Panels that have a digit for a key; those that came later stand in front of their workspace anyhow."""
_NARROW = 1100
"""Of a window: below it three panels beside each other are too small for plots, and one stands behind another."""
_FIRST_SIZE = (1440, 900)
"""Of the window at the first start where the screen has room."""

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
        return self.content.minimumSizeHint().boundedTo(_MIN_ROOM)

    def sizeHint(self) -> QSize:  # noqa: N802 - Qt's name
        """Return what the panel wants."""
        return self.content.sizeHint()


class Panels(QtWidgets.QMainWindow):
    """Holds one dock a panel, and shows those of one workspace; sits inside the window so that the strip stays.

    Qt keeps a dock that stands behind another "visible", away from the screen, where Tab and keys reach its fields:
    what such a dock holds is hidden here, and keeps its room. The panels come in the order of `TITLES`, and are `held`.

    Attributes
    ----------
    tabs
        Of the workspaces; the window's strip shows them.
    workspace
        Name of the one that is shown.
    """

    leaving = Signal()

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
        self._layouts: dict[str, QByteArray] = {}
        self.workspace = ""
        self.tabs = having(QtWidgets.QTabBar(drawBase=False, expanding=False), accessibleName="Workspaces")
        for number, one in enumerate(WORKSPACES.values(), 1):
            self.tabs.setTabToolTip(self.tabs.addTab(one.title), f"{one.title} (Ctrl+{number})")
        self.tabs.currentChanged.connect(lambda index: self.work_in(list(WORKSPACES)[index]))

    @property
    def with_keys(self) -> str:
        """Name of the panel that has the keys; empty where none has."""
        focus = QtWidgets.QApplication.focusWidget()
        if focus is None:
            return ""
        return next((name for name, panel in self.held.items() if panel is focus or panel.isAncestorOf(focus)), "")

    def work_in(self, name: str) -> None:
        """Show a workspace as it was left; the keys stay where they are as long as that is seen."""
        if name == self.workspace:
            return
        self.leaving.emit()
        had_keys = self.focusWidget()
        if self.workspace:
            self._layouts[self.workspace] = self.saveState(LAYOUT_VERSION)
        for bar in self._bars:
            # Qt makes new ones for a layout that comes again, and forgets to take the old ones away
            bar.hide()
        self.workspace = name
        self.tabs.setCurrentIndex(list(WORKSPACES).index(name))
        if name not in self._layouts or not self.restoreState(self._layouts[name], LAYOUT_VERSION):
            self._arrange()
        if had_keys is not None and had_keys.isVisible():
            had_keys.setFocus()
        elif self.isVisible():
            self.tabs.setFocus()

    def reset(self) -> None:
        """Put every panel where it stood at first, in each workspace."""
        self.leaving.emit()
        self._layouts.clear()
        self._arrange()

    def _arrange(self) -> None:
        """Put the panels of the workspace where they stand at first, and the others away."""
        workspace, docks = WORKSPACES[self.workspace], self.docks
        whole = _arrangement(self.workspace, narrow=self.width() < scaled_px(_NARROW))
        for dock in docks.values():
            dock.setFloating(False)
            self.removeDockWidget(dock)
        self.addDockWidget(Qt.DockWidgetArea.LeftDockWidgetArea, docks[whole.first])
        for name in docks.keys() - {*workspace.own, *workspace.guests}:
            # a layout that is remembered knows all of them
            self.addDockWidget(Qt.DockWidgetArea.RightDockWidgetArea, docks[name])
            docks[name].hide()
        self._split(whole)
        for name in (*workspace.own, *workspace.guests):
            docks[name].show()
        self._share(whole, self.size())

    def _split(self, part: Split | tuple[str, ...]) -> None:
        """Put the panels of a part beside, beneath and behind its first one."""
        docks = self.docks
        if not isinstance(part, Split):
            for front, behind in pairwise(part):
                self.tabifyDockWidget(docks[front], docks[behind])
            return
        direction = Qt.Orientation.Horizontal if part.across else Qt.Orientation.Vertical
        for one in reversed(part.parts[1:]):
            self.splitDockWidget(docks[part.first], docks[_first(one)], direction)
        for one in part.parts:
            self._split(one)

    def _share(self, part: Split | tuple[str, ...], room: QSize) -> None:
        """Give each part its share of the room; a form is never narrower than its fields."""
        if not isinstance(part, Split):
            self.docks[part[0]].raise_()
            return
        whole = room.width() if part.across else room.height()
        sizes = [share * whole // 100 for share in part.shares]
        if part.across and part.first in _FORMS:
            forms = part.parts[0] if isinstance(part.parts[0], tuple) else (part.first,)
            sizes[0] = max(sizes[0], *(self.held[one].minimumSizeHint().width() + 6 for one in forms))
            sizes[-1] = whole - sum(sizes[:-1])
        direction = Qt.Orientation.Horizontal if part.across else Qt.Orientation.Vertical
        self.resizeDocks([self.docks[_first(one)] for one in part.parts], sizes, direction)
        for one, size in zip(part.parts, sizes, strict=True):
            self._share(one, QSize(size, room.height()) if part.across else QSize(room.width(), size))

    def fill(self, menu: QtWidgets.QMenu) -> None:
        """Add one action a workspace and one a panel to a menu, which shows it in front whatever it was before."""
        for number, (name, one) in enumerate(WORKSPACES.items(), start=1):
            menu.addAction(one.title, QtGui.QKeySequence(f"Ctrl+{number}"), partial(self.work_in, name))
        menu.addSeparator()
        for number, (name, title) in enumerate(TITLES.items(), start=1):
            keys = [f"Alt+{number % 10}"] if number <= _N_DIGITS else []
            having(menu.addAction(title, partial(self.go_to, name)), shortcuts=keys)

    def go_to(self, name: str) -> None:
        """Show a panel in front, also one that was closed, and let the keys go to its first field.

        Where the workspace has no such panel, its own is shown.
        """
        self.leaving.emit()
        self._go_where(name)
        dock = self.docks[name]
        dock.show()
        dock.raise_()
        dock.activateWindow()
        self._show_content(dock, True)
        for one in dock.widget().findChildren(QtWidgets.QWidget):
            if takes_tab(one) and one.isVisible() and one.isEnabled():
                one.setFocus(Qt.FocusReason.ShortcutFocusReason)
                break

    def _go_where(self, name: str) -> None:
        """Show the workspace of a panel, unless the panel can be had in this one."""
        here = WORKSPACES[self.workspace]
        if name not in (*here.own, *here.guests) and self.docks[name].isHidden():
            self.work_in(next(where for where, one in WORKSPACES.items() if name in one.own))

    def way_to(self, name: str) -> tuple[QWidget, QRect]:
        """Return what leads to a panel that is not seen: the tab of its workspace, or its own, and where that is."""
        here = WORKSPACES[self.workspace]
        if name in (*here.own, *here.guests):
            for bar in self._bars:
                for place in range(bar.count()):
                    if bar.isVisible() and bar.tabText(place) == TITLES[name]:
                        return bar, bar.tabRect(place)
        places = [place for place, one in enumerate(WORKSPACES.values()) if name in one.own]
        return self.tabs, self.tabs.tabRect(places[0])

    def turn_runs(self) -> None:
        """Give the list of runs the width for a table, or take it back for pictures."""
        self._go_where("runs")
        beside = [self.docks[name] for name in ("runs", "run", "result")]
        least, most = _RUNS
        share = least if 100 * beside[0].width() > (least + most) // 2 * self.width() else most
        shares = (share, 100 - share - _RESULT, _RESULT)
        self.resizeDocks(beside, [one * self.width() // 100 for one in shares], Qt.Orientation.Horizontal)

    def next_plot(self) -> None:
        """Give the keys to the next plot that is seen, so that it is zoomed and copied without a mouse."""
        plots = [plot for plot in self.findChildren(Plot) if plot.isVisible()]
        if plots:
            at = next((place for place, plot in enumerate(plots) if plot.hasFocus()), -1)
            plots[(at + 1) % len(plots)].setFocus(Qt.FocusReason.ShortcutFocusReason)

    def bring_up(self, name: str) -> None:
        """Show a panel that the operator's own action asks for, as `go_to` does, but leave the keys where they are.

        It stays away where the operator closed it.
        """
        self._go_where(name)
        dock = self.docks[name]
        if self.tabifiedDockWidgets(dock) or not dock.isHidden():
            dock.raise_()

    @property
    def _bars(self) -> list[QtWidgets.QTabBar]:
        """Tabs of docks that stand behind one another."""
        return self.findChildren(QtWidgets.QTabBar, options=Qt.FindChildOption.FindDirectChildrenOnly)

    def _show_content(self, dock: QtWidgets.QDockWidget, visible: bool) -> None:
        dock.widget().setVisible(visible)
        for bar in self._bars:
            # the panels have keys of their own; Qt keeps bars of former layouts, which Tab would enter unseen
            bar.setFocusPolicy(Qt.FocusPolicy.NoFocus)

    def restore_within(self, window: QtWidgets.QMainWindow, settings: Settings, *, ready: bool = True) -> None:
        """Take size and layouts of the last time, where they cannot be used ones that fit the screen.

        Who is `ready` to measure begins with that, who is not with what has to be prepared.
        """
        geometry = settings.blob("geometry")
        if geometry.isEmpty() or not window.restoreGeometry(geometry):
            fit_screen(window, *_FIRST_SIZE)
        self.resize(window.size())
        kept = {name: settings.blob(f"layout/{name}") for name in WORKSPACES}
        self._layouts = {name: layout for name, layout in kept.items() if not layout.isEmpty()}
        self.workspace = ""
        self.work_in("measure" if ready else "prepare")
        settings.restore_sizes(window)

    def remember(self, settings: Settings) -> None:
        """Keep the layouts of all workspaces."""
        self.leaving.emit()
        for name, layout in (self._layouts | {self.workspace: self.saveState(LAYOUT_VERSION)}).items():
            settings.put(f"layout/{name}", layout)


class Actions:
    """One attribute an action, named as in `resources/window/actions.toml`, which has their words and keys."""

    def __init__(self, window: QtWidgets.QMainWindow) -> None:
        table = resource_table("window/actions")
        self._entries, self._unmet = table["actions"], table["unmet"]
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

    def enable(self, state: AppState, *, valid: bool, undo: bool = False, redo: bool = False) -> None:
        """Let be chosen what can be done in a state, with a setup that is `valid` or not, edits to undo and redo."""
        rest = not state.running
        now = {"at rest": rest, "running": not rest, "right": valid, "an edit": undo, "an edit taken back": redo}
        now["not recording"] = state.may_record
        for name, entry in self._entries.items():
            unmet = [one for one in entry.get("needs", ()) if not now[one]]
            self._made[name].setData("; ".join(self._unmet[one] for one in unmet))
            if "needs" in entry:
                self._made[name].setEnabled(not unmet)


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
    bar: QtWidgets.QMenuBar,
    does: Actions,
    theme: Theme,
    settings: Settings,
    **several: Callable[[QtWidgets.QMenu], None],
) -> QtGui.QActionGroup:
    """Fill the bar; return the group that chooses the look, each action's data is its choice.

    `several` add more than one entry each to a menu, by the names under which they stand in the table.
    """
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
    several["looks"] = add_looks
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


def show_help(parent: QWidget, settings: Settings | None = None, name: str = "", first: Path | None = None) -> None:
    """Open the help, at a page by its name where there is one; without a browser it is shown here.

    `first` is another first page than the program's.
    """
    page = first or help_page()
    if name and (named := page.with_name(f"{name}{page.suffix}")).is_file():
        page = named
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
