"""One scope: I and Q of a receiver against time, lost samples shaded."""

import numpy as np
import pyqtgraph as pg
from PySide6.QtGui import QColor

from radargui.gui.plots.plot import LAST, NOW, Plot
from radargui.gui.plots.ranges import SteadyRange
from radargui.gui.theme import Theme
from radargui.model.arrays import BoolArray, FloatArray

_MOST_BANDS = 12


class Scope(Plot):
    """Rolling view; the newest sample shown is at 0, the past to the left."""

    def __init__(self, theme: Theme, number: int, *, with_time: bool) -> None:
        self._bands: list[pg.LinearRegionItem] = []
        super().__init__(theme, LAST if with_time else "", f"Rx {number} [V]", live=True)
        # the same for all, so that one instant stands above the other
        left = self.getPlotItem().getAxis("left")
        left.setWidth(50)
        # on a small screen three of them share a hand's breadth: fewer figures, none upon another
        left.setTickDensity(0.6)
        self._with_time = with_time
        self._range = SteadyRange()
        self._curves = (self.fast_line("i"), self.fast_line("q"))
        self.setYRange(-1.0, 1.0, padding=0)
        self.set_window(3.0)

    def follow(self, now: bool) -> None:
        """Say on the axis whether its right edge is now."""
        if self._with_time:
            self.relabel(NOW if now else LAST)

    def set_window(self, seconds: float) -> None:
        """Show so many seconds."""
        self.setXRange(-seconds, 0.0, padding=0)

    def draw(self, time_s: FloatArray, volts: FloatArray, lost: BoolArray) -> None:
        """Draw minimum and maximum of each pixel column.

        Parameters
        ----------
        time_s
            Shape (2 n,), 0 is now.
        volts
            I and Q, shape (2, 2 n).
        lost
            Whether samples of the column were lost, shape (n,).
        """
        for curve, values in zip(self._curves, volts, strict=True):
            curve.setData(time_s, values)
        known = volts[np.isfinite(volts)]
        if known.size and self._range.fit(float(known.min()), float(known.max())):
            self.setYRange(*self._range.span, padding=0)
        self._shade(time_s, lost)

    def clear_data(self) -> None:
        """Show nothing."""
        for curve in self._curves:
            curve.setData([], [])
        for band in self._bands:
            band.setVisible(False)

    @property
    def points(self) -> int:
        """How many points each curve is drawn with."""
        return min(curve.xData.size if curve.xData is not None else 0 for curve in self._curves)

    @property
    def shaded(self) -> int:
        """How many gaps are shaded."""
        return sum(band.isVisible() for band in self._bands)

    def retheme(self) -> None:
        """Take over the colours of the theme."""
        super().retheme()
        for band in self._bands:
            band.setBrush(self._gap_colour())

    def _gap_colour(self) -> QColor:
        colour = QColor(self.colour("gap"))
        colour.setAlpha(150)
        return colour

    def _shade(self, time_s: FloatArray, lost: BoolArray) -> None:
        edges = np.flatnonzero(np.diff(np.concatenate(([False], lost, [False])).astype(np.int8)))
        spans = list(zip(edges[::2], edges[1::2], strict=True))[-_MOST_BANDS:]
        while len(self._bands) < len(spans):
            band = pg.LinearRegionItem(movable=False, brush=self._gap_colour(), pen=pg.mkPen(None))
            band.setZValue(-10)
            self.addItem(band, ignoreBounds=True)
            self._bands.append(band)
        width = time_s[2] - time_s[0] if time_s.size > 2 else 0.0
        for band, span in zip(self._bands, spans, strict=False):
            first, last = span
            band.setRegion((time_s[2 * first] - 0.5 * width, time_s[2 * last - 1] + 0.5 * width))
            band.setVisible(True)
        for band in self._bands[len(spans) :]:
            band.setVisible(False)
