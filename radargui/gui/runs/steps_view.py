"""The steps of the correction of one receiver: raw with its extremes, splines and bias, and what came out."""

from __future__ import annotations

from typing import Any

import numpy as np
from PySide6.QtWidgets import QComboBox, QHBoxLayout, QLabel, QVBoxLayout, QWidget

from radargui.gui.plots.key import Key
from radargui.gui.plots.plot import Plot
from radargui.gui.theme import Theme
from radargui.gui.track.shown_track import start_time_s
from radargui.model.result import RunResult

_TIME = "time after the trigger [s]"


_KEY = (
    ("▬", "i", "I"),
    ("▬", "q", "Q"),
    ("▲", "receivers.2", "peaks"),
    ("▼", "receivers.3", "valleys"),
    ("▬", "fit", "splines"),
    ("╌", "text", "bias"),
    ("+", "faint", "zero crossings"),
)


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
        self.corrected = Plot(theme, _TIME, "I, Q [amplitudes]")
        column.addWidget(Key(theme, *_KEY))
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

    def _draw(self, _index: int = 0) -> None:
        result, number = self._result, self.receiver.currentData()
        if result is None or number is None:
            return
        recording, corrected = result.recording, result.corrected
        time_s = recording.time_s() - start_time_s(result)
        channels = slice(2 * number, 2 * number + 2)
        volts = recording.digitisation.volts(recording.raw)[channels]
        found: Any = corrected.steps[number] if corrected and number < len(corrected.steps) else None
        for part, plot, values in zip("iq", self.raw, volts, strict=True):
            plot.show_steps(time_s, values, getattr(found, part, None))
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

    def show_steps(self, time_s: Any, volts: Any, steps: Any) -> None:
        """Draw a channel; `steps` is None where the correction kept none."""
        self._raw.setData(time_s, volts)
        if not hasattr(steps, "peaks"):
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


def _words(result: RunResult, found: Any) -> str:
    if result.corrected is None:
        return "  nothing was corrected"
    method = result.corrected.method
    return (
        f"  correction: {method}"
        if found is None or hasattr(found, "i")
        else f"  correction: {method}   {_short(found)}"
    )


def _short(found: Any) -> str:
    names = getattr(type(found), "__dataclass_fields__", {})
    values = ((name, getattr(found, name)) for name in names)
    return "   ".join(f"{name} {value:.4g}" for name, value in values if isinstance(value, float))
