"""The panel of the IQ planes: raw above, corrected below, one column a receiver."""

from __future__ import annotations

import numpy as np
from PySide6.QtWidgets import QGridLayout, QWidget

from radargui.gui.control.feed import Feed
from radargui.gui.plots.envelope import thin
from radargui.gui.scopes.iq_plane import IQPlane
from radargui.gui.theme import Theme

SPAN_S = 1.5
_POINTS = 1200
_EVERY = 2


class IQPlanePanel(QWidget):
    """The latest second and a half of each receiver."""

    def __init__(self, theme: Theme) -> None:
        super().__init__()
        self._theme = theme
        self._feed: Feed | None = None
        self._frame = 0
        self._drawn = -1
        self.paused = False
        self.raw: list[IQPlane] = []
        self.corrected: list[IQPlane] = []
        self._grid = QGridLayout(self)
        self._grid.setContentsMargins(2, 2, 2, 2)
        self._grid.setSpacing(2)

    def set_receivers(self, count: int) -> None:
        """Show so many receivers."""
        if count == len(self.raw):
            return
        for plane in (*self.raw, *self.corrected):
            self._grid.removeWidget(plane)
            plane.hide()
            plane.deleteLater()
        self.raw = [IQPlane(self._theme, number + 1, corrected=False) for number in range(count)]
        self.corrected = [IQPlane(self._theme, number + 1, corrected=True) for number in range(count)]
        for column, planes in enumerate(zip(self.raw, self.corrected, strict=True)):
            for row, plane in enumerate(planes):
                self._grid.addWidget(plane, row, column)

    def set_paused(self, paused: bool) -> None:
        """Hold the picture, or let it go on."""
        self.paused = paused

    def show_feed(self, feed: Feed | None) -> None:
        """Show another acquisition; None keeps the last picture."""
        self._feed = feed
        self._drawn = -1
        if feed is not None:
            self.set_receivers(feed.n_receivers)
            for plane in (*self.raw, *self.corrected):
                plane.clear_data()

    def refresh(self) -> None:
        """Draw the latest points; called by the window's timer."""
        feed = self._feed
        self._frame += 1
        if feed is None or feed.ring is None or self.paused or not self.isVisible() or self._frame % _EVERY:
            return
        if feed.ring.latest == self._drawn:
            return
        self._drawn = feed.ring.latest
        volts = thin(feed.ring.recent(feed.samples(SPAN_S)).volts, _POINTS)
        if volts.shape[1]:
            for number, plane in enumerate(self.raw):
                plane.draw(volts[2 * number], volts[2 * number + 1])
        live = feed.live
        if live is None:
            return
        span = live.since(max(0, live.latest - feed.samples(SPAN_S)))
        if span.index.size:
            both = thin(np.concatenate([span.i, span.q]), _POINTS)
            for number, plane in enumerate(self.corrected):
                plane.draw(both[number], both[feed.n_receivers + number])
