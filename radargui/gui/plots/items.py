"""What plots are made of: curves, marks, bands and axes as these plots want them."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QRectF, Qt
from PySide6.QtGui import QColor, QFontMetricsF, QPainterPath, QPen
from PySide6.QtWidgets import QGraphicsEllipseItem, QGraphicsPathItem

from radargui.gui.layout import having
from radargui.model.arrays import FloatArray


class LiveCurve(pg.PlotCurveItem):  # type: ignore[misc] # pyqtgraph has no types
    """A curve that asks for the whole view: to look for its own bounds each frame took longer than to draw it."""

    def boundingRect(self) -> QRectF:  # noqa: N802 - Qt's name
        """Return what is seen."""
        view = self.getViewBox()
        return QRectF(super().boundingRect() if view is None else view.viewRect())


class ErrorBars(LiveCurve):
    """Bars about points: one line for all, which NaN breaks; a hundred items would take their time to draw."""

    def show_bars(self, x: FloatArray, y: FloatArray, half: FloatArray) -> None:
        """Draw bars from y - half to y + half, shape (n,) each."""
        self.setData(np.repeat(x, 3), np.stack([y - half, y + half, np.full(x.size, np.nan)], axis=1).ravel())


class Symbols(pg.PlotDataItem):  # type: ignore[misc] # pyqtgraph has no types
    """Symbols without an edge; nothing is done where they stand there already."""

    def setData(self, *args: Any, **options: Any) -> None:  # noqa: N802 - pyqtgraph's name
        """Set the places of the symbols."""
        if len(args) == 2 and not options:
            before = self.getOriginalDataset()
            none = before[0] is None
            if len(args[0]) == 0 if none else all(map(np.array_equal, args, before)):
                return
        super().setData(*args, **options)

    def setPen(self, pen: QPen) -> None:  # noqa: N802 - pyqtgraph's name
        """Take over a colour, without an edge."""
        self.setSymbolBrush(pen.color())


class Dot(QGraphicsEllipseItem):
    """One point that moves with every frame: Qt draws it alone, a hundred times faster than a set of symbols."""

    def __init__(self, size: int) -> None:
        super().__init__(-0.5 * size, -0.5 * size, size, size)
        self.setFlag(self.GraphicsItemFlag.ItemIgnoresTransformations)
        super().setPen(QPen(Qt.PenStyle.NoPen))
        self.hide()

    def setPen(self, pen: QPen | QColor | Qt.PenStyle) -> None:  # noqa: N802 - Qt's name
        """Take over a colour, without an edge."""
        self.setBrush(pg.mkPen(pen).color())

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
        self.setBrush(having(pg.mkPen(pen).color(), alpha=70))


_APART = 1.3
"""Least distance of numbers above one another, in heights of a digit: farther apart a low plot would show one alone."""
_BESIDE_PX = 5.0
"""Least room between numbers beside one another (chosen by hand): in less -1 and 0 are read as -10."""

_HEIGHT = 0.8
"""What a number above others takes of the height of a line (pyqtgraph's)."""
_FILLED = ((0, 0.8), (2, 0.6), (4, 0.4), (6, 0.2))
"""With so many numbers already there, finer ones are written too while all fill less than this share (pyqtgraph's)."""


class Axis(pg.AxisItem):  # type: ignore[misc] # pyqtgraph has no types
    """An `AxisItem` whose numbers have all as many decimals, and are never scaled by a prefix.

    It lays its words out only where they change.
    """

    def __init__(self, orientation: str) -> None:
        self._laid_out = ""
        self._decimals = 0
        super().__init__(orientation)
        self.autoSIPrefix = False

    def updateAutoSIPrefix(self) -> None:  # noqa: N802 - pyqtgraph's name
        """Leave the numbers as they are: pyqtgraph would keep a scale that it found once."""

    def _updateLabel(self) -> None:  # noqa: N802 - pyqtgraph's name
        # a new axis does so a dozen times, and that was a fifth of the time a window took
        words = self.labelString()
        if words != self._laid_out:
            self._laid_out = words
            super()._updateLabel()

    def tickSpacing(  # noqa: N802 - pyqtgraph's name
        self,
        minVal: float,
        maxVal: float,
        size: float,
    ) -> list[tuple[float, float]]:
        """Return spacings and offsets; numbers of a small plot stand farther apart, for pyqtgraph lets them overlap."""
        levels: list[tuple[float, float]] = super().tickSpacing(minVal, maxVal, size)
        if levels and size > 0.0:
            least = abs(maxVal - minVal) / size * self._room(minVal, maxVal, levels[0][0])
            if levels[0][0] < least:
                decade = 10.0 ** np.floor(np.log10(least))
                levels[0] = (decade * min(one for one in (1.0, 2.0, 5.0, 10.0) if one * decade >= least), 0.0)
        return levels

    def tickValues(  # noqa: N802 - pyqtgraph's name
        self,
        minVal: float,
        maxVal: float,
        size: float,
    ) -> list[tuple[float, list[float]]]:
        """Return spacing and places of each level of ticks; as many levels get numbers as have room."""
        levels: list[tuple[float, list[float]]] = super().tickValues(minVal, maxVal, size)
        # of a logarithmic axis pyqtgraph tells which have room
        self.style["textFillLimits"] = list(_FILLED) if self.logMode else []
        if levels and not self.logMode:
            self._choose_numbers(levels, minVal, maxVal, size)
        return levels

    def _choose_numbers(self, levels: list[tuple[float, list[float]]], low: float, high: float, size: float) -> None:
        """Find how far down ticks get numbers on `size` pixels, and the decimals that the finest of these need."""
        metrics = QFontMetricsF(self.style["tickFont"] or self.font())
        upright = self.orientation in ("left", "right")
        known, n_shown = list[float](), 0
        for depth, (spacing, own) in enumerate(levels):
            if not own:
                continue
            words = _written([*known, *own], self.scale, places := _decimals(spacing * self.scale))
            lengths = [_HEIGHT * metrics.height() if upright else metrics.horizontalAdvance(one) for one in words]
            places_px = [abs(value - low) / abs(high - low) * size for value in (*known, *own)]
            # what would be cut at an end of the axis is not written
            shown = [one for one, at in zip(lengths, places_px, strict=True) if 0.5 * one <= at <= size - 0.5 * one]
            full = any(n_shown >= count and sum(shown) / size >= most for count, most in _FILLED)
            if depth and (full or spacing / abs(high - low) * size < max(lengths) + _BESIDE_PX):
                break
            known, n_shown = [*known, *own], len(shown)
            self._decimals, self.style["maxTextLevel"] = places, depth

    def tickStrings(self, values: list[float], scale: float, spacing: float) -> list[str]:  # noqa: N802 - pyqtgraph's name
        """Return the numbers of ticks, all with as many decimals as the finest on the axis."""
        if self.logMode:
            return list(self.logTickStrings(values, scale, spacing))
        return _written(values, scale, self._decimals)

    def _room(self, low: float, high: float, spacing: float) -> float:
        """Return the least distance in pixels of numbers between two, of which each is `spacing` from the next."""
        metrics = QFontMetricsF(self.style["tickFont"] or self.font())
        if self.orientation in ("left", "right"):
            return _APART * metrics.capHeight()
        ends = [spacing * np.ceil(low / spacing), spacing * np.floor(high / spacing)]
        words = _written(ends, self.scale, _decimals(spacing * self.scale))
        return max(map(metrics.horizontalAdvance, words)) + _BESIDE_PX


def _written(values: Iterable[float], scale: float, places: int) -> list[str]:
    """Return numbers with so many decimals; what rounds to nothing has no sign."""
    return [f"{value * scale:z.{places}f}" for value in values]


def _decimals(spacing: float) -> int:
    """Return how many decimals tell numbers apart by a spacing of 1, 2 or 5 in a decade."""
    return max(0, math.ceil(-math.log10(spacing) - 1e-9))
