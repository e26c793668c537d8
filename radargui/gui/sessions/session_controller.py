"""What the window does with sessions: browse, open for review, take the setup of one, keep what is said of it."""

from datetime import datetime
from pathlib import Path
from typing import Literal

from PySide6.QtCore import QObject, QTimer, Signal
from PySide6.QtWidgets import QFileDialog, QMessageBox

from radargui.gui.control.run_control import RunControl
from radargui.gui.runs.run_controller import RunController
from radargui.gui.runs.run_list_panel import RunListPanel
from radargui.gui.services import Services
from radargui.gui.sessions.browser import SessionBrowser
from radargui.gui.setup.session_panel import Details, SessionPanel
from radargui.gui.setup.setup_file import SetupFileController
from radargui.model.errors import RadarGuiError
from radargui.model.setup import Setup
from radargui.session.info import SessionInfo, read_info
from radargui.session.session import Session

_SAVE_DETAILS_MS = 800


class SessionController(QObject):
    """Joins browser, session panel and the session that is open."""

    setup_taken = Signal()

    def __init__(
        self,
        control: RunControl,
        panel: SessionPanel,
        runs: RunListPanel,
        run_controller: RunController,
        setup_file: SetupFileController,
        services: Services,
    ) -> None:
        super().__init__(services.parent)
        self._control, self._panel, self._runs, self._run_controller = control, panel, runs, run_controller
        self._setup_file = setup_file
        self._services = services
        self._board, self._jobs = services.board, services.jobs
        self._browser: SessionBrowser | None = None
        self._save = QTimer(self, singleShot=True, interval=_SAVE_DETAILS_MS)
        self._save.timeout.connect(self._save_aside)
        panel.details_changed.connect(self._save.start)
        self._held: Session | None = None
        self._typed: Details | None = None
        control.session_changed.connect(self._let_go)
        panel.mark_asked.connect(self.mark)

    @property
    def browser(self) -> SessionBrowser:
        """The browser, made when it is first asked for."""
        if self._browser is None:
            own = self._services
            self._browser = SessionBrowser(own.theme, own.jobs, own.work, lambda: self._panel.data_folder, own.parent)
            own.settings.restore_sizes(self._browser)
            self._browser.open_asked.connect(self.open)
            self._browser.setup_asked.connect(self.take_setup)
            self._browser.elsewhere_asked.connect(self.ask_folder)
        return self._browser

    def browse(self) -> None:
        """Show the browser."""
        self.browser.come_up()

    def ask_folder(self) -> None:
        """Let the operator choose a session folder anywhere."""
        name = QFileDialog.getExistingDirectory(self._services.parent, "Open session", str(self._panel.data_folder))
        if name:
            self.open(Path(name))

    def open(self, path: Path) -> None:
        """Show a session that was recorded before; one that cannot be written is opened for looking."""
        if self._control.state.running:
            self._board.post("warning", "Stop before another session is opened.")
            return
        self.flush()
        try:
            session = Session.open(path)
        except RadarGuiError as error:
            self._board.post_error(error)
            return
        info = session.info
        if self._typed is None:
            self._typed = self._panel.details
        self._panel.set_details(info.operator, info.notes, info.sample, info.target)
        self._control.use_session(session, reviewed=True)
        if session.read_only:
            self._board.post("warning", f"{path.name} is opened for looking only. {session.read_only}")

    def may_add(self, setup: Setup) -> bool:
        """Return whether Record may begin; asks where it would add to a session that was opened for review."""
        session = self._control.session
        if session is None or session.read_only or not self._control.is_reviewed or session.setup != setup:
            return True
        answer = self.ask_where(session.path.name)
        if answer == "new":
            self._control.use_session(None)
        elif answer == "add":
            self._control.is_reviewed = False
            self._typed = None
        return answer != ""

    def ask_where(self, name: str) -> Literal["new", "add", ""]:
        """Ask the operator where the next runs go; empty: nowhere, do not record."""
        box = QMessageBox(self._services.parent)
        box.setWindowTitle("RadarGUI")
        box.setText(f"{name} was opened for review. Where shall the next runs go?")
        new = box.addButton("New session", QMessageBox.ButtonRole.AcceptRole)
        add = box.addButton(f"Add to {name}", QMessageBox.ButtonRole.AcceptRole)
        box.addButton(QMessageBox.StandardButton.Cancel)
        box.setDefaultButton(new)
        box.exec()
        chosen = box.clickedButton()
        return "new" if chosen is new else "add" if chosen is add else ""

    def take_setup(self, path: Path) -> None:
        """Use the settings of a session for the next one."""
        self._jobs.start("the setup of a session", lambda: read_info(path), self._take)

    def mark(self, text: str) -> None:
        """Keep a note of this moment, in the background: the disk may take its time."""
        session = self._control.session
        if session is None:
            self._board.post("warning", "There is no session yet: record a run, or open a session.")
            return
        # the moment is now, not when a thread gets its turn
        now = datetime.now().astimezone()
        self._jobs.start("a note", lambda: session.mark(text, now=now), self._panel.show_marked)

    def reread(self) -> None:
        """Show anew what may have changed on the disk: the list of runs, the browser."""
        session = self._control.session
        if session is not None and not self._control.state.running:
            chosen = self._runs.chosen
            self._run_controller.show_session(session)
            rows = [row for row, one in enumerate(self._runs.model.entries) if chosen and one.path == chosen.path]
            if rows:
                self._runs.table.selectRow(rows[0])
        if self._browser is not None and self._browser.isVisible():
            self._browser.refresh()

    def flush(self) -> None:
        """Save now what was typed of the session that is open, in the background."""
        if self._save.isActive():
            self._save.stop()
            self._save_aside()

    def _let_go(self) -> None:
        """Let other programs write to the session that was open before."""
        before, self._held = self._held, self._control.session
        if before is not None and before is not self._held:
            before.close()
        if not self._control.is_reviewed and self._typed is not None:
            # what an old session says of itself is not said of the next one
            self._panel.set_details(*self._typed)
            self._typed = None

    def _save_aside(self) -> None:
        session, panel = self._control.session, self._panel
        if session is None or session.read_only:
            return
        details = panel.details._asdict()
        self._jobs.start("the session's record", lambda: session.update(**details))

    def _take(self, info: SessionInfo) -> None:
        if self._control.state.running:
            self._board.post("warning", "Stop before the setup is changed.")
            return
        if not self._setup_file.take(info.setup):
            return
        self._control.use_session(None)
        self.setup_taken.emit()
        self._board.post("info", f"Set up as in {info.name}. The next Record makes a new session.")
