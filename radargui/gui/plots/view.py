"""The area of a plot that the mouse and keys zoom: what is zoomed stays so until the whole is asked for again."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from typing import Any

import pyqtgraph as pg
from PySide6.QtCore import QPointF, Qt, Signal

_AXES = ("xRange", "yRange")
_STEP = 0.2
"""Share of the view that an arrow key moves it by."""
_CLOSER = 0.8
"""What a key leaves of the span when it zooms in."""


class View(pg.ViewBox):  # type: ignore[misc] # pyqtgraph has no types
    """A `ViewBox` that tells a range set by hand from one set by the program.

    Parameters
    ----------
    live
        The program sets ranges many times a second: a view that was zoomed by hand keeps its own, and the program's
        comes back with `show_all`. Otherwise a range set by the program belongs to new contents and ends a zoom.

    Attributes
    ----------
    zoomed
        Whether the range was set by hand.
    by_hand
        Whether that happens just now.
    dragged
        Takes where the left button was pressed and where it is now, on the axes, instead of moving the view; the middle
        one still moves it.
    """

    menu_asked = Signal(object)
    pointed = Signal(float)
    """Where the left button was clicked, on the lower axis."""
    zoom_changed = Signal()

    def __init__(self, *, live: bool) -> None:
        self._live = live
        self.by_hand = False
        self.zoomed = False
        self.dragged: Callable[[QPointF, QPointF], object] | None = None
        self._whole: dict[str, Any] = {}
        self._auto = [False, False]
        super().__init__(enableMenu=False)

    def setRange(self, rect: Any = None, xRange: Any = None, yRange: Any = None, **options: Any) -> None:  # noqa: N802 - pyqtgraph's name
        """Set a range; while the view is zoomed and live, the program's is kept for later."""
        if rect is None and not self.by_hand and options.get("disableAutoRange", True):
            asked = zip(_AXES, (xRange, yRange), strict=True)
            self._whole |= {name: value for name, value in asked if value is not None}
            if self.zoomed and self._live:
                return
            self._zoom(on=False)
        super().setRange(rect, xRange, yRange, **options)

    def enableAutoRange(self, axis: Any = None, enable: Any = True, x: Any = None, y: Any = None) -> None:  # noqa: N802 - pyqtgraph's
        """Let the contents set the range."""
        if enable is True and x is None and y is None and not self.by_hand:
            for number, name in enumerate(_AXES):
                if axis in (None, self.XYAxes, "xy", number, "xy"[number]):
                    self._whole.pop(name, None)
            self._zoom(on=False)
        super().enableAutoRange(axis, enable, x, y)

    def linkedViewChanged(self, view: View | None, axis: int) -> None:  # noqa: N802 - pyqtgraph's name
        """Follow the view that shares an axis, also its zoom."""
        if view is None or self.linksBlocked:
            return
        view.blockLink(True)
        try:
            with self._hand(zooms=False):
                # the range itself: pyqtgraph would line both up on the screen, wherever they stand
                self.setRange(**{_AXES[axis]: view.viewRange()[axis]}, padding=0)
        finally:
            view.blockLink(False)
        self._zoom(on=view.zoomed or view.by_hand)

    def wheelEvent(self, event: Any, axis: int | None = None) -> None:  # noqa: N802 - Qt's name
        """Zoom."""
        with self._hand():
            super().wheelEvent(event, axis)

    def mouseDragEvent(self, event: Any, axis: int | None = None) -> None:  # noqa: N802 - pyqtgraph's name
        """Move the view with the left button, or what `dragged` does; stretch it with the right one."""
        if self.dragged is not None and axis is None and event.button() == Qt.MouseButton.LeftButton:
            event.accept()
            self.dragged(self.mapToView(event.buttonDownPos()), self.mapToView(event.pos()))
            return
        with self._hand():
            super().mouseDragEvent(event, axis)

    def mouseClickEvent(self, event: Any) -> None:  # noqa: N802 - pyqtgraph's name
        """Show the menu, or all."""
        if event.button() == Qt.MouseButton.RightButton:
            event.accept()
            self.menu_asked.emit(event.screenPos().toPoint())
        elif event.double():
            event.accept()
            self.show_all()
        else:
            self.pointed.emit(self.mapToView(event.pos()).x())

    def bring_in_sight(self, x: float) -> None:
        """Let a place of the lower axis be seen where the view is zoomed."""
        left, right = self.viewRange()[0]
        if self.zoomed and self.linkedView(0) is None and not left <= x <= right:
            with self._hand():
                self.translateBy(x=x - 0.5 * (left + right))

    def meant(self, key: Qt.Key) -> Callable[[], None] | None:
        """Return how a key zooms or moves; None where it means nothing here."""
        closer = partial(self._scale, _CLOSER)
        does: dict[Qt.Key, Callable[[], None]] = {
            Qt.Key.Key_Left: partial(self._move, -_STEP, 0.0),
            Qt.Key.Key_Right: partial(self._move, _STEP, 0.0),
            Qt.Key.Key_Down: partial(self._move, 0.0, -_STEP),
            Qt.Key.Key_Up: partial(self._move, 0.0, _STEP),
            # on many keyboards + is the shift of =
            Qt.Key.Key_Plus: closer,
            Qt.Key.Key_Equal: closer,
            Qt.Key.Key_Minus: partial(self._scale, 1.0 / _CLOSER),
            Qt.Key.Key_Home: self.show_all,
        }
        return does.get(key)

    def _move(self, across: float, up: float) -> None:
        (left, right), (low, high) = self.viewRange()
        with self._hand():
            self.translateBy(x=across * (right - left), y=up * (high - low))

    def _scale(self, factor: float) -> None:
        with self._hand():
            self.scaleBy((factor, factor))

    def show_all(self) -> None:
        """End a zoom: show what the program shows."""
        if not self.zoomed:
            return
        linked = self.linkedView(0)
        names = _AXES[1:] if linked is not None else _AXES
        fixed = {name: self._whole[name] for name in names if name in self._whole and not self._auto[_AXES.index(name)]}
        self._zoom(on=False)
        if linked is not None:
            linked.show_all()
        for name in names:
            if name not in fixed:
                super().enableAutoRange(_AXES.index(name), enable=True)
        if fixed:
            super().setRange(**fixed, padding=0)

    @contextmanager
    def _hand(self, *, zooms: bool = True) -> Iterator[None]:
        if not self.zoomed:
            self._auto = [bool(one) for one in self.autoRangeEnabled()]
        before, outer = self.viewRange(), self.by_hand
        self.by_hand = True
        try:
            yield
        finally:
            self.by_hand = outer
        if zooms and self.viewRange() != before:
            self._zoom(on=True)

    def _zoom(self, *, on: bool) -> None:
        if on is not self.zoomed:
            self.zoomed = on
            self.zoom_changed.emit()
