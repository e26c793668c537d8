"""Import, export and processing again: dialogs, the work behind them, what is said; what is dropped on the window."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from PySide6.QtCore import QEvent, QObject, Signal, SignalInstance
from PySide6.QtGui import QDropEvent
from PySide6.QtWidgets import QCheckBox, QDialog, QMenu

from radargui.experiment.compare import RunComparison, compare_with
from radargui.experiment.importing import Imported, ImportOrder, import_recordings
from radargui.files.access import Outcome, each_run, make_folder
from radargui.files.formats import EXPORT_FORMATS
from radargui.gui.background import WorkStrip
from radargui.gui.dialog import Dialog
from radargui.gui.layout import TIPS, Choice, Group, PathField, PlainLabel, button, having, side_by_side
from radargui.gui.mnemonics import without
from radargui.gui.runs.run_model import RunEntry
from radargui.gui.services import Services
from radargui.gui.sessions.import_dialog import ImportDialog
from radargui.gui.sessions.session_controller import SessionController
from radargui.gui.setup_words import called, words_of
from radargui.gui.table import WordTable
from radargui.model.errors import FileError
from radargui.model.rounding import alone, quantity
from radargui.model.setup import Setup
from radargui.model.words import counted
from radargui.session.info import FILE_NAME
from radargui.session.transfer import FOLDER, ExportPlan, plan_export

HEADS = ("Run", "Quantity", "Stored", "New", "New − stored")
_SHOWN = {
    "e": ("e", 1.0),
    "drop_height_m": ("Fall [mm]", 1000.0),
    "impact_speed_m_s": ("Impact [m/s]", 1.0),
    "g_m_s2": ("g [m/s²]", 1.0),
}
"""Words and scale of each figure."""


class ReprocessDialog(Dialog):
    """The samples are never touched; stored results stay until the new ones are kept.

    Parameters
    ----------
    runs, chosen
        Those of the session, and the one that is chosen in the list.
    setup, setup_words
        The operator's own, and what it is called: while a session is reviewed the window shows that one's.
    read_only
        Whether the session takes no results.
    with_setup
        Whether the setup in the window is what shall be compared at first, else that of the recording.
    """

    kept = Signal(object)

    def __init__(
        self,
        services: Services,
        runs: tuple[Path, ...],
        chosen: RunEntry | None,
        setup: Setup,
        *,
        read_only: bool,
        with_setup: bool = False,
        setup_words: str = "Setup in the window",
    ) -> None:
        super().__init__("Process again and compare", (760, 620), services.parent, "compare", services.settings)
        self._read_only = read_only
        self._other: tuple[Setup | None, dict[str, str]] = (None, {})
        self._good: tuple[Path, ...] = ()
        one = [((chosen.path,), f"The chosen run, {chosen.title}")] if chosen is not None else []
        self.what = Choice((*one, (runs, f"All {len(runs)} runs of the session")))
        self.setup = Choice(((None, "As recorded"), (setup, setup_words)))
        if with_setup:
            self.setup.setCurrentIndex(1)
        self.correction, self.geometry_choice = (
            Choice(((None, "As in the setup"), *words_of(f"processing.{name}").choices.items()))
            for name in ("correction", "geometry")
        )
        for choice in (self.what, self.setup, self.correction, self.geometry_choice):
            choice.currentIndexChanged.connect(self._forget)
        self.choices = Group("With", ("Runs", self.what), ("Antennas and processing", self.setup))
        self.choices.put(("IQ correction", self.correction), ("Geometry", self.geometry_choice))
        self.compare = button("Process and compare", self._compare, default=True)
        self.work = WorkStrip(services.jobs)
        self.settings, self.words = PlainLabel(), PlainLabel()
        self.table = WordTable(HEADS, "comparison")
        self.keep = button("Keep the new results", self._keep)
        self.discard = button("Discard", self.reject)
        ends = side_by_side(self.keep, self.discard)
        self.lay_out(self.choices, self.compare, self.work, self.settings, (self.table, 1), self.words, ends)
        self._show_buttons()

    def done(self, result: int) -> None:
        """Cancel what is under way, and close."""
        self.work.cancel()
        super().done(result)

    def _compare(self) -> None:
        self._forget()
        changes = {"correction": self.correction.currentData(), "geometry": self.geometry_choice.currentData()}
        wanted = {f"processing.{name}": value for name, value in changes.items() if value}
        self._other = self.setup.currentData(), wanted
        runs = tuple(map(Path, self.what.currentData()))
        self._work("processing again", runs, self._show_outcomes, "nothing was changed", keep=False)

    def _keep(self) -> None:
        left = "runs that were done keep their new results"
        self._work("keeping the new results", self._good, self._kept, left, keep=True)

    def _work(self, what: str, runs: tuple[Path, ...], then: Callable[[Any], None], left: str, *, keep: bool) -> None:
        setup, wanted = self._other
        compared = partial(compare_with, setup=setup, changes=wanted, keep=keep)
        self.work.start(
            what,
            lambda task: tuple(each_run(runs, compared, task.report)),
            then,
            lambda error: self._ended(str(error)),
            lambda: self._ended(f"Cancelled; {left}."),
        )
        self._show_buttons()

    def _show_outcomes(self, outcomes: tuple[Outcome[RunComparison], ...]) -> None:
        self.table.show_rows(line for outcome in outcomes for line in lines_of(outcome))
        compared = [one.value for one in outcomes if one.value is not None]
        self._good = tuple(one.run for one in compared)
        self.settings.setText(settings_words(compared[0]) if compared else "")
        self._ended("Nothing is changed yet." if compared else "")

    def _kept(self, outcomes: tuple[Outcome[RunComparison], ...]) -> None:
        failed = [one for one in outcomes if one.error is not None]
        self._good = ()
        self._ended("\n".join(str(one.error) for one in failed) or "The new results are kept with the runs.")
        self.kept.emit(tuple(one.run for one in outcomes if one.error is None))

    def _ended(self, words: str) -> None:
        self.words.setText(words)
        self._show_buttons()

    def _forget(self) -> None:
        self._good = ()
        self.settings.setText("")
        self.table.rows.replace_all(())
        self._ended("")

    def _show_buttons(self) -> None:
        busy = self.work.busy
        self.compare.setEnabled(not busy)
        self.choices.setEnabled(not busy)
        self.keep.setEnabled(bool(self._good) and not busy and not self._read_only)
        # kept already, or nothing computed yet: there is nothing to be discarded
        words = "Discard" if self._good or busy else "Close"
        if without(self.discard.text()) != words:
            having(self.discard, text=words, toolTip=TIPS["buttons"][words])
        if self._read_only:
            self.keep.setToolTip("The session is opened for looking only.")


def lines_of(outcome: Outcome[RunComparison]) -> Iterator[tuple[str, str, str, str, str]]:
    """Yield the lines of a run."""
    name, comparison = outcome.run.stem, outcome.value
    if comparison is None:
        yield name, "failed", "", "", str(outcome.error)
        return
    before, after = (RunEntry(outcome.run, summary=one.summary) for one in (comparison.before, comparison.after))
    yield name, "Verdict", before.verdict, after.verdict, ""
    for one in comparison.figures:
        words, scale = _SHOWN[one.name]
        sides = ((one.before, one.u_before), (one.after, one.u_after))
        before_words, after_words = (quantity(value, u, scale=scale) for value, u in sides)
        difference = alone(one.difference, one.u_difference, scale, signed=True)
        yield "", words, before_words, after_words, difference


def settings_words(comparison: RunComparison) -> str:
    """Return what was set differently, a line each."""
    lines = []
    for one in comparison.settings:
        before, after = map(words_of(one.key).with_unit, (one.before, one.after))
        lines.append(f"{called(one.key)}: {before} → {after}")
    return "\n".join(lines) or "The settings are the same as those of the stored results."


class ExportDialog(Dialog):
    """Asks what to export; `ordered` brings the plan, once the folder is one that takes it."""

    ordered = Signal(object)

    def __init__(self, services: Services, session: Path, run: RunEntry | None) -> None:
        super().__init__("Export samples", (520, 200), services.parent, "export", services.settings)
        self._jobs = services.jobs
        one = [(run.path, f"The chosen run, {run.title}")] if run is not None else []
        self.what = Choice((*one, (session, f"All runs of the session {session.name}")))
        self.kind = Choice((one.name, f"{one.title} ({', '.join(one.suffixes)})") for one in EXPORT_FORMATS.values())
        self.folder = PathField("Export to", session / FOLDER)
        self.replace = QCheckBox("Replace files that are there")
        self.go = button("Export", self._order, default=True)
        group = Group("", ("What", self.what), ("Format", self.kind), ("Folder", self.folder), self.replace)
        self.lay_out(group, side_by_side(self.go, button("Cancel", self.reject)))
        self.folder.line.textChanged.connect(lambda text: self.go.setEnabled(bool(text.strip())))
        for changed in (self.replace.toggled, self.kind.activated, self.what.activated):
            changed.connect(lambda _value: self.folder.refuse(""))

    def _order(self) -> None:
        folder = self.folder.path
        if folder is None:
            return
        what, kind, force = self.what.currentData(), EXPORT_FORMATS[self.kind.currentData()], self.replace.isChecked()
        self.go.setEnabled(False)

        def work() -> ExportPlan:
            plan = plan_export(Path(what), kind, folder, force=force)
            make_folder(folder)
            return plan

        self._jobs.start("looking at the folder", work, self._accept, self._refuse)

    def _accept(self, plan: ExportPlan) -> None:
        if self.isVisible():
            self.ordered.emit(plan)
            self.accept()

    def _refuse(self, error: BaseException) -> None:
        self.go.setEnabled(True)
        said = f"Folder: {error}" if isinstance(error, FileError) else str(error)
        self.folder.refuse(said.replace("write over with --force", f"tick “{without(self.replace.text())}”"))


class TransferController:
    """Joins the dialogs of import, export and comparison with the work strip and the session that is open."""

    def __init__(self, sessions: SessionController) -> None:
        self.sessions, self.setup_model = sessions, sessions.setup_file.model
        self.services = services = sessions.services
        self.dialog: QDialog | None = None
        self._say = partial(services.board.post, "info")

    def ask_import(self, files: Sequence[Path] = ()) -> None:
        """Let the operator choose what to import, or how `files` are."""
        dialog = ImportDialog(self.services, self.setup_model, self.sessions.panel)
        self._show(dialog, dialog.ordered, self.bring_in)
        if files:
            dialog.choose(list(files))

    def ask_export(self) -> None:
        """Let the operator choose what to export."""
        session = self.services.control.session
        if session is None:
            self.services.board.post("warning", "There is nothing to export: record a run, or open a session.")
            return
        dialog = ExportDialog(self.services, session.path, self.sessions.runs.table.chosen)
        self._show(dialog, dialog.ordered, self.take_out)

    def ask_with_this_setup(self) -> None:
        """Let the operator process the chosen run with the setup in the window, beside what is stored."""
        self.ask_compare(with_setup=True)

    def ask_compare(self, *, with_setup: bool = False) -> None:
        """Let the operator process runs with other settings."""
        session, runs = self.services.control.session, self.sessions.runs.counting
        if session is None or not runs or self.services.control.state.holds_a_run:
            self.services.board.post("warning", "There is no run to process again: record one, or open a session.")
            return
        setup, chosen = self.setup_model.own_setup, self.sessions.runs.table.chosen
        read_only, path = bool(session.read_only), self.setup_model.own_path
        own = (
            {"setup_words": f"Your own setup, {path.name if path else 'not saved'}"}
            if self.setup_model.reviewed
            else {}
        )
        dialog = ReprocessDialog(self.services, runs, chosen, setup, read_only=read_only, with_setup=with_setup, **own)
        self._show(dialog, dialog.kept, self.sessions.reread)

    def bring_in(self, order: ImportOrder) -> None:
        """Import in the background, then open the new session."""
        self.services.work.start(
            "importing recordings",
            lambda task: import_recordings(order, task.report),
            self._brought_in,
            self._not_brought_in,
            lambda: self._say("The import was cancelled; runs that were there already are kept."),
        )

    def take_out(self, plan: ExportPlan) -> None:
        """Export in the background."""
        self.services.work.start(
            "exporting samples",
            lambda task: tuple(plan.carry_out(task.report)),
            lambda runs: self._taken(plan, runs),
            cancelled=lambda: self._say(f"The export was cancelled; files that were done: {plan.folder}"),
        )

    def _not_brought_in(self, error: BaseException) -> None:
        self.services.board.post_error(error)
        self.sessions.panel.say_at_field(error)

    def _brought_in(self, imported: Imported) -> None:
        for error in imported.errors:
            self.services.board.post_error(error)
        if imported.session is None:
            return
        self._say(f"{counted(len(imported.paths), 'run')} imported as session {imported.session.name}")
        if not self.services.control.state.running:
            self.sessions.open(imported.session)

    def _taken(self, plan: ExportPlan, runs: tuple[Outcome[tuple[Path, ...]], ...]) -> None:
        for run in runs:
            if run.error is not None:
                self.services.board.post_error(run.error)
        files = sum(len(run.value or ()) for run in runs)
        if files:
            self._say(f"{counted(files, 'file')} written to {plan.folder}")

    def close(self) -> None:
        """Cancel and close the dialog."""
        if self.dialog is not None:
            self.dialog.reject()
            # what still runs may come back to it
            if not self.services.jobs.running:
                self.dialog.deleteLater()
            self.dialog = None

    def _show(self, dialog: QDialog, answered: SignalInstance, does: Callable[..., None]) -> None:
        self.close()
        self.dialog = dialog
        answered.connect(does)
        dialog.show()


_MOST = 8
"""Sessions and setups that the menu remembers (chosen by hand): more are found by search."""
_KEPT = "recent"


class Arrivals(QObject):
    """Opens what is dropped: a session, a setup, a folder of recordings or recordings, which are imported."""

    def __init__(self, sessions: SessionController, transfer: TransferController, services: Services) -> None:
        super().__init__(services.parent)
        self._sessions, self._transfer, self._services = sessions, transfer, services
        self._model, self._menu = sessions.setup_file.model, QMenu()
        services.parent.setAcceptDrops(True)
        services.parent.installEventFilter(self)
        services.control.session_changed.connect(self._note_session)
        self._model.changed.connect(lambda: self.note(self._model.own_path))

    def fill(self, menu: QMenu) -> None:
        """Add the menu of what was opened before."""
        self._menu = menu.addMenu("Open recent")
        self._show()

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802 - Qt's name
        """Take what is dropped."""
        if isinstance(event, QDropEvent) and event.type() in (QEvent.Type.DragEnter, QEvent.Type.Drop):
            paths = [Path(url.toLocalFile()) for url in event.mimeData().urls() if url.isLocalFile()]
            if paths:
                event.acceptProposedAction()
                if event.type() == QEvent.Type.Drop:
                    self.open(paths)
            return bool(paths)
        return super().eventFilter(watched, event)

    def open(self, paths: Sequence[Path]) -> None:
        """Open a session or a setup; everything else is imported, of a folder what is in it."""
        first = paths[0].parent if paths[0].name == FILE_NAME else paths[0]
        if (first / FILE_NAME).is_file():
            self._sessions.open(first)
        elif first.suffix == ".toml":
            if self._services.control.state.running:
                self._services.board.post("warning", "Stop before another setup is opened.")
            elif self._sessions.setup_file.may_discard():
                self._sessions.setup_file.open(first)
        else:
            inside = (sorted(one.iterdir()) if one.is_dir() else [one] for one in paths)
            self._transfer.ask_import(tuple(one for files in inside for one in files if one.is_file()))

    def note(self, path: Path | None) -> None:
        """Remember what was opened."""
        known = self._known
        if path is not None and str(path) not in known[:1]:
            kept = dict.fromkeys((str(path), *known))
            self._services.settings.put(_KEPT, "\n".join(list(kept)[:_MOST]))
            self._show()

    @property
    def _known(self) -> list[str]:
        return self._services.settings.text(_KEPT).splitlines()

    def _note_session(self) -> None:
        session = self._services.control.session
        self.note(session.path if session else None)

    def _show(self) -> None:
        self._menu.clear()
        for number, text in enumerate(self._known, 1):
            path = Path(text)
            self._menu.addAction(f"&{number} {path.name} ({path.parent.name})", partial(self.open, [path]))
        self._menu.menuAction().setVisible(bool(self._menu.actions()))
