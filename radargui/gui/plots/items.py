"""What plots are drawn of where pyqtgraph's own items take too long for thirty pictures a second."""

from __future__ import annotations

from typing import Any

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QRectF, QSignalBlocker, Qt
from PySide6.QtGui import QColor, QPen
from PySide6.QtWidgets import QGraphicsEllipseItem

from radargui.model.arrays import FloatArray


class LiveCurve(pg.PlotCurveItem):  # type: ignore[misc] # pyqtgraph has no types
    """A curve that asks for the whole view: to look for its own bounds each frame took longer than to draw it."""

    def boundingRect(self) -> QRectF:  # noqa: N802 - Qt's name
        """Return what is seen."""
        view = self.getViewBox()
        return QRectF(super().boundingRect() if view is None else view.viewRect())


class Marker(pg.PlotDataItem):  # type: ignore[misc] # pyqtgraph has no types
    """Symbols; nothing is done where there were none and are none."""

    def setData(self, *args: Any, **options: Any) -> None:  # noqa: N802 - pyqtgraph's name
        """Set the places of the symbols."""
        if not (len(args) == 2 and not options and len(args[0]) == 0 and self.getOriginalDataset()[0] is None):
            super().setData(*args, **options)


class Dot(QGraphicsEllipseItem):
    """One point that moves with every frame: Qt draws it alone, a hundred times faster than a set of symbols."""

    def __init__(self, size: int) -> None:
        super().__init__(-0.5 * size, -0.5 * size, size, size)
        self.setFlag(self.GraphicsItemFlag.ItemIgnoresTransformations)
        self.setPen(QPen(Qt.PenStyle.NoPen))
        self.hide()

    def show_at(self, x: FloatArray, y: FloatArray) -> None:
        """Show it at the only point of x and y, shape (1,) each; empty: nowhere."""
        self.setVisible(len(x) == 1)
        if len(x) == 1:
            self.setPos(float(x[0]), float(y[0]))


class Band(pg.FillBetweenItem):  # type: ignore[misc] # pyqtgraph has no types
    """The room between two curves, as a shade of its colour; NaN breaks it."""

    def __init__(self) -> None:
        self._ends = pg.PlotCurveItem(connect="finite"), pg.PlotCurveItem(connect="finite")
        super().__init__(*self._ends)

    def show_band(self, x: FloatArray, low: FloatArray, high: FloatArray) -> None:
        """Shade from low to high, each shape (n,)."""
        known = np.isfinite(low + high)
        # the shade is made once, when both are there
        with QSignalBlocker(self._ends[0]):
            self._ends[0].setData(x, np.where(known, low, np.nan))
        self._ends[1].setData(x, np.where(known, high, np.nan))

    def setPen(self, pen: QPen | None) -> None:  # noqa: N802 - Qt's name
        """Take over a colour, without an edge."""
        shade = QColor(pg.mkPen(pen).color())
        shade.setAlpha(70)
        self.setBrush(shade)
        super().setPen(pg.mkPen(None))
