"""The panel of the live scopes: time, spectrum, waterfall or bars for aligning; a pause that can be scrolled back."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from dataclasses import replace

from PySide6 import QtWidgets
from PySide6.QtCore import QMargins, Qt

from radargui.acquisition.envelope import Envelope, look
from radargui.acquisition.health import Health, duration
from radargui.acquisition.run_output import Level
from radargui.gui.control.state import Feed
from radargui.gui.layout import TIPS, Choice, Pages, boxed, button, fill, having, take_out
from radargui.gui.plots.key import IQ_KEY, Key
from radargui.gui.plots.plot import LAST, NOW
from radargui.gui.scopes.alignment_view import SPAN_S, AlignmentView
from radargui.gui.scopes.scope import HELD, GainDialog, LevelBar, Scope
from radargui.gui.scopes.shown import Shown
from radargui.gui.scopes.spectrum_view import BANDS_HZ, SpectrumView, WaterfallView
from radargui.gui.theme import Theme
from radargui.model.arrays import BoolArray, FloatArray

WINDOWS_S = (0.5, 1.0, 2.0, 3.0, 5.0, 9.0)
"""What may be chosen: the ring holds ten seconds."""
_LOST = ("■", "gap", "samples lost")
VIEWS = {"time": "Time", "spectrum": "Spectrum", "waterfall": "Waterfall", "alignment": "Alignment"}
_PER_S = 100
"""Steps of the slider a second."""
_SPANS = [(seconds, f"{seconds:g} s") for seconds in WINDOWS_S]
# for a choice: what is kept in Hz, and its words, from 1e3 Hz on in kHz
_BANDS = [(hertz, f"±{hertz / 1e3:g} kHz" if hertz >= 1e3 else f"±{hertz:g} Hz") for hertz in BANDS_HZ]


class TimeView(QtWidgets.QWidget):
    """I and Q of each receiver against time, the level of each channel beside them."""

    def __init__(self, theme: Theme) -> None:
        super().__init__()
        self._theme = theme
        self.scopes: list[Scope] = []
        self.levels: list[LevelBar] = []
        self._columns: list[QtWidgets.QWidget] = []
        self._envelope: Envelope | None = None
        self._live: tuple[object, ...] = ()
        self._held: tuple[object, ...] = ()
        self.gain = button("Gain…", self.ask_gain)
        self._grid = having(QtWidgets.QGridLayout(self), contentsMargins=QMargins(), spacing=2)
        self.any_lost = False

    def set_receivers(self, count: int, full_scale_v: float) -> None:
        """Show so many receivers."""
        # columns are widgets: of a layout within the layout PySide keeps each item by its address, and where it was
        # deleted with what it held, a later widget at this address took both with it (segmentation fault)
        take_out(self._grid, *self.scopes, *self._columns)
        last = count - 1
        # the time axis is the same for all: its words stand once, at the bottom
        self.scopes = [Scope(self._theme, index + 1, with_time=index == last) for index in range(count)]
        names = [(part, index) for index in range(1, count + 1) for part in "IQ"]
        self.levels = [LevelBar(self._theme, f"{part}{index}", part.lower(), full_scale_v) for part, index in names]
        self._columns = []
        for index, scope in enumerate(self.scopes):
            scope.setXLink(None if index == last else self.scopes[last])
            scope.view.sigXRangeChanged.connect(self.look_again)
            below = [self.gain] if index == last else []
            column = boxed(QtWidgets.QVBoxLayout(), 1, *self.levels[2 * index : 2 * index + 2], 1, *below)
            self._columns.append(column)
            self._grid.addWidget(scope, index, 0)
            self._grid.addWidget(column, index, 1)
            # the last one holds the time axis as well
            self._grid.setRowStretch(index, 5 if index == last else 4)
        for index in range(count, self._grid.rowCount()):
            self._grid.setRowStretch(index, 0)
        self._grid.setColumnStretch(0, 1)

    def show_nothing(self) -> None:
        """Forget what was shown."""
        self._envelope, self._held, self.any_lost = None, (), False
        for scope in self.scopes:
            scope.show_nothing()

    def show_levels(self, levels: Iterable[Level] = ()) -> None:
        """Show the levels of the channels; of one that is not among them nothing is known."""
        by_name = {level.name: level for level in levels}
        for bar in self.levels:
            bar.show_level(by_name.get(bar.name))

    def look_again(self, *_: object) -> None:
        """Draw what is held anew: another part of it is seen."""
        self._held = ()

    def draw(self, shown: Shown) -> None:
        """Draw what is new; called each frame."""
        (self._draw_live if shown.live else self._draw_held)(shown)

    def ask_gain(self) -> None:
        """Let gain and offset be set."""
        dialog = GainDialog(self.scopes, self)
        dialog.finished.connect(dialog.deleteLater)
        dialog.come_up()

    @property
    def _bins(self) -> int:
        return max(200, min(2000, self.scopes[0].width() if self.scopes else 0))

    def _draw_live(self, shown: Shown) -> None:
        window = round(shown.window_s * shown.feed.rate_hz)
        if self._envelope is None or self._live != (shown.feed.ring, window):
            self._live = (shown.feed.ring, window)
            self._envelope = Envelope(2 * len(self.scopes), window, self._bins)
        envelope = self._envelope
        if shown.end == envelope.end:
            return
        span = shown.feed.ring.span(max(envelope.end, shown.first), shown.end)
        envelope.push(span.first_index, span.volts)
        index, pairs, lost = envelope.view()
        self._put((index - envelope.end) / shown.feed.rate_hz, pairs, lost, envelope.bin)

    def _draw_held(self, shown: Shown) -> None:
        self._envelope = None
        if self._held == shown.part:
            return
        first, last = shown.first, shown.end
        if self.scopes and self.scopes[-1].view.zoomed:
            # as fine as the samples are, where it is looked at closely
            left, right = (round(x * shown.feed.rate_hz) + shown.zero for x in self.scopes[-1].view.viewRange()[0])
            first, last = max(shown.feed.ring.first, left), min(shown.zero, right)
        if last <= first:
            return
        index, pairs, lost, size = look(shown.feed.ring, first, last, self._bins)
        self._put((index - shown.zero) / shown.feed.rate_hz, pairs, lost, size)
        self._held = shown.part

    def _put(self, time_s: FloatArray, pairs: FloatArray, lost: BoolArray, size: int) -> None:
        for number, scope in enumerate(self.scopes):
            scope.draw(time_s, pairs[2 * number : 2 * number + 2], lost, size)
        self.any_lost = bool(lost.any())


class ScopePanel(QtWidgets.QWidget):
    """What comes in, looked at in one of four ways; pausing holds the picture, never the samples.

    Parameters
    ----------
    window_s
        Seconds shown at first.
    clock
        Seconds since 1970; injected by tests.
    """

    def __init__(self, theme: Theme, window_s: float = 3.0, clock: Callable[[], float] = time.time) -> None:
        super().__init__()
        self._theme, self._clock = theme, clock
        self._feed: Feed | None = None
        self._last: Feed | None = None
        self._held: Feed | None = None
        self._held_at_s = 0.0
        self.time, self.spectrum = TimeView(theme), SpectrumView(theme)
        self.waterfall, self.alignment = WaterfallView(theme), AlignmentView(theme)
        pages = (self.time, self.spectrum, self.waterfall, self.alignment)
        self.pages = Pages(VIEWS, {}, **dict(zip(VIEWS, pages, strict=True)))

        self.view, self.span, self.band = Choice(VIEWS.items()), Choice(_SPANS, window_s), Choice(_BANDS, BANDS_HZ[1])
        self.let_go = button("Hold anew", self.alignment.bars.let_go)
        self.pause = QtWidgets.QCheckBox("Pause")
        self.key = having(Key(theme, *IQ_KEY), minimumWidth=0)
        self.key.setSizePolicy(QtWidgets.QSizePolicy.Policy.Minimum, QtWidgets.QSizePolicy.Policy.Preferred)
        parts = (self.view, self.span, self.band, self.let_go, self.pause, 1, self.key)
        top = fill(QtWidgets.QHBoxLayout(), *parts, margins=(6, 4, 6, 0), spacing=6)

        self.when = QtWidgets.QLabel()
        self.back = having(QtWidgets.QSlider(Qt.Orientation.Horizontal), focusPolicy=Qt.FocusPolicy.StrongFocus)
        self._past = boxed(QtWidgets.QHBoxLayout(), self.when, (self.back, 1), margins=(6, 2, 6, 0), spacing=8)
        self._past.hide()
        choices = {"What the scopes show": self.view, "Window of time": self.span, "Band of the spectrum": self.band}
        for what, part in (choices | {"Back through what is held": self.back, "Pause": self.pause}).items():
            having(part, accessibleName=what, toolTip=TIPS["scopes"][what])
        for choice in choices.values():
            # in a narrow dock their words are cut before the plots are
            choice.setMinimumWidth(46)
        fill(QtWidgets.QVBoxLayout(self), top, self._past, (self.pages, 1))

        self.view.currentIndexChanged.connect(self._choose)
        self.pause.toggled.connect(self._pause)
        for changed in (self.span.currentIndexChanged, self.band.currentIndexChanged, self.back.valueChanged):
            changed.connect(self._renew)
        self._choose()

    @property
    def window_s(self) -> float:
        """Seconds shown."""
        return float(self.span.currentData())

    def set_receivers(self, count: int, full_scale_v: float) -> None:
        """Show so many receivers."""
        if count == len(self.time.scopes):
            return
        self.time.set_receivers(count, full_scale_v)
        # made anew it would come last of all
        self.setTabOrder(self.back, self.time.gain)
        self.waterfall.set_receivers(count)
        self.alignment.bars.forget(count)
        # samples of as many receivers as there were, held or not, are not drawn into these
        self.pause.setChecked(False)
        self.clear()
        self._renew()

    def show_feed(self, feed: Feed | None) -> None:
        """Show another acquisition from its start; None keeps the last picture, and so does a pause."""
        self._last = self._feed or self._last
        self._feed = feed
        if feed is None:
            self.time.show_levels()
        if self._held is not None:
            return
        if feed is not None:
            self.set_receivers(feed.n_receivers, feed.setup.daq.range_v)
            self.clear()
        self._renew()

    def clear(self) -> None:
        """Forget what was shown: it belongs to another session."""
        self._last = None
        for page in self.pages.made.values():
            page.show_nothing()
        self.time.show_levels()
        self._say()

    def refresh(self, health: Health | None) -> None:
        """Draw what is new; called by the window's timer."""
        if health is not None:
            self.time.show_levels(health.levels)
        if self._held is not None:
            at = time.strftime("%H:%M:%S", time.localtime(self._held_at_s))
            self.when.setText(f"paused at {at}, {duration(self._clock() - self._held_at_s)} ago")
        shown = self._shown()
        if shown is None or not self.isVisible():
            return
        page = self.pages.made[self.pages.shown]
        page.draw(replace(shown, window_s=max(shown.window_s, SPAN_S)) if page is self.alignment else shown)
        self._say()

    def _shown(self) -> Shown | None:
        # after the end the last samples are there for every view
        feed = self._held or self._feed or self._last
        if feed is None:
            return None
        zero = feed.ring.latest
        end = zero - round(self._back_s * feed.rate_hz)
        return Shown(feed, end, zero, self.window_s, live=self._held is None)

    @property
    def _back_s(self) -> float:
        """How far before the pause the picture ends."""
        return (self.back.maximum() - self.back.value()) / _PER_S if self._held is not None else 0.0

    def _pause(self) -> None:
        feed = self._feed or self._last
        self._held = None
        if self.pause.isChecked() and feed is not None:
            # a copy, so that the recording goes on beneath it
            ring, self._held_at_s = feed.ring.held(), self._clock()
            self._held = Feed(ring, feed.digitisation, feed.live, feed.setup)
            held_s = (ring.latest - ring.first) / feed.rate_hz
            self.back.setRange(0, max(0, round((held_s - self.window_s) * _PER_S)))
            self.back.setPageStep(round(self.window_s * _PER_S))
            self.back.setSingleStep(max(1, round(0.1 * self.window_s * _PER_S)))
            self.back.setValue(self.back.maximum())
        self._past.setVisible(self._held is not None)
        self._renew()

    def _choose(self) -> None:
        name = self.view.currentData()
        self.pages.turn_to(name)
        self.let_go.setVisible(name == "alignment")
        self.band.setVisible(name in ("spectrum", "waterfall"))
        self.span.setVisible(name != "alignment")
        self.key.setVisible(name == "time")
        self._renew()

    def _say(self) -> None:
        self.key.show_entries(*IQ_KEY, *([_LOST] if self.time.any_lost else []))

    def _renew(self) -> None:
        """Draw anew: with another window, of another acquisition, after a pause."""
        self.time.look_again()
        self.spectrum.half_band_hz = self.waterfall.half_band_hz = float(self.band.currentData())
        words = HELD if self._back_s else LAST if self._held is not None or self._feed is None else NOW
        for scope in self.time.scopes:
            scope.view.show_all()
            scope.setXRange(-self._back_s - self.window_s, -self._back_s, padding=0)
        for plot in (*self.time.scopes[-1:], *self.waterfall.plots[-1:]):
            # the only ones with words on their time axes
            plot.relabel(words)
        self._say()
