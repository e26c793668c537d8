"""The channel table of the hardware panel: inputs, and what they show now or in a moment that is read for it."""

from collections.abc import Callable
from dataclasses import dataclass
from datetime import datetime
from functools import partial
from typing import Any

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QApplication, QSizePolicy

from radargui.acquisition.health import ChannelFacts, channel_facts
from radargui.gui.control.state import AppState, Feed
from radargui.gui.layout import PlainLabel, button, having, ticking
from radargui.gui.panels import Actions
from radargui.gui.services import Services
from radargui.gui.setup.fields import ModelGroup
from radargui.gui.setup.setup_model import SetupModel
from radargui.gui.table import RowModel, RowTable
from radargui.model.rounding import UNKNOWN, with_sign
from radargui.model.words import percent

MOMENT_S = 1.0
"""Long enough for ten turns of a hum of 10 Hz, short enough to wait for."""
_LOOK_MS = 200
"""Chosen by hand: a reading takes up to so much longer than `MOMENT_S`."""
_EVERY = 5
"""Looks from one reading to the next while samples come in: once a second can be read."""


@dataclass(frozen=True, slots=True)
class Channel:
    """A row: the channel's name as in recordings (I1), the input it is wired to, what it shows."""

    name: str
    wired_to: str
    shows: ChannelFacts | None = None

    @property
    def level(self) -> str:
        """Largest voltage, and how much of the range that is."""
        if self.shows is None:
            return UNKNOWN
        peak_v, most_v = self.shows.level.peak_v, self.shows.level.full_scale_v
        return f"{peak_v:.2f} ({percent(peak_v / most_v)})" if most_v else f"{peak_v:.2f}"

    @property
    def clips(self) -> str:
        """Whether a sample stood at the end of the range."""
        return UNKNOWN if self.shows is None else "CLIPS" if self.shows.level.clipped else "no"


# title of a column, and what stands in it; 1e3: from V to mV
_COLUMNS: dict[str, Callable[[Channel], str]] = {
    "Channel": lambda one: f"Rx {one.name[1:]} {one.name[0]}",
    "Input": lambda one: one.wired_to,
    "Level [V]": lambda one: one.level,
    "Offset [V]": lambda one: UNKNOWN if one.shows is None else with_sign(one.shows.offset_v, 3),
    "Noise [mV]": lambda one: UNKNOWN if one.shows is None else f"{1e3 * one.shows.noise_v:.2f}",
    "Clips": lambda one: one.clips,
}


class ChannelModel(RowModel[Channel]):
    """Rows of channels; one that clips is said in the alarm's colour too."""

    def cell(self, entry: Channel, column: int, role: int) -> Any:
        """Return what Qt asks of a cell."""
        alarm = role == Qt.ItemDataRole.ForegroundRole and entry.clips == "CLIPS"
        return QApplication.palette().brightText().color() if alarm else super().cell(entry, column, role)


class ChannelGroup(ModelGroup):
    """The table: of the acquisition that runs, or of a live view that ends by itself after a moment."""

    def __init__(self, model: SetupModel, does: Actions, services: Services) -> None:
        self._start, self._services, self._control = does.start, services, services.control
        self._feed: Feed | None = None
        self._own = self._busy = False
        self._looks = 0
        table = RowTable(ChannelModel(_COLUMNS), "channels")
        self.table = having(table, selectionMode=RowTable.SelectionMode.NoSelection)
        # in the order of the inputs: a sign of sorting would take a column's room
        self.table.setSortingEnabled(False)
        self.table.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        # as high as its rows; its columns fit the narrowest panel
        for scrolled in (self.table.setVerticalScrollBarPolicy, self.table.setHorizontalScrollBarPolicy):
            scrolled(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.table.setToolTip("What each input shows; while samples come in it is brought up to date once a second")
        self.read = button("Read a moment", does.moment.trigger, does.moment.toolTip())
        self.words = PlainLabel("Nothing was read yet.")
        super().__init__("Channels", model, self.table, self.read, self.words)
        self._timer = ticking(self, _LOOK_MS, self._look)
        self._control.feed_changed.connect(self._feed_changed)
        self._control.state_changed.connect(self._state_changed)

    def show_facts(self, facts: tuple[ChannelFacts, ...]) -> None:
        """Show what the channels show; none: nothing is known any more."""
        by_name, before = {one.level.name: one for one in facts}, self.table.rows.entries
        wires = zip(self._model.setup.channel_names, self._wires, strict=True)
        rows = [Channel(name, wire, by_name.get(name)) for name, wire in wires]
        self.table.rows.replace_all(rows)
        if not (facts and any(one.shows for one in before)):
            # not each second: it takes half as long as a frame
            self.table.fit_all()
        if {one.name for one in before} != {one.name for one in rows}:
            header, row = self.table.horizontalHeader(), self.table.verticalHeader().defaultSectionSize()
            self.table.setFixedHeight(header.sizeHint().height() + row * len(rows) + 4)

    @property
    def _wires(self) -> list[str]:
        return [wire.rpartition("/")[2] for wire in self._model.setup.physical_channels]

    def refresh(self) -> None:
        """Forget what was read through other wires."""
        if [one.wired_to for one in self.table.rows.entries] != self._wires:
            self.show_facts(())

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
