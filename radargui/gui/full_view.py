"""What the docks do beyond Qt's own: one view over the whole workspace and back, titles said once."""

from collections.abc import Iterator

from PySide6.QtCore import QObject, QPoint, Qt
from PySide6.QtGui import QCursor, QIcon, QKeySequence, QPixmap
from PySide6.QtWidgets import (
    QAbstractButton,
    QApplication,
    QDockWidget,
    QMenu,
    QSplitter,
    QSplitterHandle,
    QTabBar,
    QWidget,
)

from radargui.gui.layout import follow, having, ticking
from radargui.gui.panels import Actions, Panels
from radargui.gui.plots.plot import Plot
from radargui.gui.theme import Theme

_BUTTONS = {"float": "Let the panel stand by itself, or put it back", "close": "Close the panel; View brings it back"}
_TAB_TIP = "Double click: let the panel stand by itself; right click: close it"
_LINES = {"float": "M3.5 6.5h6v6h-6z M6 4H12V10", "close": "M4 4L12 12 M4 12L12 4"}
_SIGN = """<svg xmlns="http://www.w3.org/2000/svg" width="64" height="64" viewBox="0 0 16 16">
<path d="{lines}" fill="none" stroke="{colour}" stroke-width="1.5"/></svg>"""


class DockTitles(QObject):
    """Takes the title off a panel whose tab says it, and puts it back; what the title's buttons do the tab does too."""

    def __init__(self, holder: Panels, theme: Theme) -> None:
        super().__init__(holder)
        self._holder, self._theme = holder, theme
        self._soon = ticking(self, 0, self.refresh, once=True)
        self._known: set[QTabBar] = set()
        for dock in self._holder.docks.values():
            for changed in (dock.visibilityChanged, dock.topLevelChanged, dock.dockLocationChanged):
                changed.connect(lambda *_: self._soon.start())
        follow(theme.changed, self._draw)

    def refresh(self) -> None:
        """Look which panels have a tab."""
        for dock in self._holder.docks.values():
            beside = any(not other.isHidden() for other in self._holder.tabifiedDockWidgets(dock))
            tabbed = beside and not dock.isFloating() and not dock.isHidden()
            if tabbed != (dock.titleBarWidget() is not None):
                old = dock.titleBarWidget()
                dock.setTitleBarWidget(QWidget() if tabbed else None)  # type: ignore[arg-type] # None: Qt's own
                if old is not None:
                    old.deleteLater()
        for bar in self._holder.findChildren(QTabBar, options=Qt.FindChildOption.FindDirectChildrenOnly):
            if bar.count() < 2:
                # of a panel that is alone now: Qt forgets to take it away
                bar.hide()
            for tab in range(bar.count()):
                bar.setTabToolTip(tab, f"{bar.tabText(tab)}. {_TAB_TIP}")
            if bar not in self._known:
                self._known.add(bar)
                bar.setContextMenuPolicy(Qt.ContextMenuPolicy.CustomContextMenu)
                bar.tabBarDoubleClicked.connect(lambda tab, bar=bar: self._of(bar, tab).setFloating(True))
                bar.customContextMenuRequested.connect(lambda where, bar=bar: self._ask(bar, where))
        self._draw()

    def _of(self, bar: QTabBar, tab: int) -> QDockWidget:
        return next(dock for dock in self._holder.docks.values() if dock.windowTitle() == bar.tabText(tab))

    def _ask(self, bar: QTabBar, where: QPoint) -> None:
        tab = bar.tabAt(where)
        if tab >= 0:
            self.menu_of(self._of(bar, tab)).popup(bar.mapToGlobal(where))

    def menu_of(self, dock: QDockWidget) -> QMenu:
        """Return what a panel's tab offers."""
        menu = QMenu(self._holder)
        menu.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        menu.addAction("Let it stand by itself", lambda: dock.setFloating(True))
        menu.addAction("Close", dock.close)
        return menu

    def _draw(self) -> None:
        """Give the buttons of the titles signs in the colour of the writing: the style's own are grey on grey."""
        icons = {name: _icon(name, self._theme.colours.text) for name in _BUTTONS}
        for dock in self._holder.docks.values():
            for name, tip in _BUTTONS.items():
                button = dock.findChild(QAbstractButton, f"qt_dockwidget_{name}button")
                if button is not None:
                    having(button, icon=icons[name], toolTip=tip)


def _icon(name: str, colour: str) -> QIcon:
    pixmap = QPixmap()
    pixmap.loadFromData(_SIGN.format(lines=_LINES[name], colour=colour).encode())
    return QIcon(pixmap)


FILLS = "fills"
"""Property of a view that is no plot and can fill the workspace."""
_BACK = QKeySequence("Esc")


class FullView(QObject):
    """Lets the view that has the keys, or else lies beneath the mouse, fill the workspace; nothing is moved.

    Plots that belong together (of three receivers, of three planes) fill it together. While one does, Esc gives the
    room back; whatever shows another panel does so too.
    """

    def __init__(self, panels: Panels, does: Actions) -> None:
        super().__init__(panels)
        self._panels, self._does = panels, does
        self._hidden: list[QWidget] = []
        self._stop_keys = does.stop.shortcuts()
        does.full.toggled.connect(lambda on: self._fill() if on else self._give_back())
        panels.leaving.connect(lambda: does.full.setChecked(False))

    def _fill(self) -> None:
        view = self._wanted()
        if view is None:
            self._does.full.setChecked(False)
            return
        self._layout = self._panels.saveState()
        self._hidden = [one for one in self._beside(view) if not one.isHidden()]
        for one in self._hidden:
            one.hide()
        self._divide_keys(full=True)

    def _give_back(self) -> None:
        if not self._hidden:
            return
        for one in self._hidden:
            one.show()
        self._panels.restoreState(self._layout)
        self._hidden = []
        self._divide_keys(full=False)

    def _divide_keys(self, *, full: bool) -> None:
        """Let Esc give the room back, or end what runs; the button says which key does that."""
        own, stop = [QKeySequence("F2")], [one for one in self._stop_keys if one != _BACK]
        self._does.full.setShortcuts([*own, _BACK] if full else own)
        self._does.stop.setShortcuts(stop if full else self._stop_keys)
        words = self._does.stop.text().replace("&", "")
        having(self._does.stop, iconText=f"{words}\n{self._does.stop.shortcut().toString()}")

    def _wanted(self) -> QWidget | None:
        """Return what is to fill the workspace; None where no plot is in sight."""
        plots = [one for one in self._panels.findChildren(Plot) if one.isVisible()]
        largest: Plot | None = max(plots, key=lambda one: one.width() * one.height(), default=None)
        for one in (QApplication.focusWidget(), QApplication.widgetAt(QCursor.pos()), largest):
            at: QWidget | None = one
            while at is not None and at is not self._panels:
                if isinstance(at, Plot) and self._panels.isAncestorOf(at):
                    return QWidget.parentWidget(at)
                if at.property(FILLS):
                    return at
                at = at.parentWidget()
        return None

    def _beside(self, view: QWidget) -> Iterator[QWidget]:
        """Yield what takes room beside a view, from the nearest to the other panels."""
        direct = Qt.FindChildOption.FindDirectChildrenOnly
        at = view
        while at is not self._panels and (parent := at.parentWidget()) is not None:
            if parent is self._panels:
                # one that was torn off has a window of its own
                floats = isinstance(at, QDockWidget) and at.isFloating()
                yield from (dock for dock in self._panels.docks.values() if dock is not at and not floats)
            elif not isinstance(parent, QDockWidget) and (parent.layout() or isinstance(parent, QSplitter)):
                others = parent.findChildren(QWidget, options=direct)
                yield from (one for one in others if one is not at and not isinstance(one, QSplitterHandle))
            at = parent
