"""One view over the whole workspace, and back: what stands beside it is hidden meanwhile, nothing is moved."""

from collections.abc import Iterator

from PySide6.QtCore import QObject, Qt
from PySide6.QtGui import QCursor, QKeySequence
from PySide6.QtWidgets import QApplication, QDockWidget, QSplitter, QSplitterHandle, QWidget

from radargui.gui.layout import having
from radargui.gui.panels import Actions, Panels
from radargui.gui.plots.plot import Plot

FILLS = "fills"
"""Property of a view that is no plot and can fill the workspace."""
_BACK = QKeySequence("Esc")


class FullView(QObject):
    """Lets the view that has the keys, or else lies beneath the mouse, fill the workspace.

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
