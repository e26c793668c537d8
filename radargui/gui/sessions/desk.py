"""What the window does with sessions: browse, open for review, take the setup of one, keep what is said of it."""

from __future__ import annotations

from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, QTimer
from PySide6.QtWidgets import QFileDialog

from radargui.gui.sessions.browser import SessionBrowser
from radargui.model.errors import RadarGuiError
from radargui.session.info import SessionInfo, read_info
from radargui.session.session import Session

if TYPE_CHECKING:
    from radargui.gui.main_window import MainWindow

_SAVE_DETAILS_MS = 800


class SessionsDesk(QObject):
    """Joins browser, session panel and the session that is open."""

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        self._window = window
        self._browser: SessionBrowser | None = None
        self._save = QTimer(self)
        self._save.setSingleShot(True)
        self._save.setInterval(_SAVE_DETAILS_MS)
        self._save.timeout.connect(self._save_aside)
        panel = window.session_panel
        panel.details_changed.connect(self._save.start)
        panel.open_asked.connect(self.browse)
        self._held: Session | None = None
        window.control.session_changed.connect(self._let_go)
        panel.mark_asked.connect(self.mark)
        window.recovery.recovered.connect(lambda _runs: self.reread())

    @property
    def browser(self) -> SessionBrowser:
        """The browser, made when it is first asked for."""
        if self._browser is None:
            window = self._window
            self._browser = SessionBrowser(
                window.theme, window.jobs, window.work, lambda: window.session_panel.data_folder, window
            )
            self._browser.open_asked.connect(self.open)
            self._browser.setup_asked.connect(self.take_setup)
            self._browser.elsewhere_asked.connect(self.ask_folder)
        return self._browser

    def browse(self) -> None:
        """Show the browser."""
        self.browser.show()
        self.browser.raise_()
        self.browser.activateWindow()

    def ask_folder(self) -> None:
        """Let the operator choose a session folder anywhere."""
        name = QFileDialog.getExistingDirectory(
            self._window, "Open session", str(self._window.session_panel.data_folder)
        )
        if name:
            self.open(Path(name))

    def open(self, path: Path) -> None:
        """Show a session that was recorded before; one that cannot be written is opened for looking."""
        window = self._window
        if window.control.state.running:
            window.board.post("warning", "Stop before another session is opened.")
            return
        self.flush()
        try:
            session = Session.open(path)
        except RadarGuiError as error:
            window.board.post_error(error)
            return
        info = session.info
        window.session_panel.set_details(info.operator, info.notes, info.sample, info.target)
        window.control.use_session(session)
        if session.read_only:
            window.board.post("warning", f"{path.name} is opened for looking only. {session.read_only}")

    def take_setup(self, path: Path) -> None:
        """Use the settings of a session for the next one."""
        self._window.jobs.start(
            "the setup of a session",
            lambda: read_info(path),
            self._take,
            self._window.board.post_error,
        )

    def mark(self, text: str) -> None:
        """Keep a note of this moment, in the background: the disk may take its time."""
        session = self._window.control.session
        if session is None:
            self._window.board.post("warning", "There is no session yet: record a run, or open a session.")
            return
        # the moment is now, not when a thread gets its turn
        now = datetime.now().astimezone()
        self._window.jobs.start(
            "a note",
            lambda: session.mark(text, now=now),
            lambda entry: self._window.session_panel.show_marked(entry),
            self._window.board.post_error,
        )

    def reread(self) -> None:
        """Show anew what may have changed on the disk: the list of runs, the browser."""
        window = self._window
        session = window.control.session
        if session is not None and not window.control.state.running:
            chosen = window.runs.chosen
            window.run_desk.show_session(session)
            rows = [row for row, one in enumerate(window.runs.model.entries) if chosen and one.path == chosen.path]
            if rows:
                window.runs.table.selectRow(rows[0])
        if self._browser is not None and self._browser.isVisible():
            self._browser.refresh()

    def flush(self) -> None:
        """Save now what was typed of the session that is open."""
        if self._save.isActive():
            self._save.stop()
            try:
                self._update()
            except RadarGuiError as error:
                self._window.board.post_error(error)

    def _let_go(self) -> None:
        """Let other programs write to the session that was open before."""
        before, self._held = self._held, self._window.control.session
        if before is not None and before is not self._held:
            before.close()

    def _save_aside(self) -> None:
        if self._window.control.session is None:
            return
        self._window.jobs.start("the session's record", self._updater(), lambda _: None, self._window.board.post_error)

    def _update(self) -> None:
        self._updater()()

    def _updater(self) -> object:
        session, panel = self._window.control.session, self._window.session_panel
        said = {"operator": panel.operator, "notes": panel.notes, "sample": panel.sample, "target": panel.target}

        def update() -> None:
            if session is not None and not session.read_only:
                session.update(**said)

        return update

    def _take(self, info: SessionInfo) -> None:
        window = self._window
        if window.control.state.running:
            window.board.post("warning", "Stop before the setup is changed.")
            return
        window.control.use_session(None)
        # the file that was open is not the one these settings belong to
        window.setup_model.path = None
        window.setup_model.replace(info.setup)
        window.panels.bring_up("hardware")
        window.board.post("info", f"Set up as in {info.name}. The next Record makes a new session.")
