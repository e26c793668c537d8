"""The track in space by OpenGL; made only where the test of OpenGL said yes."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pyqtgraph.opengl as gl
from numpy.typing import NDArray
from PySide6.QtCore import Qt
from PySide6.QtGui import QColor, QFont, QResizeEvent, QVector3D, QWheelEvent

from radargui.gui.full_view import FILLS
from radargui.gui.theme import Theme
from radargui.gui.track.shown_track import NO_TRACK, ShownTrack, Space
from radargui.gui.track.speed_colours import SpeedColours, segments
from radargui.model.arrays import BoolArray, FloatArray

Points = NDArray[np.float32]
"""Shape (n, 3) in mm, as OpenGL takes them."""
_GRID_MM = 50.0
"""From line to line on the floor: six squares across the field of view, every other line at a figure of the axes."""
_LOW_PX = 200
"""Height below which only the axes have names (chosen by hand): numbers and antennas would lie upon another."""
_AT = Qt.AlignmentFlag
_BESIDE = (_AT.AlignHCenter | _AT.AlignTop, _AT.AlignRight | _AT.AlignVCenter, _AT.AlignRight | _AT.AlignVCenter)
"""Where the figures of x, y and z stand as the view is at first: below the floor's front edge, left of the others."""
_AWAY = _AT.AlignLeft | _AT.AlignBottom
_NAMED = np.array([(1.0, 0.0, 0.0), (0.0, 0.0, 1.0), (0.0, 0.0, 1.0)])
"""Towards where their names stand, from the end of each axis: that of y above the far edge of the floor."""
_APART_MM = (14.0, 28.0)
"""So far (chosen by hand), in a low view the more: there a pixel is more of it."""
_CORNER_MM = 60.0
"""Figures of y come so near to the corner no more (chosen by hand): there those of z stand."""
_STEP_MM = 4.0
"""Least way from point to point of a line (chosen by hand): shorter ones show as dots, longer ones cut the bounces."""


class SpaceView(gl.GLViewWidget):  # type: ignore[misc] # pyqtgraph has no types
    """Box with floor, axes and directions to the antennas; trail, sphere and impacts in it."""

    def __init__(self, theme: Theme, colours: SpeedColours, space: Space) -> None:
        super().__init__()
        self.setProperty(FILLS, True)
        self._theme, self._colours, self._space = theme, colours, space
        self._track = NO_TRACK
        self._fixed: list[Any] = []
        self._distance_chosen = self._is_low = False
        # sizes are in pixels of the screen, which are small on a fine one
        fine = self.devicePixelRatioF()
        self._trail = gl.GLLinePlotItem(width=2.0 * fine, mode="lines", glOptions="opaque")
        self._impacts = gl.GLScatterPlotItem(size=9.0 * fine, pxMode=True, glOptions="translucent")
        self._sphere = gl.GLScatterPlotItem(size=14.0 * fine, pxMode=True, glOptions="translucent")
        self._shadow = gl.GLLinePlotItem(width=fine, mode="lines", glOptions="translucent")
        for item in (self._shadow, self._trail, self._impacts, self._sphere):
            self.addItem(item)
        # as low as the projections: the panel need not scroll for it
        self.setMinimumSize(160, 86)
        self.setCameraPosition(elevation=16, azimuth=-78)
        theme.changed.connect(self._retheme)
        self._retheme()

    def show_space(self, space: Space) -> None:
        """Show another field of view."""
        self._space = space
        self._build()
        self.opts["center"] = QVector3D(*(0.5 * (space.low_mm + space.high_mm)))
        self._fit()
        self.update()

    def resizeEvent(self, event: QResizeEvent) -> None:  # noqa: N802 - Qt's name
        """Keep the whole box in sight until the operator has moved the view."""
        super().resizeEvent(event)
        self._fit()
        if self._is_low != (self.height() < _LOW_PX):
            self._build()

    def wheelEvent(self, event: QWheelEvent) -> None:  # noqa: N802 - Qt's name
        """Move nearer or away; from now on the distance is the operator's."""
        self._distance_chosen = True
        super().wheelEvent(event)

    def _fit(self) -> None:
        if self._distance_chosen or self.height() == 0:
            return
        half_width = math.tan(math.radians(0.5 * self.opts["fov"]))
        aspect = max(1.0, self.width() / self.height())
        self.opts["distance"] = 0.8 * float(self._space.size_mm.max()) * aspect / half_width

    def look_as(self, other: SpaceView) -> None:
        """Look from where another view looks; from as far only where the operator chose that."""
        names = ("elevation", "azimuth", *(["distance"] if other._distance_chosen else []))
        self.opts |= {name: other.opts[name] for name in names}
        self._distance_chosen = other._distance_chosen
        self.update()

    def show_track(self, track: ShownTrack) -> None:
        """Draw a track."""
        self._track = track
        points = track.position_mm.T.astype(np.float32)
        kept = spaced(points)
        points = points[kept]
        shades = self._colours.table().astype(np.float32)[self._colours.steps(track.speed_m_s[kept])]
        self._draw_line(self._trail, points, shades)
        shadow = points.copy()
        shadow[:, 2] = self._space.floor_mm
        self._draw_line(self._shadow, shadow, self._rgba("faint", 0.6))
        self._sphere.setData(pos=track.sphere_mm.T.astype(np.float32), color=self._rgba("text"))
        impacts = track.impact_mm.T.astype(np.float32)
        self._impacts.setData(pos=impacts[np.isfinite(impacts).all(axis=1)], color=self._rgba("mark"))

    def show_sphere(self, place_mm: FloatArray) -> None:
        """Draw the sphere elsewhere, shape (3, 1)."""
        self._sphere.setData(pos=place_mm.T.astype(np.float32), color=self._rgba("text"))

    @staticmethod
    def _draw_line(item: Any, points: Points, colour: tuple[float, float, float, float] | Points) -> None:
        """Draw a line in one colour, or in one a point, shape (n, 4)."""
        if np.isfinite(points).all() and len(points) > 1:
            # drawn in one piece: joints of single pieces show as dots
            item.setData(pos=points, color=colour, mode="line_strip")
        else:
            pairs = segments(points)
            shades = colour[pairs] if isinstance(colour, np.ndarray) else colour
            item.setData(pos=np.ascontiguousarray(points[pairs]), color=shades, mode="lines")

    def _retheme(self) -> None:
        self.setBackgroundColor(self._theme.colours.base)
        self._build()
        self.show_track(self._track)

    def _rgba(self, role: str, alpha: float = 1.0) -> tuple[float, float, float, float]:
        colour = QColor(self._theme.colours.role(role))
        return (colour.redF(), colour.greenF(), colour.blueF(), alpha)

    def _build(self) -> None:
        space = self._space
        for item in self._fixed:
            self.removeItem(item)
        self._is_low = self.height() < _LOW_PX
        low, high = space.low_mm, space.high_mm
        corner, unit = np.array([low[0], low[1], space.floor_mm]), np.eye(3)
        lines, axes, names, words = [], [], [], []
        for along, across in ((0, 1), (1, 0)):
            for value in _multiples(low[along], high[along], _GRID_MM):
                ends = np.array([corner, corner])
                ends[:, along] = value
                ends[1, across] = high[across]
                lines += list(ends)
        for axis, name in enumerate("xyz"):
            end = corner + (high[axis] - corner[axis]) * unit[axis]
            outwards = np.array([1.0, 1.0, 0.0]) * (1.0 - unit[axis])
            axes += [corner, end]
            place, at = end + _APART_MM[self._is_low] * _NAMED[axis], _AWAY
            if self._is_low and name != "x":
                # there is no room between the axis and what falls in the middle: y beyond its other edge, z before it
                across = (high[0] - low[0] + 20.0) * unit[0]
                place, at = (end + across, _AWAY) if name == "y" else (end, _BESIDE[axis])
            names.append((place, f"{name} [mm]", at))
            for value in _multiples(corner[axis], high[axis], 100.0):
                place = corner + (value - corner[axis]) * unit[axis]
                axes += [place, place - 6.0 * outwards]
                if name != "y" or value > corner[axis] + _CORNER_MM:
                    words.append((place - 18.0 * outwards, f"{value:.0f}", _BESIDE[axis]))
        reach = 0.5 * float(space.size_mm.max())
        for name, direction in space.antennas:
            axes += [0.93 * reach * direction, 1.05 * reach * direction]
            words.append((1.1 * reach * direction, name, _AWAY))
        grid, frame = (
            gl.GLLinePlotItem(
                pos=np.array(points, dtype=np.float32), color=colour, mode="lines", glOptions="translucent"
            )
            for points, colour in ((lines, self._rgba("line", 0.8)), (axes, self._rgba("faint")))
        )
        names += [] if self._is_low else words
        looks = {"color": QColor(self._theme.colours.faint), "font": QFont(self.font())}
        texts = (gl.GLTextItem(pos=place, text=text, alignment=at, **looks) for place, text, at in names)
        self._fixed = [grid, frame, *texts]
        for item in self._fixed:
            self.addItem(item)


def _multiples(low: float, high: float, step: float) -> FloatArray:
    return np.arange(np.ceil(low / step), np.floor(high / step) + 1) * step


def spaced(points: Points) -> BoolArray:
    """Return which points (n, 3) are at least `_STEP_MM` apart along the line: shorter pieces are drawn as dots."""
    if len(points) < 3:
        return np.ones(len(points), dtype=np.bool_)
    step = np.linalg.norm(np.diff(points, axis=0), axis=1)
    unknown = ~np.isfinite(step)
    along = np.concatenate([[0.0], np.cumsum(np.where(unknown, _STEP_MM, step))]) // _STEP_MM
    kept = np.concatenate([[True], np.diff(along) > 0])
    kept[-1] = True
    return kept
