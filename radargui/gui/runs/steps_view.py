"""The steps of the correction of one receiver: raw with its extremes, splines and bias, and what came out."""

from dataclasses import asdict

import numpy as np
from PySide6.QtCore import QSignalBlocker
from PySide6.QtWidgets import QComboBox, QHBoxLayout, QLabel, QSizePolicy, QVBoxLayout, QWidget

from radargui.correction.ellipse import Ellipse
from radargui.correction.published import ChannelSteps, PublishedSteps
from radargui.gui.layout import fill
from radargui.gui.plots.plot import Key, Plot
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
        # never makes the panel wider than its dock
        self._words.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Preferred)
        top = fill(QHBoxLayout(), QLabel("Receiver"), self.receiver, (self._words, 1), margins=(6, 3, 6, 0), spacing=6)
        self.raw = tuple(_RawPlot(theme, part) for part in "IQ")
        self.corrected = Plot(theme, "time [s]", "I, Q / A")
        self.key = Key(theme)
        self._curves = tuple(self.corrected.still_line(role) for role in ("i", "q"))
        for plot in (*self.raw, self.corrected):
            plot.getPlotItem().getAxis("left").setWidth(52)
        fill(QVBoxLayout(self), top, self.key, *((plot, 1) for plot in (*self.raw, self.corrected)), spacing=1)
        for plot in self.raw:
            plot.setXLink(self.corrected)

    def show_result(self, result: RunResult) -> None:
        """Show a result, the same receiver as before."""
        self._result = result
        chosen = max(0, self.receiver.currentIndex())
        with QSignalBlocker(self.receiver):
            self.receiver.clear()
            for number in range(result.recording.n_receivers):
                self.receiver.addItem(str(number + 1), number)
            self.receiver.setCurrentIndex(min(chosen, self.receiver.count() - 1))
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
        self._words.setToolTip(self._words.text().strip())
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
        self._raw = self.still_line(part.lower())
        self.found = {
            "upper": self.still_line("fit"),
            "lower": self.still_line("fit"),
            "bias": self.still_line("text", dashed=True),
            "peaks": self.marker("receivers.2", "t1", 7),
            "valleys": self.marker("receivers.3", "t", 7),
            "crossings": self.marker("faint", "+", 6),
        }

    def show_steps(self, time_s: FloatArray, volts: FloatArray, steps: ChannelSteps | None) -> None:
        """Draw a channel; `steps` is None where the correction kept none."""
        self._raw.setData(time_s, volts)
        pairs = [(_NOTHING, _NOTHING)] * len(self.found)
        if steps is not None:
            span = slice(steps.segment.first, steps.segment.last)
            at_extremes = [(time_s[places], volts[places]) for places in (steps.peaks, steps.valleys)]
            crossings = (time_s[steps.zero_crossings], steps.bias[steps.zero_crossings])
            envelopes = [(time_s[span], steps.upper), (time_s[span], steps.lower)]
            pairs = [*envelopes, (time_s, steps.bias), *at_extremes, crossings]
        for item, (x, y) in zip(self.found.values(), pairs, strict=True):
            item.setData(x, y)


def _words(result: RunResult, found: object) -> str:
    if result.corrected is None:
        return "  nothing was corrected"
    values = asdict(found) if isinstance(found, Ellipse) else {}
    return "   ".join(
        (f"  correction: {result.corrected.method}", *(f"{key} {value:.4g}" for key, value in values.items()))
    )
