"""What each channel shows, as bars: of the acquisition that runs, or of a moment that is read for it."""

import math
from datetime import datetime
from functools import partial

from PySide6.QtWidgets import QGridLayout, QHBoxLayout, QVBoxLayout, QWidget

from radargui.acquisition.health import ChannelFacts, channel_facts, snr_db
from radargui.gui.control.state import AppState, Feed
from radargui.gui.layout import TIPS, OneLine, boxed, button, fill, follow, having, take_out, ticking
from radargui.gui.panels import Actions
from radargui.gui.scopes.scope import LevelBar
from radargui.gui.services import Services
from radargui.gui.setup.setup_model import SetupModel
from radargui.gui.theme import Theme
from radargui.model.rounding import with_sign
from radargui.model.words import percent

MOMENT_S = 1.0
"""Long enough for ten turns of a hum of 10 Hz, short enough to wait for."""
_LOOK_MS = 200
"""Chosen by hand: a reading takes up to so much longer than `MOMENT_S`."""
_EVERY = 5
"""Looks from one reading to the next while samples come in: once a second can be read."""


class ChannelBar(LevelBar):
    """A channel with the input it is wired to: level and clipping as a bar, offset, noise, drift and SNR in words.

    Attributes
    ----------
    name, wired_to
        As in recordings (I1), and the input of the device.
    facts
        What is shown; None: nothing is known.
    """

    n_lines = 2

    def __init__(self, theme: Theme, name: str, wired_to: str, full_scale_v: float) -> None:
        super().__init__(theme, name, name[0].lower(), full_scale_v)
        self.wired_to = wired_to
        self.show_facts(None)

    def show_facts(self, facts: ChannelFacts | None, ratio_db: float = math.nan) -> None:
        """Show what the channel shows, and the signal-to-noise ratio of its receiver."""
        self.facts: ChannelFacts | None = facts
        self.show_level(facts.level if facts else None)
        level, rest = "–", ""
        if facts is not None:
            peak_v, max_v = facts.level.peak_v, facts.level.full_scale_v
            share = f" ({percent(peak_v / max_v)})" if max_v else ""
            level = f"{peak_v:.2f} V{share}, offset {with_sign(facts.offset_v, 3)} V"
            noise = "" if math.isnan(facts.noise_v) else f"noise {1e3 * facts.noise_v:.2f} mV"
            ratio = "" if math.isnan(ratio_db) else f"SNR {ratio_db:.0f} dB"
            drift = "" if math.isnan(facts.drift_v) else f"drift {with_sign(1e3 * facts.drift_v, 1)} mV"
            rest = ", ".join(filter(None, (ratio, noise, drift)))
        first = f"{self.name} {self.wired_to}: {'CLIPS ' * self.clipping}{level}"
        whole = ", ".join(filter(None, (first, rest)))
        self.say(f"{whole}\n{TIPS['plots']['Channels']}", first, rest)


class ChannelPanel(QWidget):
    """A bar a channel: of the acquisition that runs, or of a live view that ends by itself after a moment.

    Attributes
    ----------
    bars
        In the order of the inputs.
    """

    def __init__(self, model: SetupModel, does: Actions, services: Services) -> None:
        super().__init__()
        self._model, self._start, self._services, self._control = model, does.start, services, services.control
        self._feed: Feed | None = None
        self._own = self._busy = False
        self._looks = 0
        self.bars: list[ChannelBar] = []
        self._grid = having(QGridLayout(), spacing=4)
        actions = does.moment, does.wiring, does.calibrate
        self.read, *others = (button(one.text(), one.trigger, one.toolTip()) for one in actions)
        self.words = OneLine("Nothing was read yet.")
        column = boxed(QVBoxLayout(), self.read, *others, 1, spacing=3)
        shown = fill(QVBoxLayout(), self._grid, self.words, 1)
        fill(QHBoxLayout(self), (shown, 1), column, margins=(6, 2, 6, 2), spacing=8)
        self._timer = ticking(self, _LOOK_MS, self._look)
        self._control.feed_changed.connect(self._feed_changed)
        self._control.state_changed.connect(self._state_changed)
        follow(model.changed, self.refresh)

    def show_facts(self, facts: tuple[ChannelFacts, ...]) -> None:
        """Show what the channels show; none: nothing is known any more."""
        by_name = {one.level.name: one for one in facts}
        for bar in self.bars:
            i, q = (by_name.get(f"{part}{bar.name[1:]}") for part in "IQ")
            bar.show_facts(by_name.get(bar.name), snr_db(i, q) if i is not None and q is not None else math.nan)

    def refresh(self) -> None:
        """Forget what was read through other wires, and have a bar for each of these."""
        setup = self._model.setup
        wires = [wire.rpartition("/")[2] for wire in setup.physical_channels]
        if [(one.name, one.wired_to) for one in self.bars] == [*zip(setup.channel_names, wires, strict=True)]:
            return
        take_out(self._grid, *self.bars)
        theme, max_v = self._services.theme, setup.daq.range_v
        self.bars = [ChannelBar(theme, *of, max_v) for of in zip(setup.channel_names, wires, strict=True)]
        for number, bar in enumerate(self.bars):
            # a receiver a column, I above Q
            self._grid.addWidget(bar, number % 2, number // 2)

    @property
    def is_reading(self) -> bool:
        """Whether a moment is being read."""
        return self._own

    def read_moment(self) -> None:
        """Read a moment from the source chosen; nothing is recorded."""
        if self._control.state.running:
            return
        self._own = True
        self.words.setText("Reading …")
        self._start.trigger()
        # refused before anything ran
        self._state_changed()

    def _feed_changed(self, feed: Feed | None) -> None:
        last, self._feed = self._feed, feed
        if feed is not None:
            self._looks = 0
            self._timer.start()
            return
        self._timer.stop()
        if last is not None:
            # a short file ends before the moment does
            self._take(last, over=True)

    def _state_changed(self) -> None:
        running = self._control.state.running
        self.read.setEnabled(not running)
        if not running and self._own:
            self._own = False
            self.words.setText("Nothing could be read: see the message above.")

    def _look(self) -> None:
        feed = self._feed
        if feed is None:
            return
        if self._own and self._control.state is AppState.LIVE and feed.ring.latest >= feed.samples(MOMENT_S):
            self._control.stop()
        self._looks += 1
        if not self._own and self._looks % _EVERY == 0 and self.isVisible():
            self._take(feed)

    def _take(self, feed: Feed, *, over: bool = False) -> None:
        if self._busy and not over:
            return
        own, self._own = self._own and over, self._own and not over
        seconds = min(feed.ring.latest, feed.samples(MOMENT_S)) / feed.rate_hz
        at = f"{datetime.now().astimezone():%H:%M:%S}"
        words = f"A moment read at {at}: the last {seconds:.2f} s, nothing recorded." if own else f"As at {at}."

        def show(facts: tuple[ChannelFacts, ...]) -> None:
            self._busy = False
            self.show_facts(facts)
            self.words.setText(words if facts else "No samples came.")

        def failed(error: BaseException) -> None:
            self._busy = False
            self._services.board.post_error(error)

        self._busy = True
        work = partial(channel_facts, feed.ring, feed.digitisation, feed.samples(MOMENT_S))
        self._services.jobs.start("the levels of the channels", work, show, failed)
