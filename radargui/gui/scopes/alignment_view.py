"""Alignment: how strongly each receiver sees what moves, as bars that are read across the room while one turns it."""

from __future__ import annotations

import math

import numpy as np
from PySide6.QtCore import QRectF, QSize, Qt
from PySide6.QtGui import QColor, QFontMetricsF, QPainter, QPaintEvent
from PySide6.QtWidgets import QSizePolicy, QVBoxLayout, QWidget

from radargui.gui.layout import PlainLabel, fill
from radargui.gui.plots.plot import round_up
from radargui.gui.scopes.shown import Follower, Shown
from radargui.gui.scopes.spectrum_view import decibels
from radargui.gui.theme import Theme, fitting_font, write
from radargui.model.arrays import FloatArray
from radargui.model.rounding import UNKNOWN

HALF_BAND_HZ = 1000.0
"""30 m/s of path at 10 GHz: whatever a hand or a fall moves."""
SPAN_S = 1.0
"""One swing of a sphere on a thread; a bar follows a turned antenna within it (chosen by hand)."""
_DEPTH_DB = 40.0
"""Height of the bars."""
_STEP_DB = 10.0
"""From line to line of the scale; its upper end is a whole number of them, so that it seldom moves."""
_WIDEST, _WIDEST_BELOW = "−88.8 dB", "88.8 dB below 88.888 V"
_POINTS = (7.0, 72.0)
"""Least and most of the figures: large, for they are read from the antennas; less is not read at all (by hand)."""
_QUIET = 0.01
"""Of the range: a smaller amplitude is no sphere that moves in front of the antennas (chosen by hand)."""


class Bars(QWidget):
    """One bar a receiver, its amplitude in dB and V, and the highest since the hold was let go."""

    def __init__(self, theme: Theme) -> None:
        super().__init__()
        self._theme = theme
        self.forget(3)
        self.setMinimumSize(200, 110)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        theme.changed.connect(self.update)

    def sizeHint(self) -> QSize:  # noqa: N802 - Qt's name
        """Return the least: the bars take what room there is, and never make the panel scroll."""
        return self.minimumSize()

    def forget(self, n_receivers: int) -> None:
        """Show a bar for each of so many receivers, of which nothing is known."""
        self.held_v: FloatArray = np.full(n_receivers, np.nan)
        self.show_amplitudes(self.held_v, 1.0)

    def show_amplitudes(self, amplitude_v: FloatArray, range_v: float) -> None:
        """Show amplitudes, shape (n_receivers,), of inputs with a range of +-`range_v`; NaN is not known."""
        self._range_v = range_v
        if amplitude_v.shape != self.held_v.shape:
            self.held_v = np.full(amplitude_v.shape, np.nan)
        self.amplitude_v = amplitude_v
        self.held_v = np.fmax(self.held_v, amplitude_v)
        self.setAccessibleName(self.text)
        self.update()

    def let_go(self) -> None:
        """Hold the highest from now on anew."""
        self.held_v = self.amplitude_v.copy()
        self.update()

    @property
    def text(self) -> str:
        """What is shown, in words."""
        pairs = zip(self.amplitude_v, self.held_v, strict=True)
        return "\n".join(f"Rx {n}: {', '.join(_said(*pair))}" for n, pair in enumerate(pairs, start=1))

    @property
    def shares(self) -> FloatArray:
        """Height of each bar, 0 to 1."""
        return self._share(self.amplitude_v)

    def _share(self, amplitude_v: FloatArray | float) -> FloatArray:
        return np.clip(1.0 + (decibels(amplitude_v) - self._top_db) / _DEPTH_DB, 0.0, 1.0)

    @property
    def _top_db(self) -> float:
        """Upper end of all bars: steady, whole tens of dB above the range's square root of two."""
        highest = float(np.nanmax(self.held_v)) if np.isfinite(self.held_v).any() else self._range_v
        return _STEP_DB * math.ceil(decibels(round_up(highest)) / _STEP_DB)

    def paintEvent(self, _event: QPaintEvent) -> None:  # noqa: N802 - Qt's name
        """Draw the bars side by side, the figures beneath them."""
        painter = QPainter(self)
        colours = self._theme.colours
        painter.fillRect(self.rect(), QColor(colours.base))
        count = len(self.amplitude_v)
        scale_px = QFontMetricsF(self.font()).horizontalAdvance("−88 dB ") + 6
        width = (self.width() - scale_px) / max(1, count)
        large = fitting_font(self.font(), _WIDEST, width - 12, self.height() / 6, _POINTS)
        small = fitting_font(self.font(), _WIDEST_BELOW, width - 8, self.height() / 15, _POINTS)
        heights = [QFontMetricsF(font).height() for font in (large, small, small)]
        title_px = heights[1] + 6
        bar = QRectF(scale_px, title_px, self.width() - scale_px, self.height() - sum(heights) - 12 - title_px)
        self._draw_scale(painter, bar)
        for number, (now, held) in enumerate(zip(self.amplitude_v, self.held_v, strict=True)):
            left = scale_px + number * width
            colour = colours.role(f"receivers.{number % len(colours.receivers)}")
            write(painter, QRectF(left, 2, width, title_px), f"Rx {number + 1}", colour, font=small)
            if math.isfinite(now):
                high = bar.height() * self.shares[number]
                painter.fillRect(QRectF(left + 0.15 * width, bar.bottom() - high, 0.7 * width, high), QColor(colour))
            if math.isfinite(held):
                at = bar.bottom() - bar.height() * float(self._share(held))
                painter.fillRect(QRectF(left + 0.05 * width, at - 1.5, 0.9 * width, 3), QColor(colours.text))
            y = bar.bottom() + 4
            for font, words, high in zip((large, small, small), _said(now, held), heights, strict=False):
                write(painter, QRectF(left, y, width, high), words, colours.text, font=font)
                y += high

    def _draw_scale(self, painter: QPainter, bar: QRectF) -> None:
        colours, top = self._theme.colours, self._top_db
        painter.setFont(self.font())
        right = int(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
        for step in range(int(_DEPTH_DB / _STEP_DB) + 1):
            y = bar.top() + bar.height() * step * _STEP_DB / _DEPTH_DB
            painter.setPen(QColor(colours.line))
            painter.drawLine(int(bar.left()), int(y), int(bar.right()), int(y))
            words = f"{top - step * _STEP_DB:.0f} dB".replace("-", "−")
            write(painter, QRectF(0, y - 10, bar.left() - 6, 20), words, colours.text, right)


class AlignmentView(QWidget):
    """Bars of the amplitude of the Doppler signal over the last second; `words` say what to do."""

    def __init__(self, theme: Theme) -> None:
        super().__init__()
        self.bars = Bars(theme)
        self.words = PlainLabel()
        self.words.setContentsMargins(6, 2, 6, 2)
        # two lines, whatever they say: the bars stay where they are
        self.words.setFixedHeight(2 * self.fontMetrics().lineSpacing() + 6)
        self.words.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Fixed)
        fill(QVBoxLayout(self), self.words, (self.bars, 1))
        self._follower = Follower()
        self.show_nothing()

    def show_nothing(self) -> None:
        """Forget what was shown."""
        self._drawn: tuple[object, ...] = ()
        self.bars.forget(self.bars.amplitude_v.size)
        self.words.setText("Start, swing the sphere on a thread, and turn an antenna until its bar is highest")

    def draw(self, shown: Shown) -> None:
        """Draw what is new; called each frame."""
        band = self._follower.follow(shown, HALF_BAND_HZ)
        amplitude = band.amplitude_v(SPAN_S) if (band, band.end) != self._drawn else np.empty(0)
        if not amplitude.size:
            return
        self._drawn = (band, band.end)
        range_v = shown.feed.setup.daq.range_v
        self.bars.show_amplitudes(amplitude, range_v)
        still = bool(np.nanmax(amplitude, initial=0.0) < _QUIET * range_v)
        turn = "Turn an antenna until its bar is highest; the line is the highest so far. dB are re 1 V of amplitude"
        self.words.setText("Nothing moves: swing the sphere on a thread through the field of view" if still else turn)


def _said(now: float, held: float) -> tuple[str, str, str]:
    """Return the amplitude in dB and in V, and how far below the highest it is."""
    if not math.isfinite(now):
        return UNKNOWN, "", ""
    below = f"{decibels(held) - decibels(now):.1f} dB below {_volts(held)}" if now < held else "the highest so far"
    return f"{decibels(now):z.1f} dB".replace("-", "−"), _volts(now), below


def _volts(value: float) -> str:
    return f"{value:.3f} V" if value >= 0.1 else f"{1e3 * value:.1f} mV"
