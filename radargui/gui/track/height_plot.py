"""The height against time: live, or of a result with impacts and the fitted parabola of the first fall."""

from __future__ import annotations

import numpy as np

from radargui.gui.plots.plot import LAST, NOW, Plot
from radargui.gui.theme import Theme
from radargui.gui.track.shown_track import ShownTrack
from radargui.gui.track.space import Space
from radargui.model.decimation import extremes

_MOST_BINS = 1500
"""Two points each: about the pixels of a wide screen."""


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
            self._fit.setData([], [])
            self._impacts.setData([], [])
            self.setXRange(-self._live_s, 0.0, padding=0)
        if track is None:
            self._curve.setData([], [])
            return
        self._curve.setData(track.time_s, track.position_mm[2])
        self._fit_height(track)

    def show_result(self, track: ShownTrack | None) -> None:
        """Draw a run with impacts and fit."""
        self._live = False
        self.setMouseEnabled(x=True, y=True)
        if track is None:
            for item in (self._curve, self._fit, self._impacts):
                item.setData([], [])
            return
        self.relabel(f"time after {track.zero} [s]")
        height_mm = track.position_mm[2]
        kept = extremes(height_mm, -(-height_mm.size // _MOST_BINS))
        self._curve.setData(track.time_s[kept], height_mm[kept])
        self._fit.setData(track.fit_time_s, track.fit_mm)
        self._impacts.setData(track.impact_time_s, track.impact_mm[2])
        self.setXRange(float(track.time_s[0]), float(track.time_s[-1]), padding=0.01)
        self._fit_height(track)

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
