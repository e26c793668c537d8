"""The moment of a run that is looked at: one line in all plots over time, moved in a plot of the whole run."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from functools import partial
from typing import NamedTuple

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QObject, Qt, Signal
from PySide6.QtGui import QKeyEvent
from shiboken6 import isValid

from radargui.gui.layout import having
from radargui.gui.plots.plot import Plot
from radargui.gui.theme import Theme, scaled_px
from radargui.model.arrays import FloatArray, extremes
from radargui.model.result import RunResult
from radargui.model.rounding import with_sign

_STEP = 0.01
"""Share of the run that an arrow key moves the moment by; with Shift a tenth of it."""
_SCRUB = (
    "The whole run: click, drag, or use the arrow keys (F4, then arrows; Shift: finer) to move the moment looked at"
)
_MAX_BINS = 700
"""Of the whole run, two points each: about the pixels of its plot."""


class RunOverview(NamedTuple):
    """A run at a glance.

    Attributes
    ----------
    time_s
        Shape (n,), after `zero`.
    zero_s, zero
        The instant that counts as 0, in s after the first sample, and what it is.
    value, label
        What is drawn against it, shape (n,), and its words.
    place_mm
        Of the sphere, shape (3, n); None without a track.
    """

    time_s: FloatArray
    zero_s: float
    zero: str
    value: FloatArray
    label: str
    place_mm: FloatArray | None


def whole_of(result: RunResult) -> RunOverview | None:
    """Return a run at a glance: its height, without a track the first path; None where it has neither."""
    track, paths, (zero_s, zero) = result.track, result.paths, result.zero
    if track is not None and track.time_s.size:
        place_mm = 1e3 * track.position_m
        return RunOverview(track.time_s - zero_s, zero_s, zero, place_mm[2], "z [mm]", place_mm)
    if paths is not None and paths.change_m.size:
        return RunOverview(result.recording.time_s() - zero_s, zero_s, zero, 1e3 * paths.change_m[0], "ΔL [mm]", None)
    return None


class Instant(QObject):
    """One moment of a run; a line shows it in every plot over time that follows.

    Attributes
    ----------
    at_s
        After the first sample; NaN: nowhere yet.
    """

    moved = Signal()

    def __init__(self, theme: Theme) -> None:
        super().__init__()
        self._theme = theme
        self.at_s = math.nan
        self._lines: dict[Plot, tuple[pg.InfiniteLine, float]] = {}
        theme.changed.connect(self._show)

    def put(self, at_s: float) -> None:
        """Look at another moment."""
        if at_s != self.at_s:
            self.at_s = at_s
            self._show()
            self.moved.emit()

    def follow(self, plots: Iterable[Plot], zero_s: float) -> None:
        """Let plots show it whose times count from `zero_s` after the first sample; dragging over one measures."""
        for plot in plots:
            line = self._lines[plot][0] if plot in self._lines else self._line_in(plot)
            # what is there before anything is processed counts from the first sample
            self._lines[plot] = line, 0.0 if "first sample" in plot.words("bottom") else zero_s
        self._show()

    def _line_in(self, plot: Plot) -> pg.InfiniteLine:
        line = pg.InfiniteLine(angle=90, movable=False)
        # not by the plot, which is emptied for another run
        plot.view.addItem(line, ignoreBounds=True)
        plot.view.dragged = plot.measure
        plot.view.pointed.connect(lambda x: self.put(x + self._lines[plot][1]) if _is_over_time(plot) else None)
        return line

    def _show(self) -> None:
        # plots of samples are made anew where there are more receivers
        self._lines = {plot: one for plot, one in self._lines.items() if isValid(plot) and isValid(one[0])}
        pen = pg.mkPen(self._theme.colours.mark, style=Qt.PenStyle.DotLine)
        for plot, (line, zero_s) in self._lines.items():
            line.setPen(pen)
            line.setVisible(math.isfinite(self.at_s) and _is_over_time(plot))
            if line.isVisible():
                line.setValue(self.at_s - zero_s)
                plot.view.bring_in_sight(self.at_s - zero_s)


def _is_over_time(plot: Plot) -> bool:
    return plot.words("bottom").startswith("time")


class ScrubPlot(Plot):
    """The whole of a run, low; the mouse and the arrow keys move the moment that is looked at."""

    def __init__(self, theme: Theme, instant: Instant) -> None:
        self._whole: RunOverview | None = None
        super().__init__(theme, left_px=58)
        self.getPlotItem().getAxis("left").setStyle(showValues=False)
        self._instant = instant
        self._curve = self.still_line("track", "the whole run")
        having(self, accessibleName="The whole run", toolTip=_SCRUB)
        self.setMinimumHeight(scaled_px(58))
        instant.follow([self], 0.0)
        self.view.dragged = lambda _begin, now: self.view.pointed.emit(now.x())

    def words(self, axis: str) -> str:
        """Return what an axis shows; there is no room to write it below."""
        zero = self._whole.zero if self._whole else "the start"
        return f"time after {zero} [s]" if axis == "bottom" else self._whole.label if self._whole else ""

    def show_whole(self, whole: RunOverview | None) -> None:
        """Draw another run; the moment that is looked at stays where the run has it."""
        self._whole = whole
        if whole is None:
            self._curve.clear()
            self._instant.put(math.nan)
            return
        kept = extremes(whole.value, -(-whole.value.size // _MAX_BINS))
        self._curve.setData(whole.time_s[kept], whole.value[kept])
        self.setXRange(float(whole.time_s[0]), float(whole.time_s[-1]), padding=0.01)
        self._instant.follow([self], whole.zero_s)
        self._instant.put(whole.zero_s)

    @property
    def place_mm(self) -> FloatArray | None:
        """Where the sphere is at the moment, shape (3, 1); None where nobody knows."""
        whole, at_s = self._whole, self._instant.at_s
        if whole is None or whole.place_mm is None or not math.isfinite(at_s):
            return None
        at = int(np.clip(np.searchsorted(whole.time_s, at_s - whole.zero_s), 0, whole.time_s.size - 1))
        place = whole.place_mm[:, at : at + 1]
        return place if np.isfinite(place).all() else None

    @property
    def said(self) -> str:
        """The moment and the place there in words."""
        if self._whole is None or not math.isfinite(self._instant.at_s):
            return ""
        now, place = f"t = {self._instant.at_s - self._whole.zero_s:.4f} s", self.place_mm
        if place is None:
            return now
        where = (f"{axis} {with_sign(value, 1)}" for axis, value in zip("xyz", place[:, 0], strict=True))
        return f"{now}   {'  '.join(where)} mm"

    def _meant(self, event: QKeyEvent) -> Callable[[], object] | None:
        way = {Qt.Key.Key_Left: -1.0, Qt.Key.Key_Right: 1.0}.get(Qt.Key(event.key()))
        if way is None or self._whole is None:
            return super()._meant(event)
        step = _STEP * (0.1 if event.modifiers() & Qt.KeyboardModifier.ShiftModifier else 1.0)
        span = float(self._whole.time_s[-1] - self._whole.time_s[0])
        return partial(self._instant.put, self._instant.at_s + way * step * span)
