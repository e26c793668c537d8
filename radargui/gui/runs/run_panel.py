"""The panel of one run: figures, the correction at work, phase and path lengths, methods, all samples at a glance."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial

import numpy as np
from PySide6.QtCore import Signal
from PySide6.QtGui import QShowEvent
from PySide6.QtWidgets import QLabel, QVBoxLayout, QWidget

from radargui.files.overview import Overview
from radargui.gui.background import StartWork
from radargui.gui.layout import Pages, fill, take_out
from radargui.gui.plots.key import IQ_KEY, Key
from radargui.gui.plots.plot import Plot
from radargui.gui.runs.correction_view import CorrectionView, MethodsView
from radargui.gui.runs.figures_view import FiguresView
from radargui.gui.theme import Theme
from radargui.model.arrays import FloatArray
from radargui.model.result import RunResult
from radargui.report.curves import RunCurves, take_curves

_LEFT = 58
"""Pixels of all vertical axes beneath one another, so that one instant stands above the other."""
SCREEN_COLUMNS = 20_000
"""Of curves, each with its lowest and highest sample: what is left when a motion is magnified ten times."""
LONG_S = 60.0
"""From here on processing takes minutes: who chose such a run sees its samples at once instead of an empty page."""
_TURN = 2.0 * np.pi  # radians
_PAGES = {"figures": "Result", "steps": "Correction", "phase": "Phase and path", "methods": "Methods"}
"""Of a result; that of the samples comes after them."""


class RunPanel(QWidget):
    """Shows a result; each page is drawn when it is looked at, what it draws is made in the background.

    Parameters
    ----------
    theme
        Look.
    start
        Runs work away from the thread that draws, see `Jobs.start`.
    """

    methods_asked = Signal(object)
    """Names of the corrections that shall be laid over the one that is shown."""

    def __init__(self, theme: Theme, start: StartWork) -> None:
        super().__init__()
        self.result: RunResult | None = None
        self._curves: RunCurves | None = None
        self._curves_of: RunResult | None = None
        self._stale: set[str] = set()
        self._why = ""
        self._title = QLabel("No run chosen")
        self._title.setContentsMargins(6, 3, 6, 0)
        self._start = start
        self.figures, self.samples = FiguresView(theme), SamplesView(theme)
        later: dict[str, Callable[[], QWidget]] = {"steps": partial(CorrectionView, theme)}
        later |= {"phase": partial(PhaseView, theme), "methods": partial(MethodsView, theme, self.methods_asked.emit)}
        self.tabs = Pages({**_PAGES, "samples": "Samples"}, later, figures=self.figures, samples=self.samples)
        self.tabs.currentChanged.connect(self._draw)
        fill(QVBoxLayout(self), self._title, (self.tabs, 1))

    def clear(self) -> None:
        """Forget the run that was shown."""
        self.forget()
        self.samples.clear()
        self._title.setText("No run chosen")

    def forget(self, why: str = "") -> None:
        """Forget what the run that was shown gave: another one was chosen, whose samples may be there already.

        Parameters
        ----------
        why
            What stands in the empty plots; empty: what to do.
        """
        self.result = self._curves = self._curves_of = None
        self._stale.clear()
        for page in self.tabs.made.values():
            if page is not self.samples:
                page.clear()
        self._why = why
        self._say_why()

    def _say_why(self) -> None:
        for plot in self.findChildren(Plot):
            plot.when_empty = self._why

    def say(self, name: str, words: str = "reading and processing …") -> None:
        """Say what becomes of a run that is not shown yet."""
        self._title.setText(f"{name}: {words}")

    def show_overview(self, overview: Overview, *, in_front: bool) -> None:
        """Show all samples at a glance; of a long run, whose processing takes its time, `in_front`."""
        self.samples.show_overview(overview)
        if in_front and overview.n_samples > LONG_S * overview.sample_rate_hz:
            self.tabs.setCurrentWidget(self.samples)

    def show_result(self, result: RunResult, name: str, notes: Iterable[str] = ()) -> None:
        """Show what a run gave; `notes`: how it was recorded, one line each."""
        self.figures.notes = tuple(filter(None, notes))
        self.result, self._curves = result, None
        self._title.setText(f"{name}, preliminary" if result.preliminary else name)
        self._stale = {*_PAGES}
        self._why = ""
        self._say_why()
        self._draw()

    def showEvent(self, event: QShowEvent) -> None:  # noqa: N802 - Qt's name
        """Draw what changed while the panel was hidden."""
        super().showEvent(event)
        self._draw()

    def _draw(self, _index: int = 0) -> None:
        page, result = self.tabs.shown, self.result
        if result is None:
            # a page is made when it is first looked at
            self._say_why()
        if result is None or page not in self._stale or not self.isVisible():
            return
        view = self.tabs.page(page)
        if isinstance(view, CorrectionView | PhaseView):
            if self._curves is None:
                self._make_curves(result)
                return
            view.show_curves(result, self._curves)
        else:
            view.show_result(result)
        self._stale.discard(page)

    def _make_curves(self, result: RunResult) -> None:
        if self._curves_of is result:
            return
        self._curves_of = result

        def take(curves: RunCurves | None) -> None:
            self._curves, self._curves_of = curves, None
            # without samples there is nothing to draw
            self._stale -= set() if curves else {"steps", "phase"}
            self._draw()

        def failed(error: BaseException) -> None:
            self._curves_of = None
            self._title.setText(f"{self._title.text()}: {error}")

        work = partial(take_curves, result, SCREEN_COLUMNS)
        self._start("the curves of the run", work, take, failed, lambda: self.result is result)


class SamplesView(QWidget):
    """All samples at a glance, there before anything is processed: one plot a receiver, time from the first sample."""

    def __init__(self, theme: Theme) -> None:
        super().__init__()
        self._theme = theme
        self.plots: list[Plot] = []
        self._overview: Overview | None = None
        self._column = fill(QVBoxLayout(self), Key(theme, *IQ_KEY), spacing=1)

    def clear(self) -> None:
        """Forget the samples."""
        take_out(self._column, *self.plots)
        self.plots, self._overview = [], None

    def show_overview(self, overview: Overview) -> None:
        """Draw an overview, as soon as it is looked at: a run that was just recorded comes while the next one is."""
        self._overview = overview
        if self.isVisible():
            self._draw(overview)

    def showEvent(self, event: QShowEvent) -> None:  # noqa: N802 - Qt's name
        """Draw what came while the page was hidden."""
        super().showEvent(event)
        if self._overview is not None:
            self._draw(self._overview)

    def _draw(self, overview: Overview) -> None:
        self._overview = None
        count = len(overview.channel_names) // 2
        if len(self.plots) != count:
            self.clear()
            bottom = [""] * (count - 1) + ["time after the first sample [s]"]
            self.plots = [
                Plot(self._theme, words, f"Rx {number} [V]", left_px=_LEFT) for number, words in enumerate(bottom, 1)
            ]
            for plot in self.plots:
                self._column.addWidget(plot, 1)
        for number, plot in enumerate(self.plots):
            plot.take_all_out()
            # a plot whose axis is linked does not look for its range itself
            plot.setXLink(self.plots[-1] if plot is not self.plots[-1] else None)
            plot.setXRange(0.0, overview.n_samples / overview.sample_rate_hz, padding=0.02)
            for row, part in ((2 * number, "I"), (2 * number + 1, "Q")):
                plot.still_line(part.lower(), part).setData(*boxes(overview, row))


def boxes(overview: Overview, row: int) -> tuple[FloatArray, FloatArray]:
    """Return time [s] and value of a line around each bin of a channel, shape (4 * n_bins,) each.

    A box says where the samples of a bin are and no more; a line from bin to bin would look like a signal.
    """
    low, high = overview.lowest[row], overview.highest[row]
    bin_s = overview.bin_samples / overview.sample_rate_hz
    time_s = bin_s * np.add.outer(np.arange(low.size), (0, 0, 1, 1)).ravel()
    return time_s, np.stack([low, high, high, low], axis=1).ravel()


class PhaseView(QWidget):
    """Above the phase, corrected and as recorded; below L."""

    def __init__(self, theme: Theme) -> None:
        super().__init__()
        self.phase = Plot(theme, "", "phase [turns]", left_px=_LEFT, figures_below=False)
        self.path = Plot(theme, "time [s]", "change of L [mm]", left_px=_LEFT)
        self.phase.setXLink(self.path)
        self._key = Key(theme)
        fill(QVBoxLayout(self), self._key, (self.phase, 1), (self.path, 1), spacing=1)

    def clear(self) -> None:
        """Forget the result."""
        self.phase.take_all_out()
        self.path.take_all_out()

    def show_curves(self, _result: RunResult, curves: RunCurves) -> None:
        """Draw a result."""
        self.clear()
        if not any(one.change.x.size for one in curves.receivers):
            return
        self.path.relabel(f"time after the {curves.since} [s]")
        lost = [("│", "gap", "path lost, L has another zero from here on")] if curves.restarts_s else []
        for plot in (self.phase, self.path):
            for restart in curves.restarts_s:
                plot.rule("gap", restart, dashed=False)
        for number, one in enumerate(curves.receivers):
            role, name = f"receivers.{number}", f"Rx {one.name}"
            for curve, recorded in ((one.phase_raw, True), (one.phase, False)):
                line = self.phase.still_line(role, f"{name} as recorded" if recorded else name, dashed=recorded)
                line.setData(curve.x, curve.y / _TURN)
            self.path.still_line(role, name).setData(one.change.x, 1000.0 * one.change.y)
        receivers = (("▬", f"receivers.{number}", f"Rx {one.name}") for number, one in enumerate(curves.receivers))
        self._key.show_entries(*receivers, ("╌", "text", "phase as recorded"), *lost)
        self.path.enableAutoRange()
        self.phase.enableAutoRange(axis="y")
