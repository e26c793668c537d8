"""The panel of the live scopes: I and Q of each receiver against time, with levels, a window of seconds and a pause."""

import numpy as np
import pyqtgraph as pg
from PySide6.QtGui import QColor
from PySide6.QtWidgets import QCheckBox, QGridLayout, QHBoxLayout, QLabel, QProgressBar, QVBoxLayout, QWidget

from radargui.acquisition.health import Health
from radargui.acquisition.run_output import Level
from radargui.gui.control.state import Feed
from radargui.gui.layout import Choice, fill, take_out
from radargui.gui.plots.envelope import Envelope
from radargui.gui.plots.plot import IQ_KEY, LAST, NOW, Key, Plot
from radargui.gui.plots.ranges import SteadyRange
from radargui.gui.theme import Theme, scaled_font
from radargui.model.arrays import BoolArray, FloatArray

_FAR_V = 1000.0
"""A shade reaches beyond every range of voltage."""


class Scope(Plot):
    """Rolling view; the newest sample shown is at 0, the past to the left."""

    def __init__(self, theme: Theme, number: int, *, with_time: bool) -> None:
        self._lost = pg.BarGraphItem(x0=[], x1=[], y0=-_FAR_V, y1=_FAR_V, pen=None)
        super().__init__(theme, LAST if with_time else "", f"Rx {number} [V]", left_px=50, live=True)
        # on a small screen three of them share a hand's breadth: fewer figures, none upon another
        self.getPlotItem().getAxis("left").setTickDensity(0.6)
        self._with_time = with_time
        self._lost.setZValue(-10)
        self.addItem(self._lost, ignoreBounds=True)
        self._range = SteadyRange()
        self._curves = (self.fast_line("i"), self.fast_line("q"))
        self.setYRange(-1.0, 1.0, padding=0)
        self.set_window(3.0)

    def follow(self, now: bool) -> None:
        """Say on the axis whether its right edge is now."""
        if self._with_time:
            self.relabel(NOW if now else LAST)

    def set_window(self, seconds: float) -> None:
        """Show so many seconds."""
        self.setXRange(-seconds, 0.0, padding=0)

    def draw(self, time_s: FloatArray, volts: FloatArray, lost: BoolArray) -> None:
        """Draw minimum and maximum of each pixel column.

        Parameters
        ----------
        time_s
            Shape (2 n,), 0 is now.
        volts
            I and Q, shape (2, 2 n).
        lost
            Whether samples of the column were lost, shape (n,).
        """
        for curve, values in zip(self._curves, volts, strict=True):
            curve.setData(time_s, values)
        known = volts[np.isfinite(volts)]
        if known.size and self._range.fit(float(known.min()), float(known.max())):
            self.setYRange(*self._range.span, padding=0)
        self._shade(time_s, lost)

    def show_nothing(self) -> None:
        """Empty all curves, and shade nothing."""
        self.draw(np.empty(0), np.empty((2, 0)), np.empty(0, dtype=np.bool_))

    def retheme(self) -> None:
        """Take over the colours of the theme."""
        super().retheme()
        colour = QColor(self.colour("gap"))
        colour.setAlpha(150)
        self._lost.setOpts(brush=colour)

    def _shade(self, time_s: FloatArray, lost: BoolArray) -> None:
        edges = np.flatnonzero(np.diff(np.concatenate(([False], lost, [False])).astype(np.int8)))
        width = time_s[2] - time_s[0] if time_s.size > 2 else 0.0
        first, last = time_s[2 * edges[::2]] - 0.5 * width, time_s[2 * edges[1::2] - 1] + 0.5 * width
        if first.size or len(self._lost.opts["x0"]):
            self._lost.setOpts(x0=first, x1=last)


_HOLD_LOOKS = 5
_BAR_PX = 7


class LevelBar(QWidget):
    """A bar from 0 to full scale; clipping is said by a word and stays readable for a second."""

    def __init__(self, theme: Theme, name: str, role: str, full_scale_v: float) -> None:
        super().__init__()
        self._theme, self.name, self._role, self._full_scale_v = theme, name, role, full_scale_v
        self._held = 0
        self._peak_v: float | None = None
        self._words, self._bar = QLabel(), QProgressBar(textVisible=False, maximum=1000)
        self._words.setFont(scaled_font(self.font(), 0.85))
        self.setFixedWidth(self.fontMetrics().horizontalAdvance("I1 00.00 V") + 8)
        self._bar.setFixedHeight(_BAR_PX)
        fill(QVBoxLayout(self), self._words, self._bar, margins=(4, 1, 4, 1), spacing=1)
        theme.changed.connect(self._paint)
        self.show_level(None)

    @property
    def clipping(self) -> bool:
        """Whether the light is on."""
        return self._held > 0

    def show_level(self, level: Level | None) -> None:
        """Show a level; None: nothing is known."""
        clipped = level is not None and level.clipped
        self._held = _HOLD_LOOKS if clipped else max(0, self._held - 1) if level is not None else 0
        self._peak_v = None if level is None else level.peak_v
        self._full_scale_v = (level and level.full_scale_v) or self._full_scale_v
        share = (self._peak_v or 0.0) / self._full_scale_v
        peak, said = ("–", "") if level is None else (f"{self._peak_v:.2f} V", f"{100.0 * share:.0f} % of the range")
        self.setToolTip(f"{self.name}: {said}{', clipping: lower the gain or raise the range' * self.clipping}")
        self._words.setText(f"{self.name} {'CLIP' if self.clipping else peak}")
        self._bar.setValue(round(1000.0 * min(1.0, share)))
        self._paint()

    def _paint(self) -> None:
        colours, alarm = self._theme.colours, self._theme.colours.alarm
        colour = alarm if self.clipping else colours.role(self._role)
        sheet = (
            f"QLabel {{ color: {alarm if self.clipping else colours.text}; }}"
            f"QProgressBar {{ background: {colours.raised}; border: none; border-radius: 3px; }}"
            f"QProgressBar::chunk {{ background: {colour}; border-radius: 3px; }}"
        )
        # a sheet that is set anew is read anew
        if sheet != self.styleSheet():
            self.setStyleSheet(sheet)


WINDOWS_S = (0.5, 1.0, 2.0, 3.0, 5.0, 9.0)
"""What may be chosen: the ring holds ten seconds."""
_LOST = ("■", "gap", "samples lost")


class ScopePanel(QWidget):
    """I and Q against time; pausing holds the picture, never the samples."""

    def __init__(self, theme: Theme, window_s: float = 3.0) -> None:
        super().__init__()
        self._theme = theme
        self._feed: Feed | None = None
        self._envelope: Envelope | None = None
        self.scopes: list[Scope] = []
        self.levels: list[LevelBar] = []

        self.span = Choice((seconds, f"{seconds:g} s") for seconds in WINDOWS_S)
        self.span.setObjectName("scope.window")
        self.span.setToolTip("How many seconds of the last samples are shown")
        self.span.setCurrentIndex(max(0, self.span.findData(window_s)))
        self.span.currentIndexChanged.connect(self._renew)
        self.pause = QCheckBox("Pause")
        self.pause.setToolTip("Holds the picture; recording goes on")
        self.pause.toggled.connect(self._renew)
        self.key = Key(theme, *IQ_KEY)
        parts = (QLabel("Window"), self.span, self.pause, 1, self.key)
        top = fill(QHBoxLayout(), *parts, margins=(6, 4, 6, 0), spacing=6)
        self._grid = QGridLayout()
        self._grid.setSpacing(2)
        fill(QVBoxLayout(self), top, (self._grid, 1))

    @property
    def window_s(self) -> float:
        """Seconds shown."""
        return float(self.span.currentData())

    def set_receivers(self, count: int, full_scale_v: float) -> None:
        """Show so many receivers."""
        if count == len(self.scopes):
            return
        take_out(self._grid, *self.scopes, *self.levels)
        self.scopes, self.levels = [], []
        for index in range(count):
            # the time axis is the same for all: its words stand once, at the bottom
            scope = Scope(self._theme, index + 1, with_time=index == count - 1)
            scope.set_window(self.window_s)
            self.scopes.append(scope)
            self._grid.addWidget(scope, index, 0)
            bars = [LevelBar(self._theme, f"{part}{index + 1}", part.lower(), full_scale_v) for part in "IQ"]
            self.levels += bars
            self._grid.addLayout(fill(QVBoxLayout(), 1, *bars, 1), index, 1)
            # the last one holds the time axis as well
            self._grid.setRowStretch(index, 5 if index == count - 1 else 4)
        for index in range(count, self._grid.rowCount()):
            self._grid.setRowStretch(index, 0)
        self._grid.setColumnStretch(0, 1)

    def show_feed(self, feed: Feed | None) -> None:
        """Show another acquisition from its start; None keeps the last picture."""
        self._feed = feed
        if feed is not None:
            self.set_receivers(feed.n_receivers, feed.setup.daq.range_v)
            self.clear()
        else:
            self._forget_levels()
        self._renew()

    def clear(self) -> None:
        """Forget what was shown: it belongs to another session."""
        self._envelope = None
        for scope in self.scopes:
            scope.show_nothing()
        self.key.show_entries(*IQ_KEY)
        self._forget_levels()

    def refresh(self, health: Health | None) -> None:
        """Draw what is new; called by the window's timer."""
        if health is not None:
            by_name = {level.name: level for level in health.levels}
            for bar in self.levels:
                bar.show_level(by_name.get(bar.name))
        feed = self._feed
        if feed is None or self.pause.isChecked() or not self.isVisible() or feed.ring is None:
            return
        if self._envelope is None:
            bins = max(200, min(2000, self.scopes[0].width() if self.scopes else 0))
            self._envelope = Envelope(2 * len(self.scopes), feed.samples(self.window_s), bins)
        envelope = self._envelope
        if feed.ring.latest == envelope.end:
            return
        span = feed.ring.since(max(envelope.end, feed.ring.latest - feed.samples(self.window_s)))
        envelope.push(span.first_index, span.volts)
        index, pairs, lost = envelope.view()
        time_s = (index - envelope.end) / feed.rate_hz
        for number, scope in enumerate(self.scopes):
            scope.draw(time_s, pairs[2 * number : 2 * number + 2], lost)
        self.key.show_entries(*IQ_KEY, *([_LOST] if lost.any() else []))

    def _forget_levels(self) -> None:
        for bar in self.levels:
            bar.show_level(None)

    def _renew(self) -> None:
        """Draw anew: with another window, of another acquisition, after a pause."""
        self._envelope = None
        for scope in self.scopes:
            scope.set_window(self.window_s)
            scope.follow(self._feed is not None and not self.pause.isChecked())
