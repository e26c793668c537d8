"""The track in plots: the height against time, and three projections where OpenGL is not usable or not wanted."""

import numpy as np
from PySide6.QtWidgets import QGridLayout, QWidget

from radargui.gui.plots.plot import LAST, NOW, Plot
from radargui.gui.theme import Theme
from radargui.gui.track.shown_track import ShownTrack, Space
from radargui.model.decimation import extremes

_MOST_BINS = 1500
"""Two points each: about the pixels of a wide screen."""
_AXES = "xyz"
_VIEWS = ((0, 2), (1, 2), (0, 1))


class HeightPlot(Plot):
    """z of the sphere's centre."""

    def __init__(self, theme: Theme, live_s: float) -> None:
        super().__init__(theme, LAST, "z [mm]", live=True)
        self._live_s = live_s
        self._space: Space | None = None
        self._floor = self.rule("line", 0.0, angle=0, dashed=False)
        self._curve = self.fast_line("track")
        self._fit = self.line("fit", dashed=True)
        self._impacts = self.marker("mark", symbol="x", size=10)
        self._live = True
        self._live_words = LAST
        self.setXRange(-live_s, 0.0, padding=0)

    def show_space(self, space: Space) -> None:
        """Show another field of view."""
        self._space = space
        self._floor.setValue(space.floor_mm)
        self._fit_height(None)

    def follow(self, now: bool) -> None:
        """Say on the axis of the live trail whether its right edge is now."""
        self._live_words = NOW if now else LAST
        if self._live:
            self.relabel(self._live_words)

    def show_live(self, track: ShownTrack | None) -> None:
        """Draw the trail; the newest point is at 0."""
        if not self._live:
            self._live = True
            self.setMouseEnabled(x=False, y=False)
            self.relabel(self._live_words)
            self._clear()
            self.setXRange(-self._live_s, 0.0, padding=0)
        if track is None:
            self._clear()
            return
        self._curve.setData(track.time_s, track.position_mm[2])
        self._fit_height(track)

    def show_result(self, track: ShownTrack | None) -> None:
        """Draw a run with impacts and fit."""
        self._live = False
        self.setMouseEnabled(x=True, y=True)
        self._clear()
        if track is None:
            return
        self.relabel(f"time after {track.zero} [s]")
        height_mm = track.position_mm[2]
        kept = extremes(height_mm, -(-height_mm.size // _MOST_BINS))
        self._curve.setData(track.time_s[kept], height_mm[kept])
        self._fit.setData(track.fit_time_s, track.fit_mm)
        self._impacts.setData(track.impact_time_s, track.impact_mm[2])
        self.setXRange(float(track.time_s[0]), float(track.time_s[-1]), padding=0.01)
        self._fit_height(track)

    def _clear(self) -> None:
        for item in (self._curve, self._fit, self._impacts):
            item.setData([], [])

    def _fit_height(self, track: ShownTrack | None) -> None:
        if self._space is None:
            return
        low, high = float(self._space.low_mm[2]), float(self._space.high_mm[2])
        if track is not None:
            z = track.position_mm[2]
            known = z[np.isfinite(z)]
            if known.size:
                # 5 cm steps, so that the axis stands still
                low = min(low, 50.0 * np.floor(known.min() / 50.0))
                high = max(high, 50.0 * np.ceil(known.max() / 50.0))
        low, high = max(low, -2000.0), min(high, 2000.0)
        if self.viewRange()[1] != [low, high]:
            self.setYRange(low, high, padding=0)


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
            plot.getPlotItem().getAxis("left").setTickDensity(0.6)
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
        for across, up, _, _, *items in self._parts:
            trail, impacts, sphere = items
            if track is None:
                for item in items:
                    item.setData([], [])
                continue
            flat = track.position_mm
            trail.setData(flat[across], flat[up])
            impacts.setData(track.impact_mm[across], track.impact_mm[up])
            last = np.flatnonzero(np.isfinite(flat).all(axis=0))[-1:]
            sphere.setData(flat[across, last], flat[up, last])
