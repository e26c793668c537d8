"""Speed as colour: a perceptually uniform map, and a trail drawn in it."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pyqtgraph as pg
from numpy.typing import NDArray
from pyqtgraph.Qt.internals import PrimitiveArray
from PySide6.QtCore import QLineF, QPointF, QRectF
from PySide6.QtGui import QColor, QPainter, QPen

from radargui.gui.plots.plot import round_up
from radargui.gui.theme import Theme
from radargui.gui.track.shown_track import ShownTrack, Space
from radargui.model.arrays import FloatArray, IntArray

N_COLOURS = 16
"""Steps of speed: each is a path of its own; more are not told apart by eye."""
_SPANS = {False: (0.0, 0.88), True: (0.3, 1.0)}
"""Part of the map that stands out from a light and from a dark background (chosen by eye)."""


def segments(points: NDArray[Any]) -> IntArray:
    """Return the ends of the pieces of a line through points (n, 3) as pairs of indices, shape (2 m,).

    Pairs that touch NaN are left out.
    """
    known = np.isfinite(points).all(axis=1)
    first = np.flatnonzero(known[:-1] & known[1:])
    return np.stack([first, first + 1], axis=1).ravel()


class SpeedColours:
    """Colours of speeds from 0 to `max_m_s`, which the fall in a field of view reaches."""

    def __init__(self, theme: Theme) -> None:
        self.max_m_s = 1.0
        self._theme = theme
        self._pens: tuple[str, list[QPen]] = "", []
        # of matplotlib: equal steps of speed look equally large, also to colour-blind eyes
        self._map = pg.colormap.get("viridis")

    def fit(self, space: Space, track: ShownTrack | None = None) -> None:
        """Reach as far as a fall through the space does, or a track where that is faster."""
        fall_m = max(0.0, float(space.high_mm[2]) - space.floor_mm) / 1000.0
        known = track.speed_m_s[np.isfinite(track.speed_m_s)] if track else np.empty(0)
        self.max_m_s = round_up(max(float(np.sqrt(2.0 * space.gravity_m_s2 * fall_m)), known.max(initial=0.1)))

    def steps(self, speed_m_s: FloatArray) -> IntArray:
        """Return the number of each speed's colour, shape (n,); an unknown speed counts as rest."""
        share = np.nan_to_num(speed_m_s / self.max_m_s, nan=0.0)
        return np.clip((share * N_COLOURS).astype(np.intp), 0, N_COLOURS - 1)

    def pieces(self, track: ShownTrack) -> dict[int, IntArray]:
        """Return the pieces of a track by the number of their colour, as pairs of the indices of their ends.

        Unknown points break it; each piece has the colour of the speed at its end.
        """
        ends = segments(track.position_mm.T).reshape(-1, 2)
        step = self.steps(track.speed_m_s[ends[:, 1]])
        order = np.argsort(step, kind="stable")
        numbers, at = np.unique(step[order], return_index=True)
        parts = np.split(ends[order], at[1:])
        return {int(number): part.ravel() for number, part in zip(numbers, parts, strict=True)} if ends.size else {}

    def pens(self) -> list[QPen]:
        """Return a pen of each colour, cosmetic: as wide at any zoom."""
        base = self._theme.colours.base
        if self._pens[0] != base:
            self._pens = base, [pg.mkPen(QColor.fromRgbF(*one), width=1) for one in self.table()]
        return self._pens[1]

    def table(self) -> FloatArray:
        """Return the colours in the present look, red, green, blue, alpha from 0 to 1, shape (N_COLOURS, 4)."""
        low, high = _SPANS[QColor(self._theme.colours.base).lightness() < 128]
        return np.asarray(self._map.map(np.linspace(low, high, N_COLOURS), mode="float"), dtype=np.float64)


class SpeedTrail(pg.GraphicsObject):  # type: ignore[misc] # pyqtgraph has no types
    """A line in the colours of its speed: drawn nearly as fast as in one."""

    def __init__(self, colours: SpeedColours) -> None:
        super().__init__()
        self._colours = colours
        self._bounds = QRectF()
        self.lines: dict[int, PrimitiveArray] = {}

    def show_trail(self, x: FloatArray, y: FloatArray, pieces: Mapping[int, IntArray]) -> None:
        """Draw a line through x, y, shape (n,), by its `pieces`."""
        self.lines, places = {}, np.stack([x, y], axis=1)
        for step, ends in pieces.items():
            self.lines[step] = made = PrimitiveArray(QLineF, 4)
            made.resize(ends.size // 2)
            made.ndarray()[:] = places[ends].reshape(-1, 4)
        self.prepareGeometryChange()
        self._bounds = QRectF()
        if pieces:
            low, high = np.nanmin(places, axis=0), np.nanmax(places, axis=0)
            self._bounds = QRectF(QPointF(*low), QPointF(*high)).adjusted(-1.0, -1.0, 1.0, 1.0)
        self.update()

    def boundingRect(self) -> QRectF:  # noqa: N802 - Qt's name
        """Return what it covers."""
        return self._bounds

    def paint(self, painter: QPainter, *_: object) -> None:
        """Draw the lines colour by colour."""
        pens = self._colours.pens()
        for number, lines in self.lines.items():
            painter.setPen(pens[number])
            painter.drawLines(*lines.drawargs())
