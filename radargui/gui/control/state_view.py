"""The state in letters that are read across the room, and what stands beside it."""

from __future__ import annotations

from PySide6.QtCore import QSize, Qt
from PySide6.QtGui import QColor, QFont, QFontMetricsF, QPainter, QPaintEvent
from PySide6.QtWidgets import QSizePolicy, QWidget

from radargui.gui.control.app_state import AppState
from radargui.gui.theme import Theme

_MOST_POINTS = 34.0
_LEAST_POINTS = 11.0


class StateView(QWidget):
    """A word for the state and what belongs to it, as large as fits."""

    def __init__(self, theme: Theme) -> None:
        super().__init__()
        self._theme = theme
        self._state = AppState.IDLE
        self._detail = ""
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        self.setMinimumHeight(58)
        self.setMinimumWidth(160)
        theme.changed.connect(self.update)

    @property
    def text(self) -> str:
        """What is shown."""
        return f"{self._state.value}   {self._detail}" if self._detail else self._state.value

    def show_state(self, state: AppState, detail: str = "") -> None:
        """Show a state and what belongs to it."""
        if (state, detail) != (self._state, self._detail):
            self._state, self._detail = state, detail
            self.setAccessibleName(self.text)
            self.update()

    def sizeHint(self) -> QSize:  # noqa: N802 - Qt's name
        """Return a size that fits most states."""
        return QSize(480, 60)

    def paintEvent(self, _event: QPaintEvent) -> None:  # noqa: N802 - Qt's name
        """Draw the word on its colour, the detail behind it."""
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        colours = self._theme.colours
        colour = QColor(self._colour())
        frame = self.rect().adjusted(2, 4, -2, -4)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(QColor(colours.base))
        painter.drawRoundedRect(frame, 6, 6)
        painter.setBrush(colour)
        painter.drawRoundedRect(frame.adjusted(0, 0, 10 - frame.width(), 0), 4, 4)
        inside = frame.adjusted(24, 0, -12, 0)
        painter.setFont(self._fitting(inside.width(), inside.height()))
        painter.setPen(colour)
        painter.drawText(inside, Qt.AlignmentFlag.AlignVCenter | Qt.AlignmentFlag.AlignLeft, self._state.value)
        if self._detail:
            word = QFontMetricsF(painter.font()).horizontalAdvance(self._state.value + "  ")
            painter.setPen(QColor(colours.text))
            font = painter.font()
            font.setBold(False)
            painter.setFont(font)
            rest = inside.adjusted(int(word), 0, 0, 0)
            painter.drawText(rest, Qt.AlignmentFlag.AlignVCenter | Qt.AlignmentFlag.AlignLeft, self._detail)
        painter.end()

    def _fitting(self, width: int, height: int) -> QFont:
        font = QFont(self.font())
        font.setBold(True)
        points = _MOST_POINTS
        while points > _LEAST_POINTS:
            font.setPointSizeF(points)
            metrics = QFontMetricsF(font)
            if metrics.horizontalAdvance(self.text) <= width and metrics.height() <= height:
                break
            points -= 1.0
        return font

    def _colour(self) -> str:
        colours = self._theme.colours
        match self._state:
            case AppState.DONE:
                return colours.good
            case AppState.RECORDING | AppState.FAILED:
                return colours.alarm
            case AppState.ARMED:
                return colours.mark
            case AppState.IDLE:
                return colours.idle
            case _:
                return colours.busy
