"""The level of one channel: a bar from 0 to full scale, with a word where it clips."""

from __future__ import annotations

from PySide6.QtCore import QRectF
from PySide6.QtGui import QColor, QPainter, QPaintEvent
from PySide6.QtWidgets import QLabel, QVBoxLayout, QWidget

from radargui.acquisition.run_output import Level
from radargui.gui.layout import fill
from radargui.gui.theme import Theme, scaled_font

_HOLD_LOOKS = 5
_BAR_PX = 7


class _Bar(QWidget):
    """A share of a length: drawn in a tenth of the time that a progress bar with a style takes, five times a second."""

    def __init__(self) -> None:
        super().__init__()
        self.setFixedHeight(_BAR_PX)
        self.share = 0.0
        self.colours = "", ""

    def paintEvent(self, _event: QPaintEvent) -> None:  # noqa: N802 - Qt's name
        """Draw it."""
        room, (behind, colour) = QRectF(self.rect()), self.colours
        painter = QPainter(self)
        painter.fillRect(room, QColor(behind))
        painter.fillRect(QRectF(0.0, 0.0, self.share * room.width(), room.height()), QColor(colour))
        painter.end()


class LevelBar(QWidget):
    """A bar from 0 to full scale; clipping is said by a word and stays readable for a second."""

    def __init__(self, theme: Theme, name: str, role: str, full_scale_v: float) -> None:
        super().__init__()
        self._theme, self.name, self._role, self._full_scale_v = theme, name, role, full_scale_v
        self._held = 0
        self._peak_v: float | None = None
        self._words, self._bar = QLabel(), _Bar()
        self._words.setFont(scaled_font(self.font(), 0.85))
        self.setFixedWidth(self.fontMetrics().horizontalAdvance("I1 00.00 V") + 8)
        fill(QVBoxLayout(self), self._words, self._bar, margins=(4, 1, 4, 1), spacing=1)
        theme.changed.connect(self._paint)
        self.show_level(None)

    @property
    def clipping(self) -> bool:
        """Whether the light is on."""
        return self._held > 0

    def show_level(self, level: Level | None) -> None:
        """Show a level; None: nothing is known."""
        clipped = level is not None and level.clipped
        self._held = _HOLD_LOOKS if clipped else max(0, self._held - 1) if level is not None else 0
        self._peak_v = None if level is None else level.peak_v
        self._full_scale_v = (level and level.full_scale_v) or self._full_scale_v
        share = (self._peak_v or 0.0) / self._full_scale_v
        peak, said = ("–", "") if level is None else (f"{self._peak_v:.2f} V", f"{100.0 * share:.0f} % of the range")
        self.setToolTip(f"{self.name}: {said}{', clipping: lower the gain or raise the range' * self.clipping}")
        self._words.setText(f"{self.name} {'CLIP' if self.clipping else peak}")
        self._bar.share = min(1.0, share)
        self._paint()

    def _paint(self) -> None:
        colours, alarm = self._theme.colours, self._theme.colours.alarm
        colour = alarm if self.clipping else colours.role(self._role)
        self._bar.colours = colours.raised, colour
        self._bar.update()
        sheet = f"QLabel {{ color: {alarm if self.clipping else colours.text}; }}"
        # a sheet that is set anew is read anew
        if sheet != self.styleSheet():
            self.setStyleSheet(sheet)
