"""Import and export: the dialogs, the work behind them, and what is said afterwards."""

from pathlib import Path

from PySide6.QtCore import QObject, Signal
from PySide6.QtWidgets import QCheckBox, QDialog, QFileDialog, QLineEdit, QWidget

from radargui.experiment.importing import Imported, ImportOrder, import_recordings
from radargui.files.export import EXPORT_FORMATS, ExportFormat
from radargui.files.fresh_file import make_folder
from radargui.gui.background import Jobs
from radargui.gui.control.run_control import RunControl
from radargui.gui.layout import Choice, Dialog, FaultText, Group, button, side_by_side
from radargui.gui.runs.run_list_panel import RunListPanel
from radargui.gui.services import Services
from radargui.gui.sessions.import_dialog import ImportDefaults, ImportDialog
from radargui.gui.setup.session_panel import SessionPanel
from radargui.gui.setup.setup_model import SetupModel
from radargui.gui.theme import Theme
from radargui.model.errors import FileError
from radargui.session.transfer import FOLDER, ExportedRun, ExportPlan, plan_export


class ExportDialog(Dialog):
    """Asks what to export; `ordered` brings the plan, once the folder is one that takes it."""

    ordered = Signal(object)

    def __init__(
        self, jobs: Jobs, theme: Theme, session: Path, run: Path | None, parent: QWidget | None = None
    ) -> None:
        super().__init__("Export samples", (520, 200), parent)
        self._jobs = jobs
        one = [(run, f"The chosen run, {run.stem}")] if run is not None else []
        self.what = Choice((*one, (session, f"All runs of the session {session.name}")))
        self.kind = Choice((one.name, f"{one.title} ({', '.join(one.suffixes)})") for one in EXPORT_FORMATS.values())
        self.folder = QLineEdit(str(session / FOLDER))
        self.replace = QCheckBox("Replace files that are there")
        self.go = go = button("Export", self._order, default=True)
        group = Group()
        group.row("What", self.what)
        group.row("Format", self.kind, "Each file carries the settings and units")
        self.fault = FaultText(theme)
        group.row("Folder", side_by_side(self.folder, button("Choose…", self._browse)), fault=self.fault)
        group.whole(self.replace)
        ends = side_by_side(go, button("Cancel", self.reject))
        self.lay_out(group, ends)
        self.folder.textChanged.connect(lambda text: go.setEnabled(bool(text.strip())))
        for changed in (self.folder.textChanged, self.replace.toggled, self.kind.activated, self.what.activated):
            changed.connect(lambda _value: self.fault.say(""))

    def _browse(self) -> None:
        name = QFileDialog.getExistingDirectory(self, "Export to", self.folder.text())
        if name:
            self.folder.setText(name)

    def _order(self) -> None:
        folder = Path(self.folder.text().strip().strip('"')).expanduser()
        what, kind, force = self.what.currentData(), EXPORT_FORMATS[self.kind.currentData()], self.replace.isChecked()
        self.go.setEnabled(False)
        self._jobs.start(
            "looking at the folder", lambda: _planned(Path(what), kind, folder, force=force), self._accept, self._refuse
        )

    def _accept(self, plan: ExportPlan) -> None:
        if self.isVisible():
            self.ordered.emit(plan)
            self.accept()

    def _refuse(self, error: BaseException) -> None:
        self.go.setEnabled(True)
        said = f"Folder: {error}" if isinstance(error, FileError) else str(error)
        self.fault.say(said.replace("write over with --force", f"tick “{self.replace.text()}”"))


class TransferController(QObject):
    """Joins the dialogs with the work strip and the session that is open."""

    imported = Signal(object)
    """The folder of a session that was made by an import."""

    def __init__(
        self, control: RunControl, panel: SessionPanel, runs: RunListPanel, setup_model: SetupModel, services: Services
    ) -> None:
        super().__init__(services.parent)
        self._control, self._panel, self._runs, self._setup_model = control, panel, runs, setup_model
        self._services, self._board = services, services.board
        self.dialog: QDialog | None = None

    def ask_import(self) -> None:
        """Let the operator choose what to import."""
        model, panel = self._setup_model, self._panel
        dialog = ImportDialog(
            self._services.jobs,
            self._services.theme,
            lambda: ImportDefaults(model.setup, model.path, panel.data_folder, panel.details.operator),
            self._services.parent,
        )
        dialog.ordered.connect(self.bring_in)
        self._show(dialog)

    def ask_export(self) -> None:
        """Let the operator choose what to export."""
        session = self._control.session
        if session is None:
            self._board.post("warning", "There is nothing to export: record a run, or open a session.")
            return
        chosen = self._runs.chosen
        dialog = ExportDialog(
            self._services.jobs,
            self._services.theme,
            session.path,
            chosen.path if chosen else None,
            self._services.parent,
        )
        dialog.ordered.connect(self.take_out)
        self._show(dialog)

    def bring_in(self, order: ImportOrder) -> None:
        """Import in the background, then open the new session."""
        self._services.work.start(
            "importing recordings",
            lambda task: import_recordings(order, task.report),
            self._brought_in,
            self._not_brought_in,
            lambda: self._board.post("info", "The import was cancelled; runs that were there already are kept."),
        )

    def take_out(self, plan: ExportPlan) -> None:
        """Export in the background."""
        self._services.work.start(
            "exporting samples",
            lambda task: tuple(plan.carry_out(task.report)),
            lambda runs: self._taken(plan, runs),
            cancelled=lambda: self._board.post(
                "info", f"The export was cancelled; files that were done: {plan.folder}"
            ),
        )

    def _not_brought_in(self, error: BaseException) -> None:
        self._board.post_error(error)
        self._panel.say_at_field(error)

    def _brought_in(self, imported: Imported) -> None:
        for error in imported.errors:
            self._board.post_error(error)
        if imported.session is None:
            return
        count = "1 run was" if len(imported.paths) == 1 else f"{len(imported.paths)} runs were"
        self._board.post("info", f"{count} imported as session {imported.session.name}")
        if not self._control.state.running:
            self.imported.emit(imported.session)

    def _taken(self, plan: ExportPlan, runs: tuple[ExportedRun, ...]) -> None:
        for run in runs:
            if run.error is not None:
                self._board.post_error(run.error)
        files = sum(len(run.paths) for run in runs)
        if files:
            self._board.post("info", f"{files} files written to {plan.folder}")

    def _show(self, dialog: QDialog) -> None:
        if self.dialog is not None:
            self.dialog.close()
            self.dialog.deleteLater()
        self.dialog = dialog
        dialog.show()


def _planned(what: Path, kind: ExportFormat, folder: Path, *, force: bool) -> ExportPlan:
    plan = plan_export(what, kind, folder, force=force)
    make_folder(folder)
    return plan
