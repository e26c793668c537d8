"""What is drawn against time beneath a track: the height with its fitted fall, and one of speed, residual, x, y."""

from collections.abc import Mapping
from typing import Literal

import numpy as np
from PySide6.QtCore import QSignalBlocker
from PySide6.QtWidgets import QSizePolicy, QStackedWidget, QTabBar, QVBoxLayout, QWidget

from radargui.gui.layout import TIPS, fill
from radargui.gui.plots.key import Key
from radargui.gui.plots.plot import LAST, NOW, Plot
from radargui.gui.plots.ranges import SteadyRange
from radargui.gui.theme import Theme
from radargui.gui.track.shown_track import NO_TRACK, ShownTrack, Space
from radargui.model.arrays import FloatArray, extremes

_MOST_BINS = 1500
"""Two points each: about the pixels of a wide screen."""
_LEFT = 58
COVERED = 2.0
"""Standard uncertainties that a band reaches to either side."""
Detail = Literal["speed", "residual", "x", "y"]
_LABELS: Mapping[Detail, str] = {"speed": "v [m/s]", "residual": "Δz [µm]", "x": "x [mm]", "y": "y [mm]"}


class HeightPlot(Plot):
    """z of the sphere's centre."""

    def __init__(self, theme: Theme, live_s: float) -> None:
        super().__init__(theme, LAST, "z [mm]", left_px=_LEFT, live=True)
        self.getPlotItem().getAxis("left").setTickDensity(0.6)
        self._live_s = live_s
        self._space: Space | None = None
        self._floor = self.rule("line", 0.0, angle=0, dashed=False)
        self.band_drawn = self.band("track")
        self._curve = self.fast_line("track", "z")
        self._fit = self.still_line("fit", "parabola", dashed=True)
        self._impacts = self.marker("mark", symbol="x", size=10, name="impacts")
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
            self.band_drawn.show_band(*np.empty((3, 0)))
            self.setXRange(-self._live_s, 0.0, padding=0)
        self._curve.setData(track.time_s, track.position_mm[2])
        self._fit_height(track)

    def show_result(self, track: ShownTrack | None) -> None:
        """Draw a run with impacts and fit."""
        self._live = False
        self.show_nothing()
        self.band_drawn.show_band(*np.empty((3, 0)))
        if track is None:
            return
        self.relabel(f"time after {track.zero} [s]")
        height_mm = track.position_mm[2]
        kept = extremes(height_mm, -(-height_mm.size // _MOST_BINS))
        self._curve.setData(track.time_s[kept], height_mm[kept])
        around = COVERED * track.u_mm[2, kept]
        self.band_drawn.show_band(track.time_s[kept], height_mm[kept] - around, height_mm[kept] + around)
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


class DetailPlot(Plot):
    """One of several quantities against time, with its band where it has one."""

    def __init__(self, theme: Theme) -> None:
        super().__init__(theme, "time [s]", _LABELS["speed"], left_px=_LEFT, live=True)
        self.getPlotItem().getAxis("left").setTickDensity(0.6)
        self._zero = self.rule("line", 0.0, angle=0, dashed=False)
        self.band_drawn = self.band("track")
        self.curve = self.fast_line("track")
        self._range = SteadyRange()

    def show_detail(self, detail: Detail, track: ShownTrack, words: str, span_s: tuple[float, float]) -> None:
        """Draw a quantity over a span of time; `words` name the time axis."""
        self.relabel(words, _LABELS[detail])
        x, y, u = _values(detail, track)
        kept = extremes(y, -(-y.size // _MOST_BINS)) if y.size else np.empty(0, np.intp)
        x, y, around = x[kept], y[kept], COVERED * u[kept]
        self.curve.setData(x, y)
        self.band_drawn.show_band(x, y - around, y + around)
        self._zero.setVisible(detail in ("speed", "residual"))
        if detail == "residual" and x.size:
            # over its own time: a fall is a small part of what a sphere does that bounces
            span_s = float(x[0]), float(x[-1])
        self.setXRange(*span_s, padding=0.01 if track.zero else 0.0)
        ends = np.concatenate([y, y - np.nan_to_num(around), y + np.nan_to_num(around)])
        ends = ends[np.isfinite(ends)]
        if not ends.size:
            self.setYRange(0.0, 1.0, padding=0)
        elif self._range.fit(float(ends.min()), float(ends.max())):
            self.setYRange(*self._range.span, padding=0)

    def begin_anew(self) -> None:
        """Forget the range of what was drawn before."""
        self._range = SteadyRange()


def _values(detail: Detail, track: ShownTrack) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return time, value and standard uncertainty (NaN: without a band), shape (n,) each."""
    if detail == "residual":
        return track.residual_time_s, 1e3 * track.residual_mm, 1e3 * track.residual_u_mm
    unknown = np.full(track.time_s.size, np.nan)
    if detail == "speed":
        return track.time_s, track.speed_m_s if track.speed_m_s.size else unknown, unknown
    row = "xy".index(detail)
    return track.time_s, track.position_mm[row], track.u_mm[row] if track.u_mm.size else unknown


class TrackCurves(QWidget):
    """The height, always; below it what the operator chose, of the live trail and of a result each by itself.

    Parameters
    ----------
    theme
        Look.
    live_s
        Time that the live trail is long.
    live_words
        Stand above the live trail, where the key of a result stands.
    """

    def __init__(self, theme: Theme, live_s: float, live_words: QWidget) -> None:
        super().__init__()
        self._live_s = live_s
        self._track: ShownTrack = NO_TRACK
        self._is_live = True
        self._words = LAST
        # the speed while it falls, what the fit leaves once it has fallen
        self._chosen: dict[bool, Detail] = {True: "speed", False: "residual"}
        self.height_plot = HeightPlot(theme, live_s)
        self.key = Key(theme)
        self.key.setToolTip("The parabola is fitted to the first fall; where it is left out, none could be fitted")
        self.key.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Fixed)
        # in one place: a line that comes or goes moves all plots, and each is drawn anew with its axes
        self._words_above = QStackedWidget()
        self._words_above.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Fixed)
        self._words_above.addWidget(self.key)
        self._words_above.addWidget(live_words)
        self.detail = DetailPlot(theme)
        self.tabs = QTabBar()
        self.tabs.setDrawBase(False)
        self.tabs.setExpanding(False)
        self.tabs.setAccessibleName("Curve below the height")
        for number, name in enumerate(_LABELS):
            self.tabs.addTab(name.capitalize() if len(name) > 1 else f"{name} ± 2 u")
            self.tabs.setTabData(number, name)
            self.tabs.setTabToolTip(number, TIPS["curves"][name])
        self.tabs.currentChanged.connect(self._choose)
        fill(QVBoxLayout(self), self._words_above, (self.height_plot, 3), self.tabs, (self.detail, 2), spacing=0)
        self.setMinimumHeight(self.minimumSizeHint().height())
        self._turn(live=True)

    @property
    def shown_detail(self) -> Detail:
        """What is drawn below the height."""
        return self._chosen[self._is_live]

    def choose(self, detail: Detail) -> None:
        """Draw something else below the height."""
        self.tabs.setCurrentIndex(list(_LABELS).index(detail))

    def show_space(self, space: Space) -> None:
        """Show another field of view."""
        self.height_plot.show_space(space)

    def follow(self, now: bool) -> None:
        """Say on the axes of the live trail whether their right edge is now."""
        self._words = NOW if now else LAST
        self.height_plot.follow(now)
        if self._is_live:
            self._draw()

    def show_live(self, track: ShownTrack) -> None:
        """Draw the trail; the newest point is at 0."""
        if not self._is_live:
            self._turn(live=True)
        self._track = track
        self.height_plot.show_live(track)
        self._draw()

    def show_result(self, track: ShownTrack | None) -> None:
        """Draw a run."""
        self._turn(live=False)
        self._track = track or NO_TRACK
        self.height_plot.show_result(track)
        drawn = [("▬", "track", "z"), ("▒", "track", f"± 2 u ({track.u_kind})")] if track else []
        drawn += [("╌", "fit", "parabola")] if track and track.fit_time_s.size else []
        drawn += [("×", "mark", "impacts")] if track and track.impact_time_s.size else []
        self.key.show_entries(*drawn)
        self._draw()

    def _turn(self, *, live: bool) -> None:
        """Turn to the live trail, or to a result, each with what was chosen for it."""
        self._is_live = live
        self._words_above.setCurrentIndex(int(live))
        with QSignalBlocker(self.tabs):
            # nothing is fitted to a sphere that still falls
            self.tabs.setTabVisible(list(_LABELS).index("residual"), not live)
            self.choose(self._chosen[live])
        self.detail.begin_anew()

    def _choose(self, index: int) -> None:
        self._chosen[self._is_live] = self.tabs.tabData(index)
        self.detail.begin_anew()
        self._draw()

    def _draw(self) -> None:
        track, live = self._track, self._is_live
        span = (-self._live_s, 0.0)
        if not live and track.time_s.size:
            span = float(track.time_s[0]), float(track.time_s[-1])
        # both are moved together, but for the fall alone
        linked = None if self.shown_detail == "residual" else self.height_plot
        if self.detail.view.linkedView(0) is not (linked and linked.view):
            self.detail.setXLink(linked)
        words = self._words if live else f"time after {track.zero or 'the first sample'} [s]"
        self.detail.show_detail(self.shown_detail, track, words, span)
        missing = not live and track.time_s.size and self.shown_detail == "residual" and not track.residual_time_s.size
        self.detail.write_inside("no fall was fitted" if missing else "")
