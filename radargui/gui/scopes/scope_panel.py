"""The panel of the live scopes: one a receiver, with levels, a window of seconds and a pause."""

from PySide6.QtCore import QRectF, QSize, Qt, Signal
from PySide6.QtGui import QColor, QPainter, QPaintEvent
from PySide6.QtWidgets import QCheckBox, QGridLayout, QHBoxLayout, QLabel, QVBoxLayout, QWidget

from radargui.acquisition.health import Health
from radargui.acquisition.level import Level
from radargui.gui.control.feed import Feed
from radargui.gui.layout import Choice, fill, take_out
from radargui.gui.plots.envelope import Envelope
from radargui.gui.plots.plot import Key
from radargui.gui.scopes.scope import Scope
from radargui.gui.theme import Theme, scaled_font

_HOLD_LOOKS = 5


class LevelBar(QWidget):
    """A bar from 0 to full scale; clipping is said by a word and stays readable for a second."""

    def __init__(self, theme: Theme, name: str, role: str, full_scale_v: float) -> None:
        super().__init__()
        self._theme = theme
        self._name = name
        self._role = role
        self._full_scale_v = full_scale_v
        self._peak_v: float | None = None
        self._held = 0
        self.setFont(scaled_font(self.font(), 0.85))
        self.setMinimumSize(self.sizeHint())
        theme.changed.connect(self.update)

    def sizeHint(self) -> QSize:  # noqa: N802 - Qt's name
        """Return the size that fits name, voltage and bar."""
        metrics = self.fontMetrics()
        return QSize(metrics.horizontalAdvance("I1 00.00 V") + 12, 2 * metrics.height() + 8)

    @property
    def clipping(self) -> bool:
        """Whether the light is on."""
        return self._held > 0

    def show_level(self, level: Level | None) -> None:
        """Show a level; None: nothing is known."""
        clipped = level is not None and level.clipped
        self._held = _HOLD_LOOKS if clipped else max(0, self._held - 1)
        self._peak_v = None if level is None else level.peak_v
        if level is None:
            self._held = 0
        elif level.full_scale_v:
            self._full_scale_v = level.full_scale_v
        share = "" if self._peak_v is None else f"{100 * self._peak_v / self._full_scale_v:.0f} % of the range"
        self.setToolTip(f"{self._name}: {share}{', clipping: lower the gain or raise the range' * self.clipping}")
        self.update()

    def paintEvent(self, _event: QPaintEvent) -> None:  # noqa: N802 - Qt's name
        """Draw name, voltage and bar."""
        colours = self._theme.colours
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        height = self.fontMetrics().height()
        top = QRectF(4, 1, self.width() - 8, height)
        value = "–" if self._peak_v is None else f"{self._peak_v:.2f} V"
        painter.setPen(QColor(colours.alarm if self.clipping else colours.text))
        painter.drawText(top, Qt.AlignmentFlag.AlignLeft, self._name)
        painter.drawText(top, Qt.AlignmentFlag.AlignRight, "CLIP" if self.clipping else value)
        bar = QRectF(4, height + 4, self.width() - 8, max(6.0, 0.5 * height))
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(QColor(colours.raised))
        painter.drawRoundedRect(bar, 3, 3)
        share = 0.0 if self._peak_v is None else min(1.0, self._peak_v / self._full_scale_v)
        if share > 0.0:
            bar.setWidth(max(4.0, bar.width() * share))
            painter.setBrush(QColor(colours.alarm if self.clipping else colours.role(self._role)))
            painter.drawRoundedRect(bar, 3, 3)
        painter.end()


WINDOWS_S = (0.5, 1.0, 2.0, 3.0, 5.0, 9.0)
"""What may be chosen: the ring holds ten seconds."""
_KEY = (("▬", "i", "I"), ("▬", "q", "Q"))
_LOST = ("■", "gap", "samples lost")


class ScopePanel(QWidget):
    """I and Q against time; pausing holds the picture, never the samples."""

    paused_changed = Signal(bool)

    def __init__(self, theme: Theme, window_s: float = 3.0) -> None:
        super().__init__()
        self._theme = theme
        self._feed: Feed | None = None
        self._envelope: Envelope | None = None
        self.scopes: list[Scope] = []
        self.levels: list[LevelBar] = []

        self.span = Choice((seconds, f"{seconds:g} s") for seconds in WINDOWS_S)
        self.span.setObjectName("scope.window")
        self.span.setCurrentIndex(max(0, self.span.findData(window_s)))
        self.span.currentIndexChanged.connect(self._new_window)
        self.pause = QCheckBox("Pause")
        self.pause.setToolTip("Holds the picture; recording goes on")
        self.pause.toggled.connect(self._pause)
        self.key = Key(theme, *_KEY)
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
        self._envelope = None
        if feed is not None:
            self.set_receivers(feed.n_receivers, feed.range_v)
            self.clear()
        else:
            self._forget_levels()
        self._follow()

    def clear(self) -> None:
        """Forget what was shown: it belongs to another session."""
        self._envelope = None
        for scope in self.scopes:
            scope.clear_data()
        self.key.show_entries(*_KEY)
        self._forget_levels()

    def refresh(self, health: Health | None) -> None:
        """Draw what is new; called by the window's timer."""
        if health is not None:
            by_name = {level.name: level for level in health.levels}
            for bar, name in zip(self.levels, self._names(), strict=False):
                bar.show_level(by_name.get(name))
        feed = self._feed
        if feed is None or self.pause.isChecked() or not self.isVisible() or feed.ring is None:
            return
        envelope = self._envelope_for(feed)
        if feed.ring.latest == envelope.end:
            return
        span = feed.ring.since(max(envelope.end, feed.ring.latest - feed.samples(self.window_s)))
        envelope.push(span.first_index, span.volts)
        index, pairs, lost = envelope.view()
        time_s = (index - envelope.end) / feed.rate_hz
        for number, scope in enumerate(self.scopes):
            scope.draw(time_s, pairs[2 * number : 2 * number + 2], lost)
        self.key.show_entries(*_KEY, *([_LOST] if lost.any() else []))

    def _forget_levels(self) -> None:
        for bar in self.levels:
            bar.show_level(None)

    def _names(self) -> list[str]:
        return [f"{part}{index + 1}" for index in range(len(self.scopes)) for part in "IQ"]

    def _envelope_for(self, feed: Feed) -> Envelope:
        if self._envelope is None:
            bins = max(200, min(2000, self.scopes[0].width() if self.scopes else 0))
            self._envelope = Envelope(2 * len(self.scopes), feed.samples(self.window_s), bins)
        return self._envelope

    def _new_window(self) -> None:
        self._envelope = None
        for scope in self.scopes:
            scope.set_window(self.window_s)

    def _pause(self, paused: bool) -> None:
        self._envelope = None
        self._follow()
        self.paused_changed.emit(paused)

    def _follow(self) -> None:
        for scope in self.scopes:
            scope.follow(self._feed is not None and not self.pause.isChecked())
