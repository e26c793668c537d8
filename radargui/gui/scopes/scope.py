"""The scope of one receiver: I and Q against time, gain and offset for the eye, and the levels beside it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QRectF, Qt
from PySide6.QtGui import QColor, QPainter, QPaintEvent
from PySide6.QtWidgets import QDoubleSpinBox, QGridLayout, QHBoxLayout, QLabel, QWidget

from radargui.acquisition.run_output import Level
from radargui.gui.dialog import Dialog
from radargui.gui.layout import button, fill, having, labelled
from radargui.gui.plots.plot import LAST, Plot, SteadyRange
from radargui.gui.theme import Theme, scaled_font, write
from radargui.model.arrays import BoolArray, FloatArray, runs_of
from radargui.model.words import percent

_FAR_V = 1000.0
"""A shade reaches beyond every range of voltage."""
HELD = "time before the pause [s]"


@dataclass(frozen=True, slots=True)
class Gain:
    """How a channel is drawn: `factor` times (voltage - `offset_v`). Samples, files and results know nothing of it."""

    factor: float = 1.0
    offset_v: float = 0.0

    @property
    def plain(self) -> bool:
        """Whether the axis tells the voltage as it is."""
        return self == Gain()

    def drawn(self, volts: FloatArray) -> FloatArray:
        """Return where voltages are drawn."""
        return volts if self.plain else self.factor * (volts - self.offset_v)

    def volts(self, drawn: FloatArray) -> FloatArray:
        """Return the voltages that are drawn there."""
        return drawn if self.plain else drawn / self.factor + self.offset_v

    def words(self, name: str) -> str:
        """Return what is drawn, as a formula: 10 × (I − 0.25 V)."""
        if self.plain:
            return name
        moved = f"({name} {'−' if self.offset_v > 0 else '+'} {abs(self.offset_v):g} V)" if self.offset_v else name
        return f"{self.factor:g} × {moved}" if self.factor != 1.0 else moved.strip("()")


class Scope(Plot):
    """Rolling view; the newest sample shown is at 0, the past to the left."""

    def __init__(self, theme: Theme, number: int, *, with_time: bool) -> None:
        self._lost = pg.BarGraphItem(x0=[], x1=[], y0=-_FAR_V, y1=_FAR_V, pen=None)
        self._plain = f"Rx {number} [V]"
        axes = (LAST if with_time else "", self._plain)
        super().__init__(theme, *axes, left_px=50, live=True, density=0.6, figures_below=with_time)
        self._lost.setZValue(-10)
        self.addItem(self._lost, ignoreBounds=True)
        self._curves = (self.fast_line("i", "I"), self.fast_line("q", "Q"))
        self.gains = (Gain(), Gain())
        self._bin = 1
        self.setYRange(-1.0, 1.0, padding=0)
        self.setXRange(-3.0, 0.0, padding=0)

    def set_gains(self, i: Gain, q: Gain) -> None:
        """Draw the channels otherwise, and say so on the axis and in the plot."""
        self.gains = (i, q)
        scaled = not (i.plain and q.plain)
        # short enough for the lowest plot; what it means stands inside
        self.relabel(left="scaled" if scaled else self._plain)
        self.write_inside(f"{self._plain.partition(' [')[0]}: {i.words('I')},  {q.words('Q')}" if scaled else "")
        self.steady = SteadyRange()

    def draw(self, time_s: FloatArray, volts: FloatArray, lost: BoolArray, bin_: int = 1) -> None:
        """Draw minimum and maximum of each pixel column.

        Parameters
        ----------
        time_s
            Shape (2 n,), 0 is now.
        volts
            I and Q, shape (2, 2 n).
        lost
            Whether samples of the column were lost, shape (n,).
        bin_
            Samples of a column.
        """
        self._bin = bin_
        drawn = np.stack([gain.drawn(row) for gain, row in zip(self.gains, volts, strict=True)])
        for curve, values in zip(self._curves, drawn, strict=True):
            curve.setData(time_s, values)
        known = drawn[np.isfinite(drawn)]
        if known.size:
            self.fit_y(float(known.min()), float(known.max()))
        self._shade(time_s, lost)

    def show_nothing(self) -> None:
        """Empty all curves, and shade nothing."""
        self.draw(np.empty(0), np.empty((2, 0)), np.empty(0, dtype=np.bool_))

    def value_of(self, item: pg.GraphicsObject | None, y: float) -> float:
        """Return the voltage of a curve; beside the curves of scaled channels a place stands for none."""
        if (gain := self._gain_of(item)) is not None:
            return float(gain.volts(np.array(y)))
        return y if all(gain.plain for gain in self.gains) else float("nan")

    def data_of(self, item: pg.GraphicsObject) -> tuple[FloatArray, FloatArray]:
        """Return times and voltages of a curve, whatever its gain."""
        (x, y), gain = super().data_of(item), self._gain_of(item)
        return x, y if gain is None else gain.volts(y)

    def _gain_of(self, item: pg.GraphicsObject | None) -> Gain | None:
        return dict(zip(self._curves, self.gains, strict=True)).get(item)

    def words(self, axis: str) -> str:
        """Return the words of an axis; what is read off and copied is always in volts."""
        return self._plain if axis == "left" else super().words(axis)

    def notes(self) -> Sequence[str]:
        """Return what the columns hold."""
        return (f"lowest and highest of each {self._bin} samples",) if self._bin > 1 else ()

    def retheme(self) -> None:
        """Take over the colours of the theme."""
        super().retheme()
        self._lost.setOpts(brush=having(QColor(self.colour("gap")), alpha=150))

    def _shade(self, time_s: FloatArray, lost: BoolArray) -> None:
        begin, end = runs_of(lost).T
        width = time_s[2] - time_s[0] if time_s.size > 2 else 0.0
        first, last = time_s[2 * begin] - 0.5 * width, time_s[2 * end - 1] + 0.5 * width
        if first.size or len(self._lost.opts["x0"]):
            self._lost.setOpts(x0=first, x1=last)


class GainDialog(Dialog):
    """Gain and offset of each channel; what is set is seen at once.

    Parameters
    ----------
    scopes
        Whose channels are drawn.
    """

    def __init__(self, scopes: Sequence[Scope], parent: QWidget | None = None) -> None:
        super().__init__("Gain and offset of the display", (420, 300), parent)
        self._scopes = scopes
        self.fields: list[tuple[QDoubleSpinBox, QDoubleSpinBox]] = []
        grid = QGridLayout()
        for column, words in enumerate(("Channel", "Gain", "Offset [V]")):
            grid.addWidget(QLabel(words), 0, column)
        gains = [gain for scope in scopes for gain in scope.gains]
        for row, gain in enumerate(gains):
            name = f"{'IQ'[row % 2]}{row // 2 + 1}"
            factor = QDoubleSpinBox(minimum=0.1, maximum=10_000.0, decimals=1, value=gain.factor, prefix="× ")
            offset = QDoubleSpinBox(minimum=-100.0, maximum=100.0, decimals=3, singleStep=0.01, value=gain.offset_v)
            tip = "Drawn: gain × (voltage − offset). Only the picture changes, no sample does"
            for column, field, what in ((1, factor, "Gain"), (2, offset, "Offset [V]")):
                having(field, accessibleName=f"{what} of {name}", toolTip=tip).valueChanged.connect(self._apply)
                grid.addWidget(field, row + 1, column)
            grid.addWidget(labelled(name, factor), row + 1, 0)
            self.fields.append((factor, offset))
        says = QLabel("For the eye only: files, results and what is copied stay in volts.")
        reset = button("All as they are", self.reset)
        self.lay_out(says, grid, 1, fill(QHBoxLayout(), reset, 1, button("Close", self.accept, default=True)))

    def reset(self) -> None:
        """Draw the voltages as they are."""
        for factor, offset in self.fields:
            factor.setValue(1.0)
            offset.setValue(0.0)

    def _apply(self) -> None:
        gains = [Gain(factor.value(), offset.value()) for factor, offset in self.fields]
        for scope, i, q in zip(self._scopes, gains[0::2], gains[1::2], strict=True):
            scope.set_gains(i, q)


_HOLD_LOOKS = 5
"""A second: the window shows levels each 0.2 s."""
_BAR_PX = 7
"""Height of the bar beneath its words (chosen by hand)."""


class LevelBar(QWidget):
    """A bar from 0 to full scale; clipping is said by a word and stays readable for a second.

    Drawn by itself: five times a second, and in a tenth of the time that a progress bar with a style takes.

    Attributes
    ----------
    words
        Above the bar, and, where there are two lines, beneath it.
    """

    n_lines = 1

    def __init__(self, theme: Theme, name: str, role: str, full_scale_v: float) -> None:
        super().__init__()
        self._theme, self.name, self._role, self._full_scale_v = theme, name, role, full_scale_v
        self._held = 0
        self.words: tuple[str, ...] = ()
        width = self.fontMetrics().horizontalAdvance("I1 00.00 V") + 8
        self.setFont(scaled_font(self.font(), 0.85))
        having(self, minimumWidth=width, fixedHeight=self.n_lines * self.fontMetrics().height() + _BAR_PX + 3)
        theme.changed.connect(self.update)
        self.show_level(None)

    @property
    def clipping(self) -> bool:
        """Whether the light is on."""
        return self._held > 0

    def show_level(self, level: Level | None) -> None:
        """Show a level; None: nothing is known."""
        clipped = level is not None and level.clipped
        self._held = _HOLD_LOOKS if clipped else max(0, self._held - 1) if level is not None else 0
        self._full_scale_v = (level and level.full_scale_v) or self._full_scale_v
        self._share = (level.peak_v if level else 0.0) / self._full_scale_v
        peak = "–" if level is None else f"{level.peak_v:.2f} V"
        said = "" if level is None else f"{percent(self._share)} of the range"
        tip = f"{self.name}: {said}{', clipping: lower the gain or raise the range' * self.clipping}"
        self.say(tip, f"{self.name} {'CLIP' if self.clipping else peak}")

    def say(self, tip: str, *words: str) -> None:
        """Show words about the level, `n_lines` of them."""
        self.words = words
        having(self, toolTip=tip, accessibleName=", ".join(filter(None, words))).update()

    def paintEvent(self, _event: QPaintEvent) -> None:  # noqa: N802 - Qt's name
        """Draw the words, the bar beneath their first line."""
        colours, room = self._theme.colours, QRectF(self.rect()).adjusted(4.0, 1.0, -4.0, -1.0)
        alarm, line = colours.alarm if self.clipping else "", float(self.fontMetrics().height())
        painter, left = QPainter(self), int(Qt.AlignmentFlag.AlignTop | Qt.AlignmentFlag.AlignLeft)
        places = ((0.0, alarm or colours.text), (line + _BAR_PX, colours.faint))
        for words, (top, colour) in zip(self.words, places, strict=False):
            fitting = self.fontMetrics().elidedText(words, Qt.TextElideMode.ElideRight, int(room.width()))
            write(painter, room.adjusted(0.0, top, 0.0, 0.0), fitting, colour, left)
        bar = QRectF(room.left(), room.top() + line, room.width(), _BAR_PX)
        painter.fillRect(bar, QColor(colours.raised))
        bar.setWidth(min(1.0, self._share) * bar.width())
        painter.fillRect(bar, QColor(alarm or colours.role(self._role)))
