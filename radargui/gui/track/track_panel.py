"""The panel of the track: in space or in projections, the height against time, where the sphere is now."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

import numpy as np
from PySide6.QtCore import Qt
from PySide6.QtGui import QFontDatabase
from PySide6.QtWidgets import QGridLayout, QLabel, QSizePolicy, QSplitter, QStackedWidget, QVBoxLayout, QWidget

from radargui.gui.control.state import Feed
from radargui.gui.layout import fill
from radargui.gui.plots.envelope import thin
from radargui.gui.plots.plot import LAST, NOW, Key, Plot
from radargui.gui.theme import Theme
from radargui.gui.track.shown_track import MM, NO_TRACK, ShownTrack, Space, result_track, space_of
from radargui.model.arrays import FloatArray, extremes
from radargui.model.result import RunResult
from radargui.model.setup import Setup

if TYPE_CHECKING:
    from radargui.gui.track.space_view import SpaceView


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
        self._fit = self.still_line("fit", dashed=True)
        self._impacts = self.marker("mark", symbol="x", size=10)
        self._live = True
        self._live_words = LAST
        self.setXRange(-live_s, 0.0, padding=0)

    def show_space(self, space: Space) -> None:
        """Show another field of view."""
        self._space = space
        self._floor.setValue(space.floor_mm)
        self._fit_height(NO_TRACK)

    def follow(self, now: bool) -> None:
        """Say on the axis of the live trail whether its right edge is now."""
        self._live_words = NOW if now else LAST
        if self._live:
            self.relabel(self._live_words)

    def show_live(self, track: ShownTrack) -> None:
        """Draw the trail; the newest point is at 0."""
        if not self._live:
            self._live = True
            self.relabel(self._live_words)
            self.show_nothing()
            self.setXRange(-self._live_s, 0.0, padding=0)
        self._curve.setData(track.time_s, track.position_mm[2])
        self._fit_height(track)

    def show_result(self, track: ShownTrack | None) -> None:
        """Draw a run with impacts and fit."""
        self._live = False
        self.show_nothing()
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

    def _fit_height(self, track: ShownTrack) -> None:
        if self._space is None:
            return
        low, high = float(self._space.low_mm[2]), float(self._space.high_mm[2])
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
            plot = Plot(theme, f"{_AXES[across]} [mm]", f"{_AXES[up]} [mm]", left_px=46, equal=True, live=True)
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

    def show_track(self, track: ShownTrack) -> None:
        """Draw a track."""
        for across, up, _, _, trail, impacts, sphere in self._parts:
            flat = track.position_mm
            trail.setData(flat[across], flat[up])
            impacts.setData(track.impact_mm[across], track.impact_mm[up])
            last = np.flatnonzero(np.isfinite(flat).all(axis=0))[-1:]
            sphere.setData(flat[across, last], flat[up, last])


_MOST_LIVE_POINTS = 1500
LIVE_S = 4.0
"""Of the live track: a drop of half a metre with its first ten bounces."""
HOLD_S = 0.8
"""A result stays so long at least, whatever moves: the hand that puts the sphere back comes a moment later."""


class TrackPanel(QWidget):
    """Shows the live trail; after a run its result, until something moves again."""

    def __init__(self, theme: Theme, setup: Setup) -> None:
        super().__init__()
        self._theme = theme
        self._space: Space = space_of(setup)
        self._feed: Feed | None = None
        self._drawn = -1
        self.shown: ShownTrack | None = None
        self._held_until = 0.0
        self.result_shown = False
        self.paused = False

        self._stack = QStackedWidget()
        self.projections = Projections(theme)
        self._stack.addWidget(self.projections)
        self._space_view: SpaceView | None = None
        self.height_plot = HeightPlot(theme, LIVE_S)
        self.where = QLabel()
        self.where.setFont(QFontDatabase.systemFont(QFontDatabase.SystemFont.FixedFont))
        self.where.setAlignment(Qt.AlignmentFlag.AlignHCenter)
        self.where.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self.key = Key(theme)
        for label in (self.where, self.key):
            label.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Fixed)
        self._title = QLabel()
        self._title.setContentsMargins(6, 3, 6, 0)

        lower = QWidget()
        fill(QVBoxLayout(lower), self.where, self.key, (self.height_plot, 1))
        splitter = QSplitter(Qt.Orientation.Vertical)
        splitter.setObjectName("track.parts")
        splitter.addWidget(self._stack)
        splitter.addWidget(lower)
        splitter.setStretchFactor(0, 3)
        splitter.setStretchFactor(1, 2)
        splitter.setChildrenCollapsible(False)
        fill(QVBoxLayout(self), self._title, (splitter, 1), spacing=0)
        self.show_setup(setup)
        self.clear()

    @property
    def in_space(self) -> bool:
        """Whether the OpenGL view is shown."""
        return self._space_view is not None

    @property
    def view(self) -> SpaceView | Projections:
        """The view in space, or the projections."""
        return self._space_view or self.projections

    def use_space_view(self, wanted: bool) -> None:
        """Show the track in space; only where the test of OpenGL said yes."""
        if wanted == self.in_space:
            return
        if wanted:
            from radargui.gui.track.space_view import SpaceView

            self._space_view = SpaceView(self._theme)
            self._stack.addWidget(self._space_view)
            self._stack.setCurrentIndex(1)
        elif self._space_view is not None:
            # not kept: as long as it exists the whole window is put together by OpenGL
            self._stack.setCurrentIndex(0)
            self._stack.removeWidget(self._space_view)
            self._space_view.deleteLater()
            self._space_view = None
        self.view.show_space(self._space)
        self._draw(self.shown)

    def renew_space_view(self) -> None:
        """Make the view in space anew: torn off or put back, its old surface stays black."""
        if self._space_view is not None:
            camera = self._space_view.camera()
            self.use_space_view(False)
            self.use_space_view(True)
            self._space_view.take_camera(camera)

    def show_setup(self, setup: Setup) -> None:
        """Show the field of view of another setup."""
        self._space = space_of(setup)
        for view in (self.view, self.height_plot):
            view.show_space(self._space)

    def show_feed(self, feed: Feed | None) -> None:
        """Follow another acquisition; None keeps what is shown."""
        self._feed, self._drawn = feed, -1
        if feed is not None:
            self.show_setup(feed.setup)
        self._follow()

    def show_result(self, result: RunResult, name: str) -> None:
        """Show what a run gave instead of the live track."""
        track = result_track(result)
        self.result_shown = True
        self._held_until = time.monotonic() + HOLD_S
        self.show_setup(result.setup)
        self._draw(track)
        self.height_plot.show_result(track)
        words = "preliminary result" if result.preliminary else "result"
        self._title.setText(f"{name}: {words if track else 'no track'}")
        drawn = [("▬", "track", "z")] if track else []
        drawn += [("╌", "fit", "parabola of the first fall")] if track and track.fit_time_s.size else []
        drawn += [("×", "mark", "impacts")] if track and track.impact_time_s.size else []
        self.key.show_entries(*drawn)
        self._show_words(result=track is not None)

    def clear(self) -> None:
        """Forget the result that was shown, and the last moments of the live track."""
        self.show_live()
        self._draw(None)
        self.height_plot.show_live(NO_TRACK)
        self._title.setText("Live track: nothing yet")
        self._show_words(result=False)
        self._show_where(None)

    def show_live(self) -> None:
        """Go back to the live track."""
        self._held_until = 0.0
        self.result_shown = False

    def set_paused(self, paused: bool) -> None:
        """Hold the picture, or let it go on."""
        self.paused = paused
        self._follow()

    def refresh(self) -> None:
        """Draw the newest of the trail; called by the window's timer."""
        feed = self._feed
        live = feed.live if feed is not None else None
        if feed is None or live is None or self.paused or live.latest == self._drawn:
            return
        self._drawn = live.latest
        span = live.since(max(0, self._drawn - feed.samples(LIVE_S)))
        held = self.result_shown and (time.monotonic() < self._held_until or not live.moving)
        if held or not span.index.size:
            return
        self.result_shown = False
        self._show_words(result=False)
        anew = "starts anew after lost samples, as if from the release" if live.began_anew else ""
        now = ", ".join(filter(None, ("" if live.moving else "at rest", anew)))
        self._title.setText(f"Live track: {now}" if now else "Live track")
        if self.isVisible():
            rows: FloatArray = thin(np.vstack([span.index[None], span.position_m]), _MOST_LIVE_POINTS)
            track = ShownTrack((rows[0] - self._drawn) / feed.rate_hz, rows[1:] * MM)
            self._draw(track)
            self.height_plot.show_live(track)
            self._show_where(track)

    def _follow(self) -> None:
        self.height_plot.follow(self._feed is not None and not self.paused)

    def _draw(self, track: ShownTrack | None) -> None:
        self.shown = track
        self.view.show_track(track or NO_TRACK)

    def _show_words(self, *, result: bool) -> None:
        self.where.setVisible(not result)
        self.key.setVisible(result)

    def _show_where(self, track: ShownTrack | None) -> None:
        # short enough for the narrowest dock
        text = "x       –  y       –  z       –  mm"
        if track is not None and track.position_mm.shape[1]:
            place = track.position_mm[:, -1]
            if np.isfinite(place).all():
                text = "  ".join(f"{axis} {value:+7.1f}" for axis, value in zip("xyz", place, strict=True)) + "  mm"
        self.where.setText(text)
