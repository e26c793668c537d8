"""The steps of the correction of one receiver: raw with its extremes, splines and bias, and what came out."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

import numpy as np
from PySide6.QtWidgets import QComboBox, QHBoxLayout, QLabel, QVBoxLayout, QWidget

from radargui.correction.ellipse import Ellipse
from radargui.correction.published import ChannelSteps, PublishedSteps
from radargui.gui.plots.key import Key
from radargui.gui.plots.plot import Plot
from radargui.gui.theme import Theme
from radargui.model.arrays import FloatArray
from radargui.model.result import RunResult

_KEY = (("▬", "i", "I"), ("▬", "q", "Q"))
_PUBLISHED = (
    ("▲", "receivers.2", "peaks"),
    ("▼", "receivers.3", "valleys"),
    ("▬", "fit", "splines"),
    ("╌", "text", "bias"),
    ("+", "faint", "zero crossings"),
)


_NOTHING: FloatArray = np.empty(0)


class StepsView(QWidget):
    """I and Q as recorded above, corrected below; all three share the time axis."""

    def __init__(self, theme: Theme) -> None:
        super().__init__()
        self._result: RunResult | None = None
        self.receiver = QComboBox()
        self.receiver.currentIndexChanged.connect(self._draw)
        self._words = QLabel()
        top = QHBoxLayout()
        top.setContentsMargins(6, 3, 6, 0)
        top.addWidget(QLabel("Receiver"))
        top.addWidget(self.receiver)
        top.addWidget(self._words, 1)

        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(1)
        column.addLayout(top)
        self.raw = tuple(_RawPlot(theme, part) for part in "IQ")
        self.corrected = Plot(theme, "time [s]", "I, Q [amplitudes]")
        self.key = Key(theme)
        column.addWidget(self.key)
        self._curves = tuple(_static(self.corrected, role) for role in ("i", "q"))
        for plot in (*self.raw, self.corrected):
            plot.getPlotItem().getAxis("left").setWidth(52)
            column.addWidget(plot, 1)
        for plot in self.raw:
            plot.setXLink(self.corrected)

    def show_result(self, result: RunResult) -> None:
        """Show a result, the same receiver as before."""
        self._result = result
        chosen = max(0, self.receiver.currentIndex())
        self.receiver.blockSignals(True)
        self.receiver.clear()
        for number in range(result.recording.n_receivers):
            self.receiver.addItem(str(number + 1), number)
        self.receiver.setCurrentIndex(min(chosen, self.receiver.count() - 1))
        self.receiver.blockSignals(False)
        self._draw()

    def clear(self) -> None:
        """Forget the result."""
        self._result = None
        self._words.setText("")
        self.key.show_entries()
        for plot in self.raw:
            plot.show_steps(_NOTHING, _NOTHING, None)
        for curve in self._curves:
            curve.setData(_NOTHING, _NOTHING)

    def _draw(self, _index: int = 0) -> None:
        result, number = self._result, self.receiver.currentData()
        if result is None or number is None:
            return
        recording, corrected = result.recording, result.corrected
        zero_s, zero = result.zero
        self.corrected.relabel(f"time after {zero} [s]")
        time_s = recording.time_s() - zero_s
        channels = slice(2 * number, 2 * number + 2)
        volts = recording.digitisation.volts(recording.raw)[channels]
        found = corrected.steps[number] if corrected and number < len(corrected.steps) else None
        both = (found.i, found.q) if isinstance(found, PublishedSteps) else (None, None)
        self.key.show_entries(*_KEY, *(_PUBLISHED if isinstance(found, PublishedSteps) else ()))
        for plot, values, steps in zip(self.raw, volts, both, strict=True):
            plot.show_steps(time_s, values, steps)
        pairs = (corrected.i[number], corrected.q[number]) if corrected else (np.full_like(time_s, np.nan),) * 2
        for curve, values in zip(self._curves, pairs, strict=True):
            curve.setData(time_s, values)
        self._words.setText(_words(result, found))
        segment = result.segment
        if segment is not None and time_s.size:
            last = min(segment.last, time_s.size) - 1
            self.corrected.setXRange(time_s[segment.first], time_s[last], padding=0.03)
        else:
            self.corrected.enableAutoRange()


class _RawPlot(Plot):
    """A channel as recorded, with what the published procedure found in it."""

    def __init__(self, theme: Theme, part: str) -> None:
        super().__init__(theme, "", f"{part} raw [V]")
        self.getPlotItem().getAxis("bottom").setStyle(showValues=False)
        self._raw = _static(self, part.lower())
        self._upper = _static(self, "fit")
        self._lower = _static(self, "fit")
        self._bias = _static(self, "text", dashed=True)
        self._peaks = self.marker("receivers.2", "t1", 7)
        self._valleys = self.marker("receivers.3", "t", 7)
        self._crossings = self.marker("faint", "+", 6)

    def show_steps(self, time_s: FloatArray, volts: FloatArray, steps: ChannelSteps | None) -> None:
        """Draw a channel; `steps` is None where the correction kept none."""
        self._raw.setData(time_s, volts)
        if steps is None:
            for item in (self._upper, self._lower, self._bias, self._peaks, self._valleys, self._crossings):
                item.setData([], [])
            return
        span = slice(steps.segment.first, steps.segment.last)
        self._upper.setData(time_s[span], steps.upper)
        self._lower.setData(time_s[span], steps.lower)
        self._bias.setData(time_s, steps.bias)
        self._peaks.setData(time_s[steps.peaks], volts[steps.peaks])
        self._valleys.setData(time_s[steps.valleys], volts[steps.valleys])
        self._crossings.setData(time_s[steps.zero_crossings], steps.bias[steps.zero_crossings])


def _static(plot: Plot, role: str, *, dashed: bool = False) -> Any:
    """Return a curve that is drawn fast at any zoom."""
    curve = plot.line(role, dashed=dashed, connect="finite")
    curve.setDownsampling(auto=True, method="peak")
    curve.setClipToView(True)
    return curve


def _words(result: RunResult, found: object) -> str:
    if result.corrected is None:
        return "  nothing was corrected"
    values = asdict(found) if isinstance(found, Ellipse) else {}
    return "   ".join(
        (f"  correction: {result.corrected.method}", *(f"{key} {value:.4g}" for key, value in values.items()))
    )
