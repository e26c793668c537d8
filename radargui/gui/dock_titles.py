"""The titles of the panels: said once, on the tab or above the panel, with buttons that are seen in every look."""

from PySide6.QtCore import QObject, QPoint, Qt
from PySide6.QtGui import QIcon, QPixmap
from PySide6.QtWidgets import QAbstractButton, QDockWidget, QMenu, QTabBar, QWidget

from radargui.gui.layout import follow, having, ticking
from radargui.gui.panels import Panels
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
