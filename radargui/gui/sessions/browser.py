"""The session browser: every session below the data folder, searched, looked at, opened."""

from calendar import monthrange
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from datetime import date
from functools import partial
from operator import attrgetter
from pathlib import Path
from typing import Any

from PySide6.QtCore import Qt, Signal, SignalInstance
from PySide6.QtGui import QKeySequence, QShortcut, QShowEvent
from PySide6.QtWidgets import QGridLayout, QHBoxLayout, QLineEdit, QSplitter, QVBoxLayout, QWidget

from radargui.gui.background import OneAtATime, Task
from radargui.gui.bubble import FaultBubble
from radargui.gui.layout import FRAMED, TIPS, PlainLabel, button, fill, having, labelled, ticking
from radargui.gui.runs.run_model import RunEntry, RunModel
from radargui.gui.runs.thumbnails import ThumbnailView, entry_of
from radargui.gui.services import Services
from radargui.gui.table import RowModel, RowTable
from radargui.model.calibrated_setup import calibration_words
from radargui.model.words import counted, percent, written_time
from radargui.restitution.series import series_of
from radargui.session.catalogue import Catalogue, Query, SessionSummary
from radargui.session.info import read_info
from radargui.session.lock import owner_of
from radargui.session.session import run_paths


def _runs(found: SessionSummary) -> str:
    counts = {"set aside": found.n_rejected, "unfinished": found.n_unfinished, "unreadable": found.n_unreadable}
    more = ", ".join(f"{count} {words}" for words, count in counts.items() if count)
    return f"{found.n_runs} ({more})" if more else str(found.n_runs)


def _restitution(found: SessionSummary) -> str:
    series = series_of(found.drops)
    many = f" (n = {series.e.n})" if series.e.n > 1 else ""
    return ", ".join(filter(None, (f"{series.e.words()}{many}", series.mark)))


COLUMNS: dict[str, Callable[[SessionSummary], str]] = {
    "Date": lambda found: written_time(found.created_at, "%Y-%m-%d %H:%M", found.name),
    "Operator": attrgetter("operator"),
    "Sample": attrgetter("sample"),
    "Target": attrgetter("target"),
    "Runs": _runs,
    "e": _restitution,
    "Setup": attrgetter("setup_name"),
    "Notes": lambda found: found.problem or " ".join(found.notes.split()),
}


def look_at(session: Path) -> tuple[tuple[RunEntry, ...], str, str]:
    """Return the runs of a session, some milliseconds each, its calibration, and who writes to it now; else empty."""
    owner, info = owner_of(session), read_info(session)
    busy = f"{owner} writes to it" if owner is not None and not owner.is_me else ""
    runs = tuple(replace(entry_of(path), rejected=info.rejected.get(path.name)) for path in run_paths(session))
    return runs, calibration_words(info.setup), busy


_WAIT_MS = 250
"""Between two keys of somebody who types: nothing is searched for half a word."""
_FIELDS: tuple[tuple[str, str, str, Callable[[str], Any], int, int], ...] = (
    ("text", "Text", "words in notes, markers, names", str, 0, 0),
    ("operator", "Operator", "any", str, 0, 2),
    ("sample", "Sample or target", "any", str, 0, 4),
    ("since", "From day", "2026-01-31", lambda text: day_of(text), 1, 0),
    ("until", "To day", "2026-12-31", lambda text: day_of(text, last=True), 1, 2),
    ("e_min", "e from", "0", lambda text: float(text.replace(",", ".")), 1, 4),
    ("e_max", "e to", "1", lambda text: float(text.replace(",", ".")), 1, 6),
)
"""Name in the query, words, an example, what the text means, row and column."""


def day_of(text: str, *, last: bool = False) -> date:
    """Return a day, or the first or `last` one of a month or a year: `2025-11`, `2025`.

    Raises
    ------
    ValueError
        It is none of them.
    """
    with suppress(ValueError):
        return date.fromisoformat(text)
    parts = text.split("-")
    first = date.fromisoformat("-".join(parts + ["01", "01"][len(parts) - 1 :]))
    days = monthrange(first.year, first.month)[1]
    return first if not last else first.replace(month=12, day=31) if len(parts) == 1 else first.replace(day=days)


class SearchForm(QWidget):
    """Fields that may be left empty; what cannot be read is marked and left out."""

    changed = Signal()

    def __init__(self) -> None:
        super().__init__()
        self.fields: dict[str, QLineEdit] = {}
        self.faults: dict[str, FaultBubble] = {}
        self._wait = ticking(self, _WAIT_MS, self.changed, once=True)
        grid = QGridLayout(self)
        grid.setContentsMargins(0, 0, 0, 0)
        for name, words, example, _, row, column in _FIELDS:
            line = QLineEdit(placeholderText=example, clearButtonEnabled=True)
            tip = TIPS["fields"].get(words, "")
            self.fields[name] = field = having(line, objectName=f"search.{name}", accessibleName=words, toolTip=tip)
            field.textChanged.connect(self._typed)
            self.faults[name] = FaultBubble()
            grid.addWidget(labelled(words, field), row, column)
            grid.addWidget(field, row, column + 1, 1, 3 if name == "sample" else 1)
        for column, share in ((1, 2), (3, 2), (5, 1), (7, 1)):
            grid.setColumnStretch(column, share)

    @property
    def query(self) -> Query:
        """What is asked for."""
        return Query(**{name: value for name, value in self._values().items() if value is not None})

    def _values(self) -> dict[str, Any]:
        values: dict[str, Any] = {}
        for name, _, _, read, *_ in _FIELDS:
            text = self.fields[name].text().strip()
            if text:
                try:
                    values[name] = read(text)
                except ValueError:
                    values[name] = None
        return values

    def _typed(self) -> None:
        faulty = [name for name, value in self._values().items() if value is None]
        for name, field in self.fields.items():
            field.setStyleSheet(FRAMED if name in faulty else "")
            said = f"Write it as {field.placeholderText()}" if name in faulty else ""
            having(field, accessibleDescription=said)
            self.faults[name].say(said, field)
        self._wait.start()


_SHARE_MS = 200
"""How often the share of a look that is done is written: seldom enough to be read."""


class SessionBrowser(QWidget):
    """Lists what the catalogue finds; looks at the disk only in the background, one look at a time."""

    open_asked = Signal(object)
    setup_asked = Signal(object)
    elsewhere_asked = Signal()
    calibrate_asked = Signal(object)
    series_asked = Signal(object)
    compare_asked = Signal(object)

    def __init__(self, services: Services, data_folder: Callable[[], Path]) -> None:
        super().__init__()
        self._jobs, self._work, self._data_folder = services.jobs, services.work, data_folder
        self.looks = OneAtATime(services.jobs, "the list of sessions", self.refresh)
        self._task, self._folder_words = Task(), ""
        # the first look at a large folder takes its time
        self._timer = ticking(self, _SHARE_MS, self._show_share)
        self.search = SearchForm()
        self.model = RowModel(COLUMNS, lambda one: one.problem or one.notes or str(one.path))
        self.table = RowTable(self.model, "sessions.list", many=True)
        self.words = PlainLabel()
        self.details = PlainLabel()
        self.runs = RunModel()
        self.thumbnails = ThumbnailView(services.theme, self.runs)
        self.review = button("Open for review", lambda: self._ask(self.open_asked))
        self.take_setup = button("Set up as in this session", lambda: self._ask(self.setup_asked))
        self.calibrate = button("What do these drops say about the antennas?", lambda: self._ask(self.calibrate_asked))
        self.series = button("Report as a series…", lambda: self.series_asked.emit(self._paths))
        self.compare = button("Compare", lambda: self.compare_asked.emit(self._paths))
        self.elsewhere = button("Open another folder…", self.elsewhere_asked)
        lower = QWidget()
        fill(QVBoxLayout(lower), self.details, (self.thumbnails, 1))
        parts = having(QSplitter(Qt.Orientation.Vertical), objectName="sessions.parts")
        parts.addWidget(self.table)
        parts.addWidget(lower)
        parts.setSizes([360, 240])
        buttons = fill(QHBoxLayout(), self.review, self.take_setup, self.calibrate, 1, spacing=6)
        above = fill(QHBoxLayout(), (self.words, 1), self.compare, self.series, self.elsewhere, spacing=6)
        fill(QVBoxLayout(self), self.search, above, (parts, 1), buttons, margins=(9, 9, 9, 9), spacing=6)
        self.search.changed.connect(self.refresh)
        self.table.selectionModel().selectionChanged.connect(self._chosen)
        self.table.doubleClicked.connect(self.review.click)
        within, here = Qt.ShortcutContext.WidgetWithChildrenShortcut, Qt.ShortcutContext.WidgetShortcut
        for keys, widget, does, context in (
            ("Down", self.search, self._enter_table, within),
            ("Return", self.table, self.review.click, here),
            ("Shift+Return", self.table, self.compare.click, here),
        ):
            # given as an argument, the context would be dropped: the whole window would have these keys
            QShortcut(QKeySequence(keys), widget, does).setContext(context)
        self._show_buttons()

    def refresh(self) -> None:
        """Look at the folders again, in the background."""
        folder = self._data_folder()
        if not self.looks.busy:
            self._task, self._folder_words = self._work.quiet(), f"Looking at {folder} …"
            self._show_share()
            self._timer.start()
        self.looks.start(partial(_find, folder, self.search.query, self._task), self._show_found, self._failed)

    def _enter_table(self) -> None:
        """Let the keys go on from what is searched to what was found."""
        if self.table.chosen is None:
            self.table.selectRow(0)
        self.table.setFocus(Qt.FocusReason.ShortcutFocusReason)

    def showEvent(self, event: QShowEvent) -> None:  # noqa: N802 - Qt's name
        """Look for what came since it was shown last."""
        super().showEvent(event)
        self.refresh()

    def _show_found(self, found: tuple[SessionSummary, ...]) -> None:
        self._timer.stop()
        before = self.table.chosen
        # where nothing is found the columns keep their places
        (self.table.show_rows if found else self.model.replace_all)(found)
        runs = sum(one.n_runs for one in found)
        where = f"below {self._data_folder()}"
        self.words.setText(f"{counted(len(found), 'session')} with {counted(runs, 'run')} {where}")
        if before is None or not self.table.choose(lambda one: one.path == before.path):
            self._chosen()

    def _show_share(self) -> None:
        share = self._task.share
        self.words.setText(self._folder_words + (f" {percent(share)}" if share else ""))

    def _failed(self, error: BaseException) -> None:
        self._timer.stop()
        self.words.setText(str(error))

    def _chosen(self, *_selections: object) -> None:
        self._show_buttons()
        chosen = self.table.chosen
        self.runs.replace_all(())
        self.details.setText(f"{chosen.name}: reading …" if chosen else "Choose a session to see its runs.")
        if chosen is None:
            return

        def show(look: tuple[tuple[RunEntry, ...], str, str]) -> None:
            runs, calibration, busy = look
            said = (chosen.name, chosen.problem, calibration, busy and f"for looking only: {busy}")
            self.details.setText(" · ".join(filter(None, said)))
            self.runs.replace_all(runs)

        self._jobs.start(
            "looking at a session",
            partial(look_at, chosen.path),
            show,
            lambda error: self.details.setText(str(error)),
            lambda: self.table.chosen is chosen,
        )

    def _ask(self, signal: SignalInstance) -> None:
        chosen = self.table.chosen
        if chosen is not None and not chosen.problem:
            signal.emit(chosen.path)

    @property
    def _paths(self) -> tuple[Path, ...]:
        return tuple(one.path for one in self.table.all_chosen)

    def _show_buttons(self) -> None:
        several = self.table.all_chosen
        sound = bool(several) and not any(one.problem for one in several)
        self.series.setEnabled(len(several) > 1 and sound)
        self.compare.setEnabled(sound)
        for one in (self.review, self.take_setup, self.calibrate):
            one.setEnabled(len(several) == 1 and not several[0].problem)


def _find(folder: Path, query: Query, task: Task) -> tuple[SessionSummary, ...]:
    with Catalogue(folder) as catalogue:
        catalogue.refresh(task.report)
        return catalogue.find(query)
