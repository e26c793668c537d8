"""The panel of one run: figures, the steps of the correction, phase and path lengths."""

from collections.abc import Iterable

import numpy as np
from PySide6.QtGui import QShowEvent
from PySide6.QtWidgets import QLabel, QTabWidget, QVBoxLayout, QWidget

from radargui.files.overview import Overview
from radargui.gui.layout import fill, take_out
from radargui.gui.plots.plot import Key, Plot
from radargui.gui.runs.figures_view import FiguresView
from radargui.gui.runs.steps_view import StepsView
from radargui.gui.theme import Theme
from radargui.model.arrays import FloatArray
from radargui.model.result import RunResult

LONG_S = 60.0
"""From here on processing takes minutes: who chose such a run sees its samples at once instead of an empty page."""
_LEFT = 58
"""Pixels of all vertical axes beneath one another, so that one instant stands above the other."""
_TURN = 2.0 * np.pi


class RunPanel(QWidget):
    """Shows a result; each page is drawn when it is looked at."""

    def __init__(self, theme: Theme) -> None:
        super().__init__()
        self.result: RunResult | None = None
        self._stale: set[int] = set()
        self._title = QLabel("No run chosen")
        self._title.setContentsMargins(6, 3, 6, 0)
        self.figures = FiguresView(theme)
        self.steps = StepsView(theme)
        self.phase = PhaseView(theme)
        self.tabs = QTabWidget()
        self.tabs.setDocumentMode(True)
        self.samples = SamplesView(theme)
        self._pages = (self.figures, self.steps, self.phase)
        names = ("Result", "Correction steps", "Phase and path", "Samples")
        for page, words in zip((*self._pages, self.samples), names, strict=True):
            self.tabs.addTab(page, words)
        self.tabs.currentChanged.connect(self._draw)
        fill(QVBoxLayout(self), self._title, (self.tabs, 1))

    def clear(self) -> None:
        """Forget the run that was shown."""
        self.result = None
        self._stale.clear()
        self._title.setText("No run chosen")
        for page in (*self._pages, self.samples):
            page.clear()

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
        self._stale = set(range(len(self._pages)))
        self._draw()

    def showEvent(self, event: QShowEvent) -> None:  # noqa: N802 - Qt's name
        """Draw what changed while the panel was hidden."""
        super().showEvent(event)
        self._draw()

    def _draw(self, _index: int = 0) -> None:
        page = self.tabs.currentIndex()
        if self.result is not None and page in self._stale and self.isVisible():
            self._stale.discard(page)
            self._pages[page].show_result(self.result)


class SamplesView(QWidget):
    """All samples at a glance, there before anything is processed: one plot a receiver, time from the first sample."""

    def __init__(self, theme: Theme) -> None:
        super().__init__()
        self._theme = theme
        self.plots: list[Plot] = []
        self._column = fill(QVBoxLayout(self), Key(theme, ("▬", "i", "I"), ("▬", "q", "Q")), spacing=1)

    def clear(self) -> None:
        """Forget the samples."""
        take_out(self._column, *self.plots)
        self.plots = []

    def show_overview(self, overview: Overview) -> None:
        """Draw an overview."""
        count = len(overview.channel_names) // 2
        self.clear()
        self.plots = [
            Plot(self._theme, "time [s]" if number == count - 1 else "", f"Rx {number + 1} [V]")
            for number in range(count)
        ]
        for number, plot in enumerate(self.plots):
            plot.getPlotItem().getAxis("left").setWidth(_LEFT)
            # a plot whose axis is linked does not look for its range itself
            plot.setXLink(self.plots[-1] if plot is not self.plots[-1] else None)
            plot.setXRange(0.0, overview.n_samples / overview.sample_rate_hz, padding=0.02)
            for row, role in ((2 * number, "i"), (2 * number + 1, "q")):
                curve = plot.line(role, connect="finite")
                curve.setClipToView(True)
                curve.setData(*boxes(overview, row))
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
        self.phase = Plot(theme, "", "phase [turns]")
        self.path = Plot(theme, "time [s]", "change of L [mm]")
        self.phase.setXLink(self.path)
        self.phase.getPlotItem().getAxis("bottom").setStyle(showValues=False)
        self._key = Key(theme)
        self._drawn: list[tuple[Plot, object]] = []
        fill(QVBoxLayout(self), self._key, (self.phase, 1), (self.path, 1), spacing=1)
        for plot in (self.phase, self.path):
            plot.getPlotItem().getAxis("left").setWidth(_LEFT)

    def clear(self) -> None:
        """Forget the result."""
        for plot, curve in self._drawn:
            plot.drop(curve)
        self._drawn = []

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
                self._drawn.append((plot, plot.rule("gap", float(time_s[restart]), dashed=False)))
        for number in range(paths.phase_rad.shape[0]):
            role = f"receivers.{number}"
            corrected = paths.phase_rad[number] / _TURN
            raw = _raw_turns(volts[2 * number], volts[2 * number + 1], corrected, result.setup.radar.phase_sign)
            self._add(self.phase, role, time_s, raw, dashed=True)
            self._add(self.phase, role, pieces_s, np.insert(corrected, restarts, np.nan))
            self._add(self.path, role, pieces_s, np.insert(1000.0 * paths.change_m[number], restarts, np.nan))
        receivers = (("▬", f"receivers.{number}", f"Rx {number + 1}") for number in range(paths.phase_rad.shape[0]))
        self._key.show_entries(*receivers, ("╌", "text", "phase as recorded"), *lost)
        self.path.enableAutoRange()
        self.phase.enableAutoRange(axis="y")

    def _add(self, plot: Plot, role: str, x: FloatArray, y: FloatArray, *, dashed: bool = False) -> None:
        curve = plot.still_line(role, dashed=dashed)
        curve.setData(x, y)
        self._drawn.append((plot, curve))


def _raw_turns(i: FloatArray, q: FloatArray, corrected: FloatArray, sign: int) -> FloatArray:
    """Return the phase of the uncorrected signal, in turns, zero where the corrected one begins."""
    turns = sign * np.unwrap(np.arctan2(q, i)) / _TURN
    known = np.flatnonzero(np.isfinite(corrected))
    return np.asarray(turns - (turns[known[0]] - corrected[known[0]] if known.size else 0.0))
