"""Bubbles: words over the window that point at a widget, so that nothing moves when they come and go."""

from typing import Literal

from PySide6.QtCore import QEvent, QObject, QPoint, QPointF, QRect, QRectF, QSize, Qt, QTimer, Signal
from PySide6.QtGui import QPainter, QPainterPath, QPaintEvent, QPalette, QPen, QPolygonF
from PySide6.QtWidgets import QApplication, QLabel, QScrollArea, QVBoxLayout, QWidget
from shiboken6 import isValid

Side = Literal["below", "above", "right", "left"]
_ARROW = 7
"""Height of the point, in pixels."""
_INSIDE = 7
"""Between the outline and the words, in pixels."""
_GAP = 2
"""Between the point and its target, in pixels."""
_TOWARDS: dict[Side, tuple[int, int]] = {"below": (0, -1), "above": (0, 1), "right": (-1, 0), "left": (1, 0)}
"""Where the target is seen from a bubble at each side of it, across and down."""
_MOVES = (QEvent.Type.Move, QEvent.Type.Resize, QEvent.Type.Show, QEvent.Type.Hide, QEvent.Type.LayoutRequest)


class Bubble(QWidget):
    """Lies over what holds its target, beside it, as long as the target is seen.

    Parameters
    ----------
    outline
        Colour of its edge.
    sides
        Where it may lie about its target, the best one first.
    """

    settled = Signal()
    """It came, moved or went."""

    def __init__(self, outline: QPalette.ColorRole, sides: tuple[Side, ...]) -> None:
        super().__init__()
        self._outline, self._sides, self._side = outline, sides, sides[0]
        self._tip = QPoint()
        self._target: QWidget | None = None
        self._followed: list[QWidget] = []
        self.hide()
        self._later = QTimer(self, interval=0, singleShot=True)
        self._later.timeout.connect(self.settle)

    @property
    def target(self) -> QWidget | None:
        """What it points at."""
        return self._target

    def point_at(self, target: QWidget | None) -> None:
        """Point at a widget; None: at nothing, and be gone."""
        self._follow(target)
        self.settle()

    def look_later(self) -> None:
        """Look once more where to lie, after what goes on now."""
        self._later.start()

    def settle(self) -> None:
        """Lie beside the target, or be gone where that is not seen."""
        self.lie_beside(self._target)

    def lie_beside(self, target: QWidget | None, part: QRect | None = None, sides: tuple[Side, ...] = ()) -> None:
        """Lie beside a target or a `part` of it, as near as can be at one of some sides."""
        self._follow(target)
        self._sides = sides or self._sides
        layer = self.parentWidget()
        if target is None or not isValid(target) or layer is None or not target.isVisibleTo(layer):
            self.hide()
        else:
            thing = part or target.rect()
            self._lie_beside(QRect(target.mapTo(layer, thing.topLeft()), thing.size()), layer.rect())
        self.settled.emit()

    def _follow(self, target: QWidget | None) -> None:
        """Hear of all that may move the target."""
        if target is self._target:
            return
        for one in self._followed:
            if isValid(one):
                one.removeEventFilter(self)
        self._target, self._followed = target, []
        if target is None:
            return
        layer = self.layer_of(target)
        if self.parentWidget() is not layer:
            self.setParent(layer)
        holder: QWidget | None = target
        while holder is not None:
            holder.installEventFilter(self)
            self._followed.append(holder)
            holder = None if holder is layer else holder.parentWidget()

    def layer_of(self, target: QWidget) -> QWidget:
        """Return what it lies over: the window of its target."""
        return target.window()

    def is_in_the_way(self, _place: QRect) -> bool:
        """Return whether it would lie over something that must be seen."""
        return False

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802 - Qt's name
        """Follow its target."""
        if event.type() in _MOVES:
            self.look_later()
        return super().eventFilter(watched, event)

    def _lie_beside(self, target: QRect, room: QRect) -> None:
        places = {side: self._place(side, target, room) for side in self._sides}
        # of sides none of which has the room the first one
        self._side = next((side for side in self._sides if room.contains(places[side])), self._sides[0])
        place = places[self._side]
        if self.is_in_the_way(place):
            self.hide()
            return
        self._tip = target.center() - place.topLeft()
        self._set_margins(self._side)
        self.setGeometry(place)
        self.show()
        self.raise_()
        self.update()

    def _set_margins(self, side: Side) -> None:
        x, y = _TOWARDS[side]
        self.setContentsMargins(*(_INSIDE + _ARROW * is_there for is_there in (x < 0, y < 0, x > 0, y > 0)))

    def _place(self, side: Side, target: QRect, room: QRect) -> QRect:
        """Return where it would lie at a side of its target."""
        self._set_margins(side)
        wanted = self._size_within(room.width())
        place = QRect(QPoint(), wanted)
        if side in ("below", "above"):
            top = target.bottom() + 1 + _GAP if side == "below" else target.top() - _GAP - wanted.height()
            place.moveTopLeft(QPoint(target.left(), top))
            place.moveLeft(max(room.left() + _GAP, min(place.left(), room.right() - _GAP - wanted.width())))
        else:
            left = target.right() + 1 + _GAP if side == "right" else target.left() - _GAP - wanted.width()
            place.moveTopLeft(QPoint(left, target.center().y() - wanted.height() // 2))
            place.moveTop(max(room.top() + _GAP, min(place.top(), room.bottom() - _GAP - wanted.height())))
        return place

    def _size_within(self, width: int) -> QSize:
        layout = self.layout()
        if layout is None:
            return self.sizeHint()
        layout.activate()
        wide = min(self.sizeHint().width(), width - 2 * _GAP)
        return QSize(wide, layout.totalHeightForWidth(wide) if layout.hasHeightForWidth() else self.sizeHint().height())

    def paintEvent(self, _event: QPaintEvent) -> None:  # noqa: N802 - Qt's name
        """Draw the outline with its point."""
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(QPen(self.palette().color(self._outline), 1.5))
        painter.setBrush(self.palette().color(QPalette.ColorRole.Base))
        painter.drawPath(self._shape())

    def _shape(self) -> QPainterPath:
        """Return the box and its point, which is as near to the middle of the target as the corners allow."""
        x, y = _TOWARDS[self._side]
        box = QRectF(self.rect()).adjusted(1, 1, -1, -1)
        box.adjust(_ARROW * (x < 0), _ARROW * (y < 0), -_ARROW * (x > 0), -_ARROW * (y > 0))
        inner = box.adjusted(2 * _ARROW, 2 * _ARROW, -2 * _ARROW, -2 * _ARROW)
        foot = box.center() + QPointF(0.5 * x * box.width(), 0.5 * y * box.height())
        if y:
            foot.setX(max(inner.left(), min(self._tip.x(), inner.right())))
        else:
            foot.setY(max(inner.top(), min(self._tip.y(), inner.bottom())))
        along, across = QPointF(_ARROW * x, _ARROW * y), QPointF(_ARROW * y, _ARROW * x)
        path = QPainterPath()
        path.addRect(box)
        path.addPolygon(QPolygonF([foot - across, foot + along, foot + across, foot - across]))
        return path.simplified()


_FAULT_PX = 320
"""Width of the words of a fault: about 50 letters (chosen by hand)."""


class FaultBubble(Bubble):
    """What is wrong with a field, beside it; never over what has the keys, and clicks go through it."""

    def __init__(self) -> None:
        super().__init__(QPalette.ColorRole.BrightText, ("below", "above"))
        self.words = QLabel(textFormat=Qt.TextFormat.PlainText, wordWrap=True)
        self.words.setStyleSheet("color: palette(bright-text); font-weight: bold;")
        self.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.addWidget(self.words)
        QApplication.instance().focusChanged.connect(self._keys_moved)  # type: ignore[union-attr]

    def text(self) -> str:
        """Return what it says."""
        return self.words.text()

    def say(self, text: str, field: QWidget | None = None) -> None:
        """Say what is wrong with a field; an empty text: nothing is."""
        self.words.setText(text)
        self.words.setMinimumWidth(min(_FAULT_PX, self.words.fontMetrics().horizontalAdvance(text) + 2 * _INSIDE))
        self.point_at(field if text else None)

    def layer_of(self, target: QWidget) -> QWidget:
        """Return what scrolls with the field, so that both stay together."""
        content: QWidget | None = target.parentWidget()
        while content is not None and not content.isWindow():
            viewport: QWidget | None = content.parentWidget()
            scroll = viewport.parentWidget() if viewport is not None else None
            if isinstance(scroll, QScrollArea) and scroll.widget() is content:
                return content
            content = viewport
        return target.window()

    def is_in_the_way(self, place: QRect) -> bool:
        """Return whether it would lie over what has the keys."""
        keys, layer = QApplication.focusWidget(), self.parentWidget()
        if keys is None or layer is None or keys is self._target or not layer.isAncestorOf(keys):
            return False
        return place.intersects(QRect(keys.mapTo(layer, QPoint()), keys.size()))

    def _keys_moved(self) -> None:
        if self._target is not None:
            self.settle()
