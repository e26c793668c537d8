"""The panel of one run and of its series: one view at a time, chosen by name, above all of the run to scrub in."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from functools import partial
from typing import Any

import numpy as np
from PySide6.QtCore import Signal
from PySide6.QtGui import QActionGroup, QShowEvent
from PySide6.QtWidgets import QHBoxLayout, QLabel, QMenu, QVBoxLayout, QWidget

from radargui.acquisition.ring import Ring
from radargui.files.overview import Overview
from radargui.gui.background import StartWork
from radargui.gui.control.state import Feed
from radargui.gui.layout import Choice, OneLine, Pages, fill, having, labelled, take_out, ticking
from radargui.gui.plots.key import IQ_KEY, Key
from radargui.gui.plots.plot import Plot
from radargui.gui.runs.correction_view import CorrectionView, MethodsView
from radargui.gui.runs.figures_view import BudgetView, FiguresView
from radargui.gui.runs.instant import Instant, RunOverview, ScrubPlot, whole_of
from radargui.gui.scopes.iq_plane_panel import IQPlanePanel
from radargui.gui.scopes.shown import Shown
from radargui.gui.scopes.spectrum_view import BANDS_HZ, SpectrumView, WaterfallView
from radargui.gui.theme import Theme
from radargui.model.arrays import FloatArray
from radargui.model.recording import Block
from radargui.model.result import RunResult
from radargui.report.curves import RunCurves, every, take_curves

_MAX_S = 8.0
"""Of a motion, its beginning: the first bounces of a drop; the spectra of more would take their time."""
_FRAME_MS = 20
_POINTS = 3000
"""Samples in a plane: more look the same."""


def motion_of(result: RunResult) -> Shown | None:
    """Return the samples of the motion as the scopes show samples; None without any."""
    recording, segment = result.recording, result.segment
    if recording.n_samples < 2:
        return None
    rate_hz = recording.digitisation.sample_rate_hz
    first, last = (segment.first, segment.last) if segment is not None else (0, recording.n_samples)
    last = min(last, first + round(_MAX_S * rate_hz))
    volts = recording.digitisation.volts(recording.raw[:, first:last])
    ring = Ring(len(volts), last - first, np.float64)
    ring.append(Block(volts, 0))
    feed = Feed(ring, recording.digitisation, None, result.setup)
    zero = round((result.zero[0] - float(recording.time_s()[first])) * rate_hz)
    return Shown(feed, last - first, zero, (last - first) / rate_hz, live=False)


class SignalView(QWidget):
    """Shows the motion in a live view, which takes it in piece by piece."""

    def __init__(self, view: SpectrumView | WaterfallView) -> None:
        super().__init__()
        self.view, self._left = view, 0
        self._shown: Shown | None = None
        self._next = ticking(self, _FRAME_MS, self._draw)
        fill(QVBoxLayout(self), (view, 1))

    def clear(self) -> None:
        """Forget the run."""
        self._shown = None
        self._next.stop()
        self.view.show_nothing()

    def show_curves(self, result: RunResult, shown: Shown) -> None:
        """Show a motion, the whole of the band that it fills."""
        self.clear()
        self._shown = shown
        if isinstance(self.view, WaterfallView):
            self.view.set_receivers(shown.feed.n_receivers)
            self.view.plots[-1].relabel(f"time after {result.zero[1]} [s]")
        # a sphere of 10 m/s gives less than this everywhere
        nyquist_hz = 0.5 * shown.feed.rate_hz
        self.view.half_band_hz = max(band for band in BANDS_HZ[:3] if band <= nyquist_hz or band == BANDS_HZ[0])
        # as often as the past takes, and until the view draws it
        self._left = 16 + math.ceil(4.0 * shown.window_s)
        self._next.start()

    def _draw(self) -> None:
        self._left -= 1
        if self._shown is None or self._left < 0:
            self._next.stop()
        elif self.isVisible():
            self.view.draw(self._shown)


class PlanesView(IQPlanePanel):
    """Q against I of the motion, as recorded above and corrected below."""

    def show_curves(self, _result: RunResult, curves: RunCurves) -> None:
        """Draw a result."""
        self.set_receivers(len(curves.receivers))
        for number, one in enumerate(curves.receivers):
            for planes, pair in ((self.raw, one.raw), (self.corrected, one.corrected)):
                kept = every(pair.plane.x.size, _POINTS)
                planes[number].draw(pair.plane.x[kept], pair.plane.y[kept])


_LEFT = 58
"""Pixels of all vertical axes beneath one another, so that one instant stands above the other."""
SCREEN_COLUMNS = 20_000
"""Of curves, each with its lowest and highest sample: what is left when a motion is magnified ten times."""
LONG_S = 60.0
"""From here on processing takes minutes: who chose such a run sees its samples at once instead of an empty page."""
_TURN = 2.0 * np.pi  # radians
VIEWS: dict[str, tuple[str, str]] = {
    "height": ("Height z(t)", "track"),
    "space": ("Track in 3D", "track"),
    "speed": ("Speed", "track"),
    "acceleration": ("Acceleration", "track"),
    "speed over z": ("Speed over height", "track"),
    "residual": ("Residual of the fall", "track"),
    "x": ("x(t)", "track"),
    "y": ("y(t)", "track"),
    "samples": ("I and Q, all samples", "samples"),
    "planes": ("IQ planes", "planes"),
    "steps": ("Correction at work", "steps"),
    "phase": ("Phase and path", "phase"),
    "spectrum": ("Spectrum", "spectrum"),
    "waterfall": ("Waterfall", "waterfall"),
    "methods": ("Corrections side by side", "methods"),
    "budget": ("Uncertainty budget", "budget"),
    "speeds": ("Series: e against impact speed", "series"),
    "spread": ("Series: distribution of e", "series"),
    "falls": ("Series: falls over one parabola", "series"),
    "table": ("Series: statistics", "series"),
    "words": ("Series: in words", "series"),
}
"""What can be chosen: its words, and the page that shows it; a page of several is told which."""
_MADE_BY: dict[str, Callable[[RunResult], Any]] = {
    **dict.fromkeys(("steps", "phase", "planes"), partial(take_curves, columns=SCREEN_COLUMNS)),
    **dict.fromkeys(("spectrum", "waterfall"), motion_of),
}
"""What a page draws, made of a result in the background; the others take the result itself."""
_NOT_OF_RESULT = ("samples", "series")
_OF_RESULT = {page for _, page in VIEWS.values()} - set(_NOT_OF_RESULT)
_OVERVIEW = 8
"""Share of the height that belongs to the whole of the run, in percent."""


class RunPanel(QWidget):
    """Shows a result; each page is drawn when it is looked at, what it draws is made in the background.

    Parameters
    ----------
    theme
        Look.
    start
        Runs work away from the thread that draws, see `Jobs.start`.
    series, make_track
        Pages that are made elsewhere: of the series, and of the track once it is looked at.

    Attributes
    ----------
    figures
        The result in words; stands in a panel of its own.
    """

    methods_asked = Signal(object)
    """Names of the corrections that shall be laid over the one that is shown."""
    view_asked = Signal(str)
    """A view that was chosen in the menu."""

    def __init__(self, theme: Theme, start: StartWork, series: QWidget, make_track: Callable[[], QWidget]) -> None:
        super().__init__()
        self.result: RunResult | None = None
        self._made: dict[Callable[[RunResult], Any], Any] = {}
        self._making: set[Callable[[RunResult], Any]] = set()
        self._stale: set[str] = set()
        self._why = ""
        self._title, self._there = (
            OneLine("No run chosen"),
            having(QLabel(), toolTip="At the line: click, or scrub below"),
        )
        self._start = start
        self.figures, self.samples = FiguresView(theme), SamplesView(theme)
        later: dict[str, Callable[[], QWidget]] = {
            "track": make_track,
            "planes": partial(PlanesView, theme),
            "steps": partial(CorrectionView, theme),
            "phase": partial(PhaseView, theme),
            "spectrum": lambda: SignalView(SpectrumView(theme)),
            "waterfall": lambda: SignalView(WaterfallView(theme)),
            "methods": partial(MethodsView, theme, self.methods_asked.emit),
            "budget": partial(BudgetView, theme),
        }
        pages = dict.fromkeys(page for _, page in VIEWS.values())
        self.tabs = Pages(pages, later, samples=self.samples, series=series)
        self.instant = Instant(theme)
        self.overview = ScrubPlot(theme, self.instant)
        self.view = having(Choice((name, words) for name, (words, _) in VIEWS.items()), accessibleName="View")
        having(self.view, maxVisibleItems=len(VIEWS), toolTip="What is shown of the run, or of its series")
        self.view.currentIndexChanged.connect(self._turn)
        self.tabs.currentChanged.connect(self._draw)
        self.instant.moved.connect(self._say_where)
        above = (labelled("View", self.view), self.view, (self._title, 1), self._there)
        top = fill(QHBoxLayout(), *above, margins=(6, 3, 6, 0), spacing=6)
        fill(QVBoxLayout(self), top, (self.tabs, 100 - _OVERVIEW), (self.overview, _OVERVIEW))

    @property
    def chosen(self) -> str:
        """Name of the view that is shown."""
        return str(self.view.currentData())

    def choose(self, name: str) -> None:
        """Show another view, see `VIEWS`."""
        self.view.setCurrentIndex(self.view.findData(name))

    def fill(self, menu: QMenu) -> None:
        """Add a menu of the views to another one."""
        inner, group = menu.addMenu("View of the run"), QActionGroup(menu)
        for name, (words, _) in VIEWS.items():
            action = inner.addAction(words, partial(self.view_asked.emit, name))
            group.addAction(having(action, checkable=True))
        inner.aboutToShow.connect(lambda: group.actions()[self.view.currentIndex()].setChecked(True))

    def _turn(self) -> None:
        """Show the page of the view that was chosen."""
        page = VIEWS[self.chosen][1]
        shown = self.tabs.page(page)
        if (show_part := getattr(shown, "show_part", None)) is not None:
            show_part(self.chosen)
        for one in (self.overview, self._there):
            one.setVisible(page != "series")
        self.tabs.turn_to(page)
        self._draw()

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
        self.result = None
        self._made, self._making = {}, set()
        self._stale.clear()
        for name, page in self.tabs.made.items():
            if name not in _NOT_OF_RESULT:
                page.clear()
        self.figures.clear()
        self._show_whole(None)
        self._why = why
        self._say_why()

    def _say_why(self) -> None:
        for name, page in self.tabs.made.items():
            for plot in page.findChildren(Plot) if name != "series" else ():
                plot.when_empty = self._why

    def say(self, name: str, words: str = "reading and processing …") -> None:
        """Say what becomes of a run that is not shown yet."""
        self._title.setText(f"{name}: {words}")

    def show_overview(self, overview: Overview, *, in_front: bool) -> None:
        """Show all samples at a glance; of a long run, whose processing takes its time, `in_front`."""
        self.samples.show_overview(overview)
        if in_front and overview.n_samples > LONG_S * overview.sample_rate_hz:
            self.choose("samples")

    def show_result(self, result: RunResult, name: str, notes: Iterable[str] = ()) -> None:
        """Show what a run gave; `notes`: how it was recorded, one line each."""
        self.figures.notes = tuple(filter(None, notes))
        self.result, self._made, self._making = result, {}, set()
        self._title.setText(f"{name}, preliminary" if result.preliminary else name)
        self._stale = {*_OF_RESULT, "overview"}
        self._why = ""
        self._say_why()
        self.figures.show_result(result)
        self._draw()

    def showEvent(self, event: QShowEvent) -> None:  # noqa: N802 - Qt's name
        """Draw what changed while the panel was hidden."""
        super().showEvent(event)
        self._turn()

    def _draw(self, _index: int = 0) -> None:
        page, result = self.tabs.shown, self.result
        if result is None:
            # a page is made when it is first looked at
            self._say_why()
        if result is None or not self.isVisible():
            return
        if "overview" in self._stale and (whole := self._of(whole_of, result, "overview")) is not None:
            self._show_whole(whole)
        if page in self._stale:
            view, make = self.tabs.page(page), _MADE_BY.get(page)
            if make is None:
                view.show_result(result)
            elif (made := self._of(make, result, page)) is not None:
                view.show_curves(result, made)
            else:
                return
            self._stale.discard(page)
        if page != "series":
            self.instant.follow(self.tabs.page(page).findChildren(Plot), result.zero[0])

    def _of(self, make: Callable[[RunResult], Any], result: RunResult, page: str) -> Any:
        """Return what is made of the result, None where it is made now: the page is drawn once it is there."""
        if make not in self._made and make not in self._making:
            self._making.add(make)

            def take(made: Any) -> None:
                self._made[make] = made
                # without samples there is nothing to draw
                self._stale -= {page} if made is None else set()
                self._draw()

            def failed(error: BaseException) -> None:
                self._title.setText(f"{self._title.text()}: {error}")

            self._start("the curves of the run", partial(make, result), take, failed, lambda: self.result is result)
        return self._made.get(make)

    def _show_whole(self, whole: RunOverview | None) -> None:
        self._stale.discard("overview")
        self.overview.show_whole(whole)
        self._say_where()

    def _say_where(self) -> None:
        """Say where the sphere is at the instant, here and in space."""
        place_mm = self.overview.place_mm
        self._there.setText(self.overview.said)
        if place_mm is not None and "track" in self.tabs.made:
            self.tabs.made["track"].show_sphere(place_mm)


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
                Plot(self._theme, words, f"Rx {number} [V]", left_px=_LEFT, figures_below=bool(words))
                for number, words in enumerate(bottom, 1)
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
