"""The panel of one run: figures, the steps of the correction, phase and path lengths, all samples at a glance."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict
from functools import cached_property
from typing import TypeVar

import numpy as np
from PySide6.QtCore import QSignalBlocker
from PySide6.QtGui import QShowEvent
from PySide6.QtWidgets import QComboBox, QHBoxLayout, QLabel, QSizePolicy, QTabWidget, QVBoxLayout, QWidget

from radargui.correction.ellipse import Ellipse
from radargui.correction.published import ChannelSteps, PublishedSteps
from radargui.files.overview import Overview
from radargui.gui.layout import fill, take_out
from radargui.gui.plots.plot import IQ_KEY, Key, Plot
from radargui.gui.runs.figures_view import FiguresView
from radargui.gui.theme import Theme
from radargui.model.arrays import FloatArray
from radargui.model.result import RunResult

_PUBLISHED = (
    ("▲", "receivers.2", "peaks"),
    ("▼", "receivers.3", "valleys"),
    ("▬", "fit", "splines"),
    ("╌", "text", "bias"),
    ("+", "faint", "zero crossings"),
)
_STEPS_LEFT, _LEFT = 52, 58
"""Pixels of all vertical axes beneath one another, so that one instant stands above the other."""
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
        self.corrected = Plot(theme, "time [s]", "I, Q / A", left_px=_STEPS_LEFT)
        self.key = Key(theme)
        self._curves = tuple(self.corrected.still_line(role) for role in ("i", "q"))
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
        for plot in (*self.raw, self.corrected):
            plot.show_nothing()

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
        self.key.show_entries(*IQ_KEY, *(_PUBLISHED if isinstance(found, PublishedSteps) else ()))
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
        super().__init__(theme, "", f"{part} raw [V]", left_px=_STEPS_LEFT)
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


LONG_S = 60.0
"""From here on processing takes minutes: who chose such a run sees its samples at once instead of an empty page."""
_TURN = 2.0 * np.pi
_PAGES = ("figures", "steps", "phase")
"""Of a result, in the order of their tabs; that of the samples comes after them."""
_View = TypeVar("_View", bound=QWidget)


class RunPanel(QWidget):
    """Shows a result; each page is drawn when it is looked at."""

    def __init__(self, theme: Theme) -> None:
        super().__init__()
        self.result: RunResult | None = None
        self._stale: set[int] = set()
        self._title = QLabel("No run chosen")
        self._title.setContentsMargins(6, 3, 6, 0)
        self._theme = theme
        self.figures = FiguresView(theme)
        self.tabs = QTabWidget()
        self.tabs.setDocumentMode(True)
        self.samples = SamplesView(theme)
        pages = {
            "Result": self.figures,
            "Correction steps": QWidget(),
            "Phase and path": QWidget(),
            "Samples": self.samples,
        }
        for words, page in pages.items():
            self.tabs.addTab(page, words)
        self.tabs.currentChanged.connect(self._draw)
        fill(QVBoxLayout(self), self._title, (self.tabs, 1))

    @cached_property
    def steps(self) -> StepsView:
        """The page of the correction; made when it is first looked at, for the window starts sooner without it."""
        return self._put(StepsView(self._theme), _PAGES.index("steps"))

    @cached_property
    def phase(self) -> PhaseView:
        """The page of phase and path; the same holds."""
        return self._put(PhaseView(self._theme), _PAGES.index("phase"))

    def _put(self, view: _View, place: int) -> _View:
        shown, words = self.tabs.currentIndex(), self.tabs.tabText(place)
        with QSignalBlocker(self.tabs):
            self.tabs.removeTab(place)
            self.tabs.insertTab(place, view, words)
            self.tabs.setCurrentIndex(shown)
        return view

    def clear(self) -> None:
        """Forget the run that was shown."""
        self.result = None
        self._stale.clear()
        self._title.setText("No run chosen")
        for name in (*_PAGES, "samples"):
            if name in vars(self):
                vars(self)[name].clear()

    def loading(self, name: str) -> None:
        """Say that a run is being read and processed."""
        self._title.setText(f"{name}: reading and processing …")

    def show_overview(self, overview: Overview, *, in_front: bool) -> None:
        """Show all samples at a glance; of a long run, whose processing takes its time, `in_front`."""
        self.samples.show_overview(overview)
        if in_front and overview.n_samples > LONG_S * overview.sample_rate_hz:
            self.tabs.setCurrentWidget(self.samples)

    def failed(self, name: str, why: str) -> None:
        """Say why a run cannot be shown."""
        self._title.setText(f"{name}: {why}")

    def show_result(self, result: RunResult, name: str, notes: Iterable[str] = ()) -> None:
        """Show what a run gave; `notes`: how it was recorded, one line each."""
        self.figures.notes = tuple(filter(None, notes))
        self.result = result
        self._title.setText(f"{name}, preliminary" if result.preliminary else name)
        self._stale = set(range(len(_PAGES)))
        self._draw()

    def showEvent(self, event: QShowEvent) -> None:  # noqa: N802 - Qt's name
        """Draw what changed while the panel was hidden."""
        super().showEvent(event)
        self._draw()

    def _draw(self, _index: int = 0) -> None:
        page = self.tabs.currentIndex()
        if self.result is not None and page in self._stale and self.isVisible():
            self._stale.discard(page)
            getattr(self, _PAGES[page]).show_result(self.result)


class SamplesView(QWidget):
    """All samples at a glance, there before anything is processed: one plot a receiver, time from the first sample."""

    def __init__(self, theme: Theme) -> None:
        super().__init__()
        self._theme = theme
        self.plots: list[Plot] = []
        self._column = fill(QVBoxLayout(self), Key(theme, *IQ_KEY), spacing=1)

    def clear(self) -> None:
        """Forget the samples."""
        take_out(self._column, *self.plots)
        self.plots = []

    def show_overview(self, overview: Overview) -> None:
        """Draw an overview."""
        count = len(overview.channel_names) // 2
        self.clear()
        self.plots = [
            Plot(self._theme, "time [s]" if number == count - 1 else "", f"Rx {number + 1} [V]", left_px=_LEFT)
            for number in range(count)
        ]
        for number, plot in enumerate(self.plots):
            # a plot whose axis is linked does not look for its range itself
            plot.setXLink(self.plots[-1] if plot is not self.plots[-1] else None)
            plot.setXRange(0.0, overview.n_samples / overview.sample_rate_hz, padding=0.02)
            for row, role in ((2 * number, "i"), (2 * number + 1, "q")):
                plot.still_line(role).setData(*boxes(overview, row))
            self._column.addWidget(plot, 1)


def boxes(overview: Overview, row: int) -> tuple[FloatArray, FloatArray]:
    """Return time [s] and value of a line around each bin of a channel, shape (4 * n_bins,) each.

    A box says where the samples of a bin are and no more; a line from bin to bin would look like a signal.
    """
    low, high = overview.lowest[row], overview.highest[row]
    bin_s = overview.bin_samples / overview.sample_rate_hz
    starts = np.arange(low.size) * bin_s
    time_s = np.stack([starts, starts, starts + bin_s, starts + bin_s], axis=1).ravel()
    return time_s, np.stack([low, high, high, low], axis=1).ravel()


class PhaseView(QWidget):
    """Above the phase, corrected and as recorded; below L."""

    def __init__(self, theme: Theme) -> None:
        super().__init__()
        self.phase = Plot(theme, "", "phase [turns]", left_px=_LEFT)
        self.path = Plot(theme, "time [s]", "change of L [mm]", left_px=_LEFT)
        self.phase.setXLink(self.path)
        self.phase.getPlotItem().getAxis("bottom").setStyle(showValues=False)
        self._key = Key(theme)
        fill(QVBoxLayout(self), self._key, (self.phase, 1), (self.path, 1), spacing=1)

    def clear(self) -> None:
        """Forget the result."""
        self.phase.take_all_out()
        self.path.take_all_out()

    def show_result(self, result: RunResult) -> None:
        """Draw a result."""
        self.clear()
        paths = result.paths
        if paths is None:
            return
        zero_s, zero = result.zero
        self.path.relabel(f"time after {zero} [s]")
        time_s = paths.time_s - zero_s
        volts = result.recording.volts()
        restarts = paths.restarts()
        pieces_s = np.insert(time_s, restarts, time_s[restarts])
        lost = [("│", "gap", "path lost, L has another zero from here on")] if restarts.size else []
        for plot in (self.phase, self.path):
            for restart in restarts:
                plot.rule("gap", float(time_s[restart]), dashed=False)
        for number in range(paths.phase_rad.shape[0]):
            role = f"receivers.{number}"
            corrected = paths.phase_rad[number] / _TURN
            raw = _raw_turns(volts[2 * number], volts[2 * number + 1], corrected, result.setup.radar.phase_sign)
            change_mm = 1000.0 * paths.change_m[number]
            self.phase.still_line(role, dashed=True).setData(time_s, raw)
            self.phase.still_line(role).setData(pieces_s, np.insert(corrected, restarts, np.nan))
            self.path.still_line(role).setData(pieces_s, np.insert(change_mm, restarts, np.nan))
        receivers = (("▬", f"receivers.{number}", f"Rx {number + 1}") for number in range(paths.phase_rad.shape[0]))
        self._key.show_entries(*receivers, ("╌", "text", "phase as recorded"), *lost)
        self.path.enableAutoRange()
        self.phase.enableAutoRange(axis="y")


def _raw_turns(i: FloatArray, q: FloatArray, corrected: FloatArray, sign: int) -> FloatArray:
    """Return the phase of the uncorrected signal, in turns, zero where the corrected one begins."""
    turns = sign * np.unwrap(np.arctan2(q, i)) / _TURN
    known = np.flatnonzero(np.isfinite(corrected))
    return np.asarray(turns - (turns[known[0]] - corrected[known[0]] if known.size else 0.0))
