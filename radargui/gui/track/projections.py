"""The track in three projections: side, front and top, where OpenGL is not usable or not wanted."""

from __future__ import annotations

import numpy as np
from PySide6.QtWidgets import QGridLayout, QWidget

from radargui.gui.plots.plot import Plot
from radargui.gui.theme import Theme
from radargui.gui.track.shown_track import ShownTrack
from radargui.gui.track.space import Space

_AXES = "xyz"
_VIEWS = ((0, 2), (1, 2), (0, 1))


class Projections(QWidget):
    """x-z, y-z and x-y, the same scale on both axes of each."""

    def __init__(self, theme: Theme) -> None:
        super().__init__()
        grid = QGridLayout(self)
        grid.setContentsMargins(0, 0, 0, 0)
        grid.setSpacing(2)
        self.plots: list[Plot] = []
        self._parts = []
        for number, (across, up) in enumerate(_VIEWS):
            plot = Plot(theme, f"{_AXES[across]} [mm]", f"{_AXES[up]} [mm]", equal=True, live=True)
            plot.getPlotItem().getAxis("left").setWidth(46)
            floor = plot.rule("line", 0.0, angle=0, dashed=False) if up == 2 else None
            trail = plot.fast_line("track")
            impacts = plot.marker("mark", symbol="x", size=9)
            sphere = plot.marker("text", size=9)
            self.plots.append(plot)
            self._parts.append((across, up, plot, floor, trail, impacts, sphere))
            grid.addWidget(plot, 0, number)

    def show_space(self, space: Space) -> None:
        """Show another field of view."""
        for across, up, plot, floor, *_ in self._parts:
            plot.setRange(
                xRange=(space.low_mm[across], space.high_mm[across]),
                yRange=(space.low_mm[up], space.high_mm[up]),
                padding=0,
            )
            if floor is not None:
                floor.setValue(space.floor_mm)

    def show_track(self, track: ShownTrack | None) -> None:
        """Draw a track; None: nothing."""
        for across, up, _, _, trail, impacts, sphere in self._parts:
            if track is None:
                trail.setData([], [])
                impacts.setData([], [])
                sphere.setData([], [])
                continue
            flat = track.position_mm
            trail.setData(flat[across], flat[up])
            impacts.setData(track.impact_mm[across], track.impact_mm[up])
            last = np.flatnonzero(np.isfinite(flat).all(axis=0))[-1:]
            sphere.setData(flat[across, last], flat[up, last])
