"""Import and export: the dialogs, the work behind them, and what is told afterwards."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import QObject
from PySide6.QtWidgets import QDialog

from radargui.gui.sessions.export_dialog import ExportDialog, ExportOrder
from radargui.gui.sessions.import_dialog import ImportDialog
from radargui.gui.sessions.import_work import Imported, ImportOrder, carry_out
from radargui.gui.sessions.work_strip import Task
from radargui.session.export import ExportedRun, plan_export

if TYPE_CHECKING:
    from radargui.gui.main_window import MainWindow


class TransferDesk(QObject):
    """Joins the dialogs with the work strip and the session that is open."""

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        self._window = window
        self.dialog: QDialog | None = None

    def ask_import(self) -> None:
        """Let the operator choose what to import."""
        model = self._window.setup_model
        dialog = ImportDialog(self._window.jobs, lambda: (model.setup, model.path), self._window)
        dialog.ordered.connect(self.bring_in)
        self._show(dialog)

    def ask_export(self) -> None:
        """Let the operator choose what to export."""
        window = self._window
        session = window.control.session
        if session is None:
            window.board.post("warning", "There is nothing to export: record a run, or open a session.")
            return
        chosen = window.runs.chosen
        dialog = ExportDialog(session.path, chosen.path if chosen else None, window)
        dialog.ordered.connect(self.take_out)
        self._show(dialog)

    def bring_in(self, order: ImportOrder) -> None:
        """Import in the background, then open the new session."""
        window = self._window
        folder, operator = window.session_panel.data_folder, window.session_panel.operator
        window.work.start(
            "importing recordings",
            lambda task: carry_out(order, folder, operator, task),
            self._brought_in,
            window.board.post_error,
            lambda: window.board.post("info", "The import was cancelled; runs that were there already are kept."),
        )

    def take_out(self, order: ExportOrder) -> None:
        """Export in the background."""
        board = self._window.board
        self._window.work.start(
            "exporting samples",
            lambda task: _taken_out(order, task),
            lambda runs: self._taken(order, runs),
            board.post_error,
            lambda: board.post("info", f"The export was cancelled; files that were done are in {order.folder}"),
        )

    def _brought_in(self, imported: Imported) -> None:
        window = self._window
        for error in imported.errors:
            window.board.post_error(error)
        if imported.session is None:
            return
        count = "1 run was" if imported.n_runs == 1 else f"{imported.n_runs} runs were"
        window.board.post("info", f"{count} imported as session {imported.session.name}")
        if not window.control.state.running:
            window.open_session(imported.session)

    def _taken(self, order: ExportOrder, runs: tuple[ExportedRun, ...]) -> None:
        for run in runs:
            if run.error is not None:
                self._window.board.post_error(run.error)
        files = sum(len(run.paths) for run in runs)
        if files:
            self._window.board.post("info", f"{files} files written to {order.folder}")

    def _show(self, dialog: QDialog) -> None:
        if self.dialog is not None:
            self.dialog.close()
            self.dialog.deleteLater()
        self.dialog = dialog
        dialog.show()


def _taken_out(order: ExportOrder, task: Task) -> tuple[ExportedRun, ...]:
    return tuple(plan_export(order.what, order.kind, order.folder, force=order.force).carry_out(task.tell))
