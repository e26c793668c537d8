"""Which colour is which value: the colours of a map between the words of its ends."""

import numpy as np
from PySide6.QtCore import QPointF, QRectF
from PySide6.QtGui import QColor, QLinearGradient, QPainter, QPaintEvent
from PySide6.QtWidgets import QSizePolicy, QWidget

from radargui.model.arrays import FloatArray


class ColourBar(QWidget):
    """From which to which value the colours go; as high as a line of words."""

    def __init__(self, tip: str) -> None:
        super().__init__()
        self.ends = ("", "")
        self._table: FloatArray = np.empty((0, 4))
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        self.setFixedHeight(self.fontMetrics().height() + 4)
        self.setToolTip(tip)

    def show_ends(self, table: FloatArray, low: str, high: str) -> None:
        """Show colours, red, green, blue, alpha from 0 to 1, shape (n, 4), and what the first and the last mean."""
        self._table, self.ends = table, (low, high)
        self.update()

    def paintEvent(self, _event: QPaintEvent) -> None:  # noqa: N802 - Qt's name
        """Draw the colours between two values."""
        painter, metrics = QPainter(self), self.fontMetrics()
        left, right = (metrics.horizontalAdvance(end) + 6.0 for end in self.ends)
        bar = QRectF(left, 3.0, self.width() - left - right, self.height() - 6.0)
        gradient = QLinearGradient(bar.topLeft(), bar.topRight())
        for stop, colour in zip(np.linspace(0.0, 1.0, len(self._table)), self._table, strict=True):
            gradient.setColorAt(stop, QColor.fromRgbF(*colour))
        painter.fillRect(bar, gradient)
        painter.setPen(self.palette().windowText().color())
        foot = self.height() - metrics.descent() - 2.0
        painter.drawText(QPointF(2.0, foot), self.ends[0])
        painter.drawText(QPointF(self.width() - right + 4.0, foot), self.ends[1])
        painter.end()
