"""Processing again: the dialog for the session that is open, and what is shown anew afterwards."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import QObject

from radargui.gui.sessions.reprocess_dialog import ReprocessDialog

if TYPE_CHECKING:
    from radargui.gui.main_window import MainWindow


class ReprocessDesk(QObject):
    """Joins the dialog with the list of runs."""

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        self._window = window
        self.dialog: ReprocessDialog | None = None

    def ask(self) -> None:
        """Let the operator choose other settings."""
        window = self._window
        session = window.control.session
        runs = session.run_paths() if session is not None else ()
        if session is None or not runs or window.control.state.holds_a_run:
            window.board.post("warning", "There is no run to process again: record one, or open a session.")
            return
        self.close()
        chosen = window.runs.chosen
        self.dialog = ReprocessDialog(
            window.jobs,
            runs,
            chosen.path if chosen else None,
            window.setup_model.setup,
            read_only=bool(session.read_only),
            parent=window,
        )
        self.dialog.kept.connect(lambda _runs: window.sessions.reread())
        self.dialog.show()

    def close(self) -> None:
        """Cancel and close the dialog."""
        if self.dialog is not None:
            self.dialog.reject()
            self.dialog = None
