"""What plots are drawn of where pyqtgraph's own items take too long for thirty pictures a second."""

from __future__ import annotations

from typing import Any

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QRectF, Qt
from PySide6.QtGui import QColor, QPainterPath, QPen
from PySide6.QtWidgets import QGraphicsEllipseItem, QGraphicsPathItem

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


class Band(QGraphicsPathItem):
    """The room between two curves, as a shade of its colour; NaN breaks it.

    pyqtgraph's own item makes a path of each curve, polygons of the paths and a path of the polygons: 12 ms for the
    3000 points of a result, in the thread that draws.
    """

    def __init__(self) -> None:
        super().__init__()
        super().setPen(QPen(Qt.PenStyle.NoPen))
        # behind the curve
        self.setZValue(-1.0)

    def show_band(self, x: FloatArray, low: FloatArray, high: FloatArray) -> None:
        """Shade from low to high, each shape (n,)."""
        known = np.flatnonzero(np.isfinite(low + high))
        gap, outline = np.full((2, 1), np.nan), [np.empty((2, 0))]
        for part in np.split(known, np.flatnonzero(np.diff(known) > 1) + 1):
            # there along one curve and back along the other: a shade closes by itself
            there, back = np.stack([x[part], low[part]]), np.stack([x[part], high[part]])[:, ::-1]
            outline += [there, back, gap]
        path = pg.arrayToQPath(*np.concatenate(outline, axis=1), connect="finite") if known.size else QPainterPath()
        self.setPath(path)

    def setPen(self, pen: QPen | QColor | Qt.PenStyle) -> None:  # noqa: N802 - Qt's name
        """Take over a colour, without an edge."""
        shade = pg.mkPen(pen).color()
        shade.setAlpha(70)
        self.setBrush(shade)
