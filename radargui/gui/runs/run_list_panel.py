"""The panel of the runs: pictures or table, report and export; and the last drops as dots with their mean."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QMargins, QSignalBlocker, QUrl, Signal
from PySide6.QtGui import QDesktopServices, QResizeEvent
from PySide6.QtWidgets import QCheckBox, QHBoxLayout, QMenu, QVBoxLayout, QWidget

from radargui.gui.layout import (
    TIPS,
    OneLine,
    Pages,
    PlainLabel,
    Turning,
    boxed,
    button,
    fill,
    having,
    menu_button,
    ticking,
)
from radargui.gui.mnemonics import letter_menu
from radargui.gui.panels import Actions
from radargui.gui.plots.plot import Plot
from radargui.gui.runs.run_model import COLUMNS, RunEntry, RunModel
from radargui.gui.runs.thumbnails import ThumbnailView
from radargui.gui.table import RowTable
from radargui.gui.theme import Theme, scaled_px
from radargui.model.drop import figure_in
from radargui.model.rounding import COVERAGE, UNKNOWN, to_digits_of_u
from radargui.restitution.series import Series

N_SHOWN = 10
"""A hand's breadth tells so many apart, and whether they drift (the operators asked for ten)."""
_LEFT = 72
"""Width of the left axis in pixels: e with four digits beside its name."""
_ALONE = 1e-3
"""Half of the axis at the least: what is less than a thousandth of e is not read off a plot so low (by hand)."""


class DropsPanel(QWidget):
    """Follows the list of runs; a dot that is clicked asks for its run, *Change* for the fields of the session.

    Attributes
    ----------
    words, session
        n, mean and s of all drops that count; operator, sample, target and session on one line.
    """

    run_asked = Signal(object)
    change_asked = Signal()

    def __init__(self, theme: Theme, model: RunModel) -> None:
        super().__init__()
        self._model, self._shown = model, list[RunEntry]()
        self.plot = Plot(theme, "", "e", left_px=_LEFT, density=0.6)
        self.plot.setToolTip(TIPS["plots"]["Last drops"])
        self._spread, self._mean = self.plot.band("fit"), self.plot.rule("fit", 0.0, angle=0)
        self._bars = self.plot.bars("text", f"± {COVERAGE:g} u")
        self._counts = self.plot.marker("track", size=8, name="counts")
        self._others = self.plot.marker("mark", symbol="d", size=9, name="preliminary, or left out")
        for dots in (self._counts, self._others):
            dots.sigPointsClicked.connect(self._clicked)
        self.words, self.session = OneLine(), OneLine()
        change = button("Change", self.change_asked, TIPS["buttons"]["Change the session"])
        foot = fill(QHBoxLayout(), (self.session, 1), change, margins=(6, 0, 2, 0), spacing=6)
        fill(QVBoxLayout(self), having(self.words, contentsMargins=foot.contentsMargins()), (self.plot, 1), foot)
        model.altered.connect(self.refresh)
        self._draw()

    def show_session(self, *parts: str) -> None:
        """Say operator, sample, target and session, as far as they are known."""
        self.session.setText(" · ".join(filter(None, parts)) or "nothing typed yet")

    def refresh(self) -> None:
        """Draw the last drops, and say what all that count give."""
        shown = [one for one in self._model.entries if one.has_e and not one.rejected][-N_SHOWN:]
        if shown != self._shown:
            self._shown = shown
            self._draw()

    def _draw(self) -> None:
        shown, series = self._shown, self._model.series
        self.words.setText(words_of(series))
        x = np.arange(len(shown), dtype=float)
        e = np.array([figure_in(one.summary, "e") or np.nan for one in shown])
        u = np.array([_u(one) for one in shown])
        counts = np.array([not one.left_out for one in shown], dtype=bool)
        self._counts.setData(x[counts], e[counts])
        self._others.setData(x[~counts], e[~counts])
        low, high = e - COVERAGE * u, e + COVERAGE * u
        self._bars.show_bars(x, e, COVERAGE * u)
        mean, s = series.e.mean, series.e.standard_deviation or 0.0
        self._mean.setVisible(mean is not None)
        ends = np.array([-0.6, max(x.size, 2) - 0.4])
        around = np.empty(0) if mean is None else np.full(2, mean)
        self._spread.show_band(ends[: around.size], around - s, around + s)
        self._mean.setValue(mean or 0.0)
        self.plot.getPlotItem().getAxis("bottom").setTicks([[(at, one.label) for at, one in enumerate(shown)]])
        self.plot.setXRange(*ends, padding=0)
        if shown:
            seen = np.concatenate([e, low[np.isfinite(low)], high[np.isfinite(high)], around - s, around + s])
            middle, half = 0.5 * (seen.min() + seen.max()), max(_ALONE, 0.55 * np.ptp(seen))
            self.plot.setYRange(middle - half, middle + half, padding=0)
        else:
            self.plot.setYRange(0.0, 1.0, padding=0)

    def _clicked(self, _item: object, points: Sequence[pg.SpotItem]) -> None:
        self.run_asked.emit(self._shown[round(points[0].pos().x())].path)


def words_of(series: Series) -> str:
    """Return n, mean and standard deviation of e in words; empty without any."""
    of = series.e
    spread = "" if of.standard_deviation is None else to_digits_of_u(of.standard_deviation, of.u)
    s = f"s {'' if spread.startswith('<') else '= '}{spread}" if spread else ""
    return "   ".join(filter(None, (f"n = {of.n}", f"mean {of.words()}", s))) if of.n else ""


def _u(one: RunEntry) -> float:
    """Return the combined standard uncertainty of e, else the statistical one; NaN where none is known."""
    found = (figure_in(one.summary, key) for key in ("u_e_combined", "u_e"))
    return next((u for u in found if u is not None), np.nan)


_MAX_FITTED = 50
"""Runs that columns and lines are fitted to when a session is opened; all of ten thousand would take a second."""

_WIDEST_NOTE = 150
"""Pixels of the column (chosen by hand): a wider one takes from the verdict, a narrower one makes lines high."""


_MAX_LINES = 3
"""Of a verdict (chosen by hand): a long reason would push the other runs out of the list; its tip has all of it."""


_PICTURES = 290
"""Pixels of width below which runs are pictures with their e: a table would show two of its columns."""


class RunListPanel(QWidget):
    """Lists runs, as a table or as pictures; choosing one asks for its result to be shown."""

    run_chosen = Signal(object)
    not_opened = Signal(str)
    """A folder that no program of this computer shows."""
    run_wanted = Signal()
    """The operator has chosen a run, and wants to look at it."""

    def __init__(self, theme: Theme, does: Actions) -> None:
        super().__init__()
        self.model = RunModel()
        # a verdict takes further lines on a narrow screen
        self.table = having(RowTable(self.model, "runs", many=True), minimumHeight=50, wordWrap=True)
        lines = self.table.verticalHeader()
        lines.setMaximumSectionSize(lines.defaultSectionSize() + (_MAX_LINES - 1) * self.fontMetrics().lineSpacing())
        # once the widths have settled: lines change them where a scroll bar comes or goes. One line a turn of the event
        # loop: a line takes milliseconds, and what is drawn live has to be drawn in between
        self._unfit: list[int] = []
        self._settle = ticking(self, 0, self._fit_next_row, once=True)
        self.table.horizontalHeader().sectionResized.connect(lambda *_sizes: self._fit_rows())
        self.table.verticalScrollBar().valueChanged.connect(lambda _value: self._fit_rows())
        self.table.selectionModel().selectionChanged.connect(self._chosen)
        # a sorted table keeps what is hidden by its place
        self.table.model().layoutChanged.connect(self._hide_rows)
        for action in (does.reject, does.exclude, does.note_run):
            self.table.addAction(action)
        self.pictures = ThumbnailView(theme, self.table)
        self._looks = Pages(("table", "pictures"), {}, table=self.table, pictures=self.pictures)

        menu = having(QMenu(self), toolTipsVisible=True)
        menu.addAction("Preview…", does.preview.trigger).setToolTip(does.preview.toolTip())
        # where no program opens it, its first page is shown here
        opens = partial(self._open, lambda: self._report_file, self._preview_instead)
        shows = partial(self._open, lambda: self.folder, self._say_not_opened)
        does_of = {"Make report": does.report.trigger, "Open report": opens, "Open folder": shows}
        does_of["Export tables…"] = does.export.trigger
        made = [having(menu.addAction(words, one), toolTip=TIPS["buttons"][words]) for words, one in does_of.items()]
        self.report, self.open_report, self.open_folder, self.export = made
        menu.aboutToShow.connect(lambda: letter_menu(menu))
        self._preview = does.preview
        tip = "Runs that do not count: no fall, or rejected (Del); Del takes the chosen one back"
        self.rejected = having(QCheckBox("Show rejected"), toolTip=tip)
        self.rejected.toggled.connect(does.show_rejected.setChecked)
        self.rejected.toggled.connect(self._hide_rows)
        does.show_rejected.toggled.connect(self.rejected.setChecked)
        turn = button("Table", does.turn_runs.trigger, does.turn_runs.toolTip())
        buttons = boxed(QHBoxLayout(), turn, menu_button("Report", menu), 1, margins=(6, 0, 6, 2), spacing=4)
        row = Turning(scaled_px(_PICTURES), (self.rejected, 0, 0), (buttons, 0, 1))
        # one line, whatever it says: two would push the buttons out of a low panel
        self.series = having(PlainLabel(), contentsMargins=QMargins(6, 0, 6, 0))
        fill(QVBoxLayout(self), (self._looks, 1), self.series, row)

        self._report_busy = self._by_program = False
        self.show_series("")
        self.show_session(None, [])

    def resizeEvent(self, event: QResizeEvent) -> None:  # noqa: N802 - Qt's name
        """Show pictures where there is no room for a table."""
        super().resizeEvent(event)
        self._looks.turn_to("pictures" if self.width() < scaled_px(_PICTURES) else "table")

    @property
    def counting(self) -> tuple[Path, ...]:
        """The runs that were not set aside, as they stand in the list: nobody waits for a disk."""
        return tuple(one.path for one in self.model.entries if not one.rejected)

    def show_session(self, folder: Path | None, entries: list[RunEntry]) -> None:
        """Show the runs of a session; its report, where it has one, is told by `show_report`."""
        self.folder = folder
        self._report_file: Path | None = None
        self.model.replace_all(entries)
        self._hide_rows()
        self._fit_columns(self.model.entries[-_MAX_FITTED:])
        self._fit_rows()
        self._refresh_buttons()

    def choose_again(self, path: Path | None) -> None:
        """Choose the run that was chosen before it was read anew: what is looked at meanwhile stays in front."""
        self._by_program = True
        self.table.choose(lambda one: one.path == path)
        self._by_program = False

    def put(self, entry: RunEntry, *, select: bool = False) -> None:
        """Add or update a run."""
        row = self.model.put(entry)
        self._hide_rows()
        self._fit_columns(self.model.entries[row : row + 1])
        shown, is_last = self.table.shown_row(row), row == len(self.model.entries) - 1
        self.table.resizeRowToContents(shown)
        if is_last:
            self.table.scrollTo(self.table.model().index(shown, 0))
        if select:
            # the result of a run that was just recorded is there already: nobody needs to be asked for it
            with QSignalBlocker(self.table.selectionModel()):
                self.table.selectRow(shown)
            self.table.viewport().update()
        self._refresh_buttons()

    def change(self, path: Path, **facts: Any) -> None:
        """Show that something else is known of a run."""
        entry = self.model.entry_of(path)
        if entry is not None:
            self.put(replace(entry, **facts))

    def show_report(self, file: Path | None = None, *, busy: bool = False) -> None:
        """Show that a report is being made, is there, or failed."""
        self._report_busy, self._report_file = busy, file or self._report_file
        self._refresh_buttons()

    def show_series(self, said: str) -> None:
        """Show what the drops that count gave together; empty: there are none."""
        self.series.setText(said)
        self.series.setVisible(bool(said))
        self.series.setToolTip(f"Mean and standard error of e over the drops that count, each once. {said}")

    def _chosen(self) -> None:
        self._refresh_buttons()
        # who selects many wants to look at none
        if len(chosen := self.table.all_chosen) == 1:
            self.run_chosen.emit(chosen[0])
            if not self._by_program:
                self.run_wanted.emit()

    def _hide_rows(self) -> None:
        for row, entry in enumerate(self.model.entries):
            hidden = bool(entry.rejected) and not self.rejected.isChecked()
            shown = self.table.shown_row(row)
            self.table.setRowHidden(shown, hidden)
            self.pictures.setRowHidden(shown, hidden)
        for title in ("Note", "e of times"):
            column = list(COLUMNS).index(title)
            self.table.setColumnHidden(column, all(one.cells[column] in ("", UNKNOWN) for one in self.model.entries))
        count = sum(bool(entry.rejected) for entry in self.model.entries)
        self.rejected.setText(f"Show rejected ({count})" if count else "Show rejected")

    def _fit_columns(self, entries: list[RunEntry]) -> None:
        """Make columns wide enough for entries, and never narrower than they were."""
        metrics, texts = self.table.fontMetrics(), [entry.cells for entry in entries]
        for column, title in enumerate(tuple(COLUMNS)[:-1]):
            words = (*title.split(), *(cells[column] for cells in texts))
            wanted = max(metrics.horizontalAdvance(text) for text in words) + 10
            # a long note takes several lines
            wanted = min(wanted, _WIDEST_NOTE) if title == "Note" else wanted
            if self.table.columnWidth(column) < wanted or not self.model.entries:
                self.table.fit(column, wanted)
                # the last column gives what the others take
                self.table.fit(len(COLUMNS) - 1, 60)

    def _fit_rows(self) -> None:
        """Let the lines that are seen become as high as their verdicts."""
        first, last = self.table.rowAt(0), self.table.rowAt(self.table.viewport().height() - 1)
        if first >= 0:
            self._unfit = list(range(first, (last if last >= 0 else self.table.model().rowCount() - 1) + 1))
            self._settle.start()

    def _fit_next_row(self) -> None:
        self.table.resizeRowToContents(self._unfit.pop(0))
        if self._unfit:
            self._settle.start()

    def _refresh_buttons(self) -> None:
        self.report.setText("Making report …" if self._report_busy else "Make report")
        self.report.setEnabled(bool(self.model.entries) and not self._report_busy)
        self.open_report.setEnabled(self._report_file is not None)
        self.open_folder.setEnabled(self.folder is not None)
        self.export.setEnabled(self.table.chosen is not None)

    @staticmethod
    def _open(which: Callable[[], Path | None], otherwise: Callable[[], None]) -> None:
        """Let a program of this computer open a file or folder; where none does, do something else."""
        path = which()
        if path is not None and not QDesktopServices.openUrl(QUrl.fromLocalFile(str(path))):
            otherwise()

    def _preview_instead(self) -> None:
        self.not_opened.emit(f"reports, its first page is shown instead: {self._report_file}")
        self._preview.trigger()

    def _say_not_opened(self) -> None:
        self.not_opened.emit(f"folders: {self.folder}")
