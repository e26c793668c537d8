"""The IQ planes, one column a receiver: as the converter gave it above, corrected onto the unit circle below."""

import numpy as np
from PySide6.QtCore import QMargins, QSize
from PySide6.QtGui import QFont, QFontMetricsF, QResizeEvent
from PySide6.QtWidgets import QGridLayout

from radargui.acquisition.envelope import thin
from radargui.gui.control.state import Feed
from radargui.gui.layout import having, take_out
from radargui.gui.plots.plot import PerReceiver, Plot
from radargui.gui.theme import Theme, inside_pt, scaled_px
from radargui.model.arrays import FloatArray

SPAN_S = 1.5
"""Shown at once: some turns of the circle, of a slow hand too, before they cover one another."""
_POINTS = 1200
"""Of each plane: as many as its circle has pixels."""


_LEFT, _BARE = 36, 4
"""Room for "-0.05", the same always: where words that come and go made it, equal units turned it into other words. And
where there are none."""
_NARROW = 90
"""Pixels of width or height below which a plane has no figures (chosen by hand): they would leave a third of it to
the circle."""
_LEAST = QSize(56, 56)
"""Of a plane: four beside each other fit the panel on a screen of 1366 pixels."""


class IQPlane(Plot):
    """Q upwards against I, equal units on both axes."""

    def __init__(self, theme: Theme, number: int, *, corrected: bool) -> None:
        super().__init__(theme, left_px=_LEFT, equal=True, live=True)
        # axis words or a title would take half of so small a plot
        self._number, self._corrected = number, corrected
        self._write_name()
        if corrected:
            turn = np.linspace(0.0, 2.0 * np.pi, 181)
            self.fast_line("faint", dashed=True).setData(np.cos(turn), np.sin(turn))
        self._curve = self.fast_line(f"receivers.{number - 1}", "Q")
        self._now = self.dot("text")
        self._axes = ("I / A", "Q / A") if corrected else ("I [V]", "Q [V]")
        tips = "As the converter gave it, in volts", "Corrected, in units of its amplitude A: the unit circle (dashed)"
        self.setToolTip(tips[corrected])
        self.setMinimumSize(_LEAST)
        self._show(1.3)
        self.view.sigResized.connect(self._resized)

    def words(self, axis: str) -> str:
        """Return what an axis shows; too small a plot to write it there."""
        return self._axes[axis == "left"]

    def resizeEvent(self, event: QResizeEvent | None) -> None:  # noqa: N802 - Qt's name
        """Leave the figures out where there is no room for them."""
        item, narrow = self.getPlotItem(), min(self.width(), self.height()) < scaled_px(_NARROW)
        # pyqtgraph calls it while it makes the plot, and Qt when that is closed
        if item is not None:
            for name in ("left", "bottom"):
                item.getAxis(name).setStyle(showValues=not narrow)
            item.getAxis("left").setWidth(_BARE if narrow else scaled_px(_LEFT))
            # half of the outermost figure, and that is one digit
            item.layout.setContentsMargins(2, 7, 2 if narrow else 8, 2)
        super().resizeEvent(event)

    def _write_name(self) -> None:
        """Write which receiver it is, and in which unit where there is room for that."""
        short = f"Rx {self._number}"
        long = f"{short} {'/ A' if self._corrected else '[V]'}"
        metrics = QFontMetricsF(having(QFont(self.font()), pointSize=inside_pt()))
        self.write_inside(long if metrics.horizontalAdvance(long) + 8 <= self.view.width() else short)

    def _resized(self, _view: object) -> None:
        self._write_name()
        # the words above take pixels, whatever the range
        self._show(self._half)

    def draw(self, i: FloatArray, q: FloatArray) -> None:
        """Draw points in time order, shape (n,) each; NaN is left out."""
        self._curve.setData(i, q)
        known = np.isfinite(i) & np.isfinite(q)
        last = np.flatnonzero(known)[-1:]
        self._now.show_at(i[last], q[last])
        if self._corrected or not last.size:
            return
        reach = float(np.hypot(i[known], q[known]).max())
        if self.steady.fit(-reach, reach):
            self._show(self.steady.half)

    def _show(self, half: float) -> None:
        """Show a square of that half width beneath the words."""
        self._half, words = half, self.height_inside
        top = half * (1.0 + 2.0 * words / max(self.view.height() - words, words))
        self.setRange(xRange=(-half, half), yRange=(-half, top), padding=0)


class IQPlanePanel(PerReceiver):
    """The latest second and a half of each receiver."""

    def __init__(self, theme: Theme) -> None:
        super().__init__()
        self._theme = theme
        self._feed: Feed | None = None
        self._drawn = -1
        self.raw: list[IQPlane] = []
        self.corrected: list[IQPlane] = []
        self._grid = having(QGridLayout(self), contentsMargins=QMargins(2, 2, 2, 2), spacing=2)

    def make_plots(self, count: int) -> None:
        """Make two planes a receiver."""
        take_out(self._grid, *self.raw, *self.corrected)
        self.raw, self.corrected = (
            [IQPlane(self._theme, number + 1, corrected=corrected) for number in range(count)]
            for corrected in (False, True)
        )
        for row, planes in enumerate((self.raw, self.corrected)):
            for column, plane in enumerate(planes):
                self._grid.addWidget(plane, row, column)

    def show_feed(self, feed: Feed | None) -> None:
        """Show another acquisition; None keeps the last picture."""
        self._feed = feed
        self._drawn = -1
        if feed is not None:
            self.set_receivers(feed.n_receivers)
            self.clear()

    def clear(self) -> None:
        """Forget what was shown."""
        for plane in (*self.raw, *self.corrected):
            plane.draw(np.empty(0), np.empty(0))

    def refresh(self) -> None:
        """Draw the latest points; called by the window."""
        feed = self._feed
        if feed is None or not self.isVisible() or feed.ring.latest == self._drawn:
            return
        self._drawn, count = feed.ring.latest, feed.samples(SPAN_S)
        volts = feed.ring.thinned(count, _POINTS)
        _draw(self.raw, volts[0::2], volts[1::2])
        if feed.live is not None:
            span = feed.live.since(max(0, feed.live.latest - count))
            _draw(self.corrected, thin(span.i, _POINTS), thin(span.q, _POINTS))


def _draw(planes: list[IQPlane], i: FloatArray, q: FloatArray) -> None:
    """Draw points, shape (n_receivers, n) each, where there are any."""
    for plane, *point in zip(planes, i, q, strict=False):
        if point[0].size:
            plane.draw(*point)
