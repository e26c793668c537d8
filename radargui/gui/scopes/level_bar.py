"""The level of one channel against the range of its converter, with a light for clipping."""

from __future__ import annotations

from PySide6.QtCore import QRectF, QSize, Qt
from PySide6.QtGui import QColor, QPainter, QPaintEvent
from PySide6.QtWidgets import QWidget

from radargui.acquisition.level import Level
from radargui.gui.theme import Theme, scaled_font

_HOLD_LOOKS = 5


class LevelBar(QWidget):
    """A bar from 0 to full scale; clipping is said by a word and stays readable for a second."""

    def __init__(self, theme: Theme, name: str, role: str, full_scale_v: float) -> None:
        super().__init__()
        self._theme = theme
        self._name = name
        self._role = role
        self._full_scale_v = full_scale_v
        self._peak_v: float | None = None
        self._held = 0
        self.setFont(scaled_font(self.font(), 0.85))
        self.setMinimumSize(self.sizeHint())
        theme.changed.connect(self.update)

    def sizeHint(self) -> QSize:  # noqa: N802 - Qt's name
        """Return the size that fits name, voltage and bar."""
        metrics = self.fontMetrics()
        return QSize(metrics.horizontalAdvance("I1 00.00 V") + 12, 2 * metrics.height() + 8)

    @property
    def clipping(self) -> bool:
        """Whether the light is on."""
        return self._held > 0

    def show_level(self, level: Level | None) -> None:
        """Show a level; None: nothing is known."""
        clipped = level is not None and level.clipped
        self._held = _HOLD_LOOKS if clipped else max(0, self._held - 1)
        self._peak_v = None if level is None else level.peak_v
        if level is None:
            self._held = 0
        elif level.full_scale_v:
            self._full_scale_v = level.full_scale_v
        share = "" if self._peak_v is None else f"{100 * self._peak_v / self._full_scale_v:.0f} % of the range"
        self.setToolTip(f"{self._name}: {share}{', clipping: lower the gain or raise the range' * self.clipping}")
        self.update()

    def paintEvent(self, _event: QPaintEvent) -> None:  # noqa: N802 - Qt's name
        """Draw name, voltage and bar."""
        colours = self._theme.colours
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        height = self.fontMetrics().height()
        top = QRectF(4, 1, self.width() - 8, height)
        value = "–" if self._peak_v is None else f"{self._peak_v:.2f} V"
        painter.setPen(QColor(colours.alarm if self.clipping else colours.text))
        painter.drawText(top, Qt.AlignmentFlag.AlignLeft, self._name)
        painter.drawText(top, Qt.AlignmentFlag.AlignRight, "CLIP" if self.clipping else value)
        bar = QRectF(4, height + 4, self.width() - 8, max(6.0, 0.5 * height))
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(QColor(colours.raised))
        painter.drawRoundedRect(bar, 3, 3)
        share = 0.0 if self._peak_v is None else min(1.0, self._peak_v / self._full_scale_v)
        if share > 0.0:
            bar.setWidth(max(4.0, bar.width() * share))
            painter.setBrush(QColor(colours.alarm if self.clipping else colours.role(self._role)))
            painter.drawRoundedRect(bar, 3, 3)
        painter.end()
