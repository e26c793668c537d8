"""What is drawn of a track against time: the height with its impacts, and one of trigger, speed, residual, x, y."""

from collections.abc import Mapping
from typing import Literal

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QSignalBlocker, Signal
from PySide6.QtWidgets import QSizePolicy, QStackedWidget, QTabBar, QVBoxLayout, QWidget

from radargui.gui.layout import TIPS, boxed, fill, having, holding
from radargui.gui.plots.key import Key
from radargui.gui.plots.plot import LAST, NOW, Plot, SteadyRange
from radargui.gui.setup_words import limits_of, words_of
from radargui.gui.theme import Theme, scaled_font
from radargui.gui.track.shown_track import NO_TRACK, ShownTrack, Space
from radargui.model.arrays import FloatArray, extremes
from radargui.model.rounding import COVERAGE

_MAX_BINS = 1500
"""Two points each: about the pixels of a wide screen."""
_LEFT = 58
"""Width of the left axes in pixels (chosen by hand): in less the figures are cut, more is taken from the curves."""
LEVEL_KEY = "recording.threshold"
"""Of the trigger's level in the setup."""
_LEVEL = words_of(LEVEL_KEY)
Detail = Literal["trigger", "speed", "acceleration", "speed over z", "residual", "x", "y"]
_LABELS: Mapping[Detail, str] = {
    "trigger": f"[{_LEVEL.unit}]",
    "speed": "v [m/s]",
    "acceleration": "a_z [m/s²]",
    "speed over z": "v [m/s]",
    "residual": "Δz [µm]",
    "x": "x [mm]",
    "y": "y [mm]",
}
_OF_RESULTS: tuple[Detail, ...] = ("acceleration", "speed over z", "residual")
"""What nothing tells of a sphere that still moves."""
_OF_LIVE: tuple[Detail, ...] = ("trigger",)
"""What nobody kept of a run."""
_OTHER_AXIS: tuple[Detail, ...] = ("speed over z", "residual")
"""What is not moved together with the height."""


_DECADES = [(float(np.log10(value)), f"{value:g}") for value in (1, 3, 10, 30, 100, 300, 1000, 3000, 10_000)]
"""Ticks of what spans decades: as many figures as a low plot has room for."""


class TimePlot(Plot):
    """A quantity of the sphere against time, with its band where it has one, and a level to see it against.

    Attributes
    ----------
    in_decades
        Whether logarithms are drawn; what is read off and copied are the values.
    """

    in_decades = False

    def __init__(self, theme: Theme, bottom: str, left: str, name: str = "") -> None:
        super().__init__(theme, bottom, left, left_px=_LEFT, live=True, density=0.6)
        self.level = self.rule("line", 0.0, angle=0, dashed=False)
        self.band_drawn = self.band("track")
        self.curve = self.fast_line("track", name)

    def draw(self, x: FloatArray, y: FloatArray, u: FloatArray) -> FloatArray:
        """Draw values and standard uncertainties (NaN: without a band), shape (n,); return what to make room for."""
        kept = extremes(y, -(-y.size // _MAX_BINS))
        x, y, around = x[kept], y[kept], COVERAGE * u[kept]
        self.curve.setData(x, y)
        self.band_drawn.show_band(x, y - around, y + around)
        ends: FloatArray = np.concatenate([y, y - around, y + around])
        return np.asarray(ends[np.isfinite(ends)])

    def show_decades(self, *, wanted: bool) -> None:
        """Show an axis of decades, or an even one."""
        self.in_decades = wanted
        self.getPlotItem().getAxis("left").setTicks([_DECADES] if wanted else None)

    def value_of(self, item: pg.GraphicsObject | None, y: float) -> float:
        """Return the value that a place on the left axis stands for."""
        return float(10.0**y) if self.in_decades else super().value_of(item, y)

    def data_of(self, item: pg.GraphicsObject) -> tuple[FloatArray, FloatArray]:
        """Return the data of a curve, in its unit."""
        x, y = super().data_of(item)
        return x, 10.0**y if self.in_decades else y

    def show_nothing(self) -> None:
        """Empty all curves, and the band."""
        super().show_nothing()
        self.band_drawn.show_band(*np.empty((3, 0)))


class HeightPlot(TimePlot):
    """z of the sphere's centre."""

    def __init__(self, theme: Theme) -> None:
        super().__init__(theme, LAST, "z [mm]", "z")
        self._fit = self.still_line("fit", "parabola", dashed=True)
        self._impacts = self.marker("mark", symbol="x", size=10, name="impacts")

    def show_space(self, space: Space) -> None:
        """Show another field of view."""
        self._space = space
        self.level.setValue(space.floor_mm)
        self._fit_height(NO_TRACK)

    def show_track(self, track: ShownTrack) -> None:
        """Draw a live trail, or a run with impacts and fit."""
        self.draw(track.time_s, track.position_mm[2], track.u_mm[2])
        self._impacts.setData(track.impact_time_s, track.impact_mm[2])
        if track.zero:
            self._fit.setData(track.fit_time_s, track.fit_mm)
        self._fit_height(track)

    def _fit_height(self, track: ShownTrack) -> None:
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


def _span(time_s: FloatArray) -> tuple[float, float]:
    """Return the first and the last of some instants; a second where there is none."""
    return (float(time_s[0]), float(time_s[-1])) if time_s.size else (0.0, 1.0)


def _values(detail: Detail, track: ShownTrack) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return time, value and standard uncertainty (NaN: without a band), shape (n,) each."""
    if detail == "trigger":
        # what is told in digits is never quite still
        time_s, shaking = track.shaken
        return time_s, np.log10(np.maximum(shaking, 0.1)), np.full(time_s.size, np.nan)
    if detail == "residual":
        return track.residual_time_s, 1e3 * track.residual_mm, 1e3 * track.residual_u_mm
    if detail in ("speed", "acceleration", "speed over z"):
        return _of_motion(detail, track)
    row = "xy".index(detail)
    return track.time_s, track.position_mm[row], track.u_mm[row]


def _of_motion(detail: Detail, track: ShownTrack) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the same of what a result's motion tells; of a track alone its speed, without a band."""
    motion = track.motion
    if motion is None:
        unknown = np.full(track.time_s.size, np.nan)
        return track.time_s, track.speed_m_s if detail == "speed" else unknown, unknown
    time_s, (speed, u) = motion.time_s - track.zero_s, motion.speed()
    if detail == "acceleration":
        # of a sphere that lies it is noise, a hundred times that of one that flies
        return time_s, np.where(motion.flight >= 0, motion.acceleration_m_s2[2], np.nan), motion.u_acceleration_m_s2[2]
    return (1e3 * motion.position_m[2] if detail == "speed over z" else time_s), speed, u


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

    level_set = Signal(str, float)

    def __init__(self, theme: Theme, live_s: float, live_words: QWidget) -> None:
        super().__init__()
        self._live_s = live_s
        self._track = NO_TRACK
        self._words = LAST
        # what a motion is told by while one is waited for, what the fit leaves once it has fallen
        self._chosen: dict[bool, Detail] = {True: "trigger", False: "residual"}
        self.height_plot = HeightPlot(theme)
        self.key = Key(theme)
        self.key.setToolTip("The parabola is fitted to the first fall; where it is left out, none could be fitted")
        self.key.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Fixed)
        # in one place: a line that comes or goes moves all plots, and each is drawn anew with its axes
        self.words = holding(QStackedWidget(), self.key, live_words)
        self.words.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Fixed)
        self.detail = TimePlot(theme, "time [s]", _LABELS["speed"])
        self.trigger = self.detail.rule("mark", 0.0, angle=0)
        self.trigger.setBounds(np.log10(limits_of(LEVEL_KEY)))
        self.trigger.sigPositionChanged.connect(self._say_level)
        self.trigger.sigPositionChangeFinished.connect(lambda: self.level_set.emit(LEVEL_KEY, self.level))
        self.tabs = having(QTabBar(drawBase=False, expanding=False), accessibleName="Curve below the height")
        # so that those of a result fit beside the projections on a screen of 1366 pixels
        having(self.tabs, usesScrollButtons=True, font=scaled_font(self.tabs.font(), 0.9))
        for number, name in enumerate(_LABELS):
            self.tabs.addTab(name.capitalize() if len(name) > 1 else name)
            self.tabs.setTabData(number, name)
            self.tabs.setTabToolTip(number, TIPS["curves"][name])
        self.tabs.currentChanged.connect(self._choose)
        self.below = boxed(QVBoxLayout(), self.tabs, (self.detail, 1), spacing=0)
        fill(QVBoxLayout(self), (self.height_plot, 1))
        self._turn(live=True)

    @property
    def shown_detail(self) -> Detail:
        """What is drawn below the height."""
        return self._chosen[self._is_live]

    @property
    def level(self) -> float:
        """Where the line of the trigger stands, in the unit of its field and as finely as one reads it."""
        return float(f"{10.0 ** self.trigger.value():.3g}")

    def show_level(self, level: object, *, movable: bool) -> None:
        """Show what the trigger asks for, as a line that is dragged where that may be changed now.

        What is typed and is no level leaves the line where it was.
        """
        self.trigger.setMovable(movable)
        if isinstance(level, (int, float)) and level > 0.0 and not self.trigger.moving:
            self.trigger.setValue(np.log10(level))
        self._say_level()

    def _say_level(self) -> None:
        how = ": drag the line" * bool(self.trigger.movable)
        shown = self.trigger.isVisible()
        self.detail.write_inside(f"{_LEVEL.name} {_LEVEL.with_unit(self.level)}{how}" if shown else "")

    def choose(self, detail: Detail) -> None:
        """Draw something else below the height."""
        self.tabs.setCurrentIndex(list(_LABELS).index(detail))

    def choose_of_result(self, detail: Detail) -> None:
        """Draw something else below the height of a result, also of one that is still to come."""
        self._chosen[False] = detail
        if not self._is_live:
            self.choose(detail)

    def follow(self, now: bool) -> None:
        """Say on the axes of the live trail whether their right edge is now."""
        self._words = NOW if now else LAST
        if self._is_live:
            self.height_plot.relabel(self._words)
            self._draw()

    def show_live(self, track: ShownTrack) -> None:
        """Draw the trail; the newest point is at 0."""
        if not self._is_live:
            self._turn(live=True)
        self._track = track
        self.height_plot.show_track(track)
        self._draw()

    def show_result(self, track: ShownTrack | None) -> None:
        """Draw a run."""
        self._turn(live=False)
        self._track = track or NO_TRACK
        self.height_plot.relabel(f"time after {self._track.zero or 'the first sample'} [s]")
        self.height_plot.setXRange(*_span(self._track.time_s), padding=0.01)
        if track:
            self.height_plot.show_track(track)
        drawn = [("▬", "track", "z"), ("▒", "track", f"± {COVERAGE:g} u ({track.u_kind})")] if track else []
        drawn += [("╌", "fit", "parabola")] if track and track.fit_time_s.size else []
        drawn += [("×", "mark", "impacts")] if track and track.impact_time_s.size else []
        self.key.show_entries(*drawn)
        self._draw()

    def _turn(self, *, live: bool) -> None:
        """Turn to the live trail, or to a result, each with what was chosen for it."""
        self._is_live = live
        self.words.setCurrentIndex(int(live))
        self.height_plot.show_nothing()
        if live:
            self.height_plot.relabel(self._words)
            self.height_plot.setXRange(-self._live_s, 0.0, padding=0)
        with QSignalBlocker(self.tabs):
            # nothing is fitted to a sphere that still falls
            for name in (*_OF_RESULTS, *_OF_LIVE):
                self.tabs.setTabVisible(list(_LABELS).index(name), live == (name in _OF_LIVE))
            self.choose(self._chosen[live])
        self.detail.steady = SteadyRange()

    def _choose(self, index: int) -> None:
        self._chosen[self._is_live] = self.tabs.tabData(index)
        self.detail.steady = SteadyRange()
        self._draw()

    def _draw(self) -> None:
        track, name, plot = self._track, self.shown_detail, self.detail
        # both are moved together, but for the fall alone
        linked = None if name in _OTHER_AXIS else self.height_plot
        if plot.view.linkedView(0) is not (linked and linked.view):
            plot.setXLink(linked)
        words = self._words if self._is_live else f"time after {track.zero or 'the first sample'} [s]"
        plot.relabel("z [mm]" if name == "speed over z" else words, _LABELS[name])
        is_trigger = name == "trigger"
        if plot.in_decades is not is_trigger:
            plot.show_decades(wanted=is_trigger)
        values = _values(name, track)
        seen = plot.draw(*values)
        plot.level.setVisible(name not in ("x", "y", "trigger"))
        self.trigger.setVisible(is_trigger)
        if is_trigger:
            # from what is quiet to above the line, whatever shakes
            seen = np.append(seen, (0.0, self.trigger.value() + 0.3))
        # the residual over its own time: a fall is a small part of what a sphere does that bounces
        own = values[0][np.isfinite(values[0])] if name in _OTHER_AXIS else np.empty(0)
        times = np.sort(own) if own.size else track.time_s
        plot.setXRange(*((-self._live_s, 0.0) if self._is_live else _span(times)), padding=0.01 if track.zero else 0.0)
        if seen.size:
            plot.fit_y(float(seen.min()), float(seen.max()))
        else:
            # what was shown before has no say in the range of what comes
            plot.steady = SteadyRange()
            plot.setYRange(0.0, 1.0, padding=0)
        if is_trigger:
            self._say_level()
            return
        missing = track.zero and name in _OF_RESULTS and not np.isfinite(values[1]).any()
        nothing = "no fall was fitted" if name == "residual" else "of joint and flights only"
        plot.write_inside(nothing if missing else "")
