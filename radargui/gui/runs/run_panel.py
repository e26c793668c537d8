"""The panel of one run: figures, the steps of the correction, phase and path lengths."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from PySide6.QtGui import QShowEvent
from PySide6.QtWidgets import QLabel, QTabWidget, QVBoxLayout, QWidget

from radargui.files.overview import Overview
from radargui.gui.plots.key import Key
from radargui.gui.plots.plot import Plot
from radargui.gui.runs.figures_view import FiguresView
from radargui.gui.runs.phase_view import PhaseView
from radargui.gui.runs.steps_view import StepsView
from radargui.gui.setup.form import plain_label
from radargui.gui.theme import Theme
from radargui.model.arrays import FloatArray
from radargui.model.result import RunResult

LONG_S = 60.0


class RunPanel(QWidget):
    """Shows a result; each page is drawn when it is looked at."""

    def __init__(self, theme: Theme) -> None:
        super().__init__()
        self._result: RunResult | None = None
        self._stale: set[int] = set()
        self._title = QLabel("No run chosen")
        self._title.setContentsMargins(6, 3, 6, 0)
        self.notes = plain_label()
        self.notes.setContentsMargins(6, 0, 6, 0)
        self.notes.hide()
        self.figures = FiguresView(theme)
        self.steps = StepsView(theme)
        self.phase = PhaseView(theme)
        self.tabs = QTabWidget()
        self.tabs.setDocumentMode(True)
        self.samples = SamplesView(theme)
        self._pages = (self.figures, self.steps, self.phase)
        # the notes take room from the figures, which scroll, not from the plots
        first = QWidget()
        column = QVBoxLayout(first)
        column.setContentsMargins(0, 0, 0, 0)
        column.addWidget(self.notes)
        column.addWidget(self.figures, 1)
        for page, words in ((first, "Result"), (self.steps, "Correction steps"), (self.phase, "Phase and path")):
            self.tabs.addTab(page, words)
        self.tabs.addTab(self.samples, "Samples")
        self.tabs.currentChanged.connect(self._draw)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(2)
        column.addWidget(self._title)
        column.addWidget(self.tabs, 1)

    @property
    def result(self) -> RunResult | None:
        """What is shown."""
        return self._result

    def clear(self) -> None:
        """Forget the run that was shown."""
        self._result = None
        self._stale.clear()
        self._title.setText("No run chosen")
        self.notes.setText("")
        self.notes.hide()
        self.figures.clear()
        self.steps.clear()
        self.phase.clear()
        self.samples.clear()

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
        text = "\n".join(filter(None, notes))
        self.notes.setText(text)
        self.notes.setVisible(bool(text))
        self._result = result
        self._title.setText(f"{name}, preliminary" if result.preliminary else name)
        self._stale = set(range(len(self._pages)))
        self._draw()

    def showEvent(self, event: QShowEvent) -> None:  # noqa: N802 - Qt's name
        """Draw what changed while the panel was hidden."""
        super().showEvent(event)
        self._draw()

    def _draw(self, _index: int = 0) -> None:
        page = self.tabs.currentIndex()
        if self._result is not None and page in self._stale and self.isVisible():
            self._stale.discard(page)
            self._pages[page].show_result(self._result)


class SamplesView(QWidget):
    """All samples at a glance, there before anything is processed: one plot a receiver, time from the first sample."""

    def __init__(self, theme: Theme) -> None:
        super().__init__()
        self._theme = theme
        self.plots: list[Plot] = []
        self._column = QVBoxLayout(self)
        self._column.setContentsMargins(0, 0, 0, 0)
        self._column.setSpacing(1)
        self._column.addWidget(Key(theme, ("▬", "i", "I"), ("▬", "q", "Q")))

    def clear(self) -> None:
        """Forget the samples."""
        for plot in self.plots:
            self._column.removeWidget(plot)
            plot.hide()
            plot.deleteLater()
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
            plot.getPlotItem().getAxis("left").setWidth(58)
            plot.setXLink(self.plots[-1])
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
