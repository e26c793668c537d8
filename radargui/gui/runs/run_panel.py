"""The panel of one run: figures, the steps of the correction, phase and path lengths."""

from __future__ import annotations

from collections.abc import Iterable

from PySide6.QtWidgets import QLabel, QTabWidget, QVBoxLayout, QWidget

from radargui.files.overview import Overview
from radargui.gui.runs.figures_view import FiguresView
from radargui.gui.runs.phase_view import PhaseView
from radargui.gui.runs.samples_view import SamplesView
from radargui.gui.runs.steps_view import StepsView
from radargui.gui.setup.form import plain_label
from radargui.gui.theme import Theme
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
        for page, words in zip(self._pages, ("Result", "Correction steps", "Phase and path"), strict=True):
            self.tabs.addTab(page, words)
        self.tabs.addTab(self.samples, "Samples")
        self.tabs.currentChanged.connect(self._draw)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(2)
        column.addWidget(self._title)
        column.addWidget(self.notes)
        column.addWidget(self.tabs, 1)

    @property
    def result(self) -> RunResult | None:
        """What is shown."""
        return self._result

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

    def showEvent(self, event: object) -> None:  # noqa: N802 - Qt's name
        """Draw what changed while the panel was hidden."""
        super().showEvent(event)
        self._draw()

    def _draw(self, _index: int = 0) -> None:
        page = self.tabs.currentIndex()
        if self._result is not None and page in self._stale and self.isVisible():
            self._stale.discard(page)
            self._pages[page].show_result(self._result)
