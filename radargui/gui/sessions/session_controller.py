"""What the window does with sessions: browse, open, take the setup of one, keep what is said of it."""

from collections.abc import Mapping
from concurrent.futures import Future, wait
from datetime import datetime
from functools import partial
from pathlib import Path
from typing import Literal

from PySide6.QtCore import QObject, Signal
from PySide6.QtWidgets import QFileDialog, QMessageBox

from radargui.experiment.reporting import report_series
from radargui.gui.background import Task, Then, Work
from radargui.gui.control.state import Details
from radargui.gui.layout import having, ticking
from radargui.gui.runs.run_controller import RunController
from radargui.gui.services import Services
from radargui.gui.sessions.browser import SessionBrowser
from radargui.gui.setup.session_panel import SessionPanel
from radargui.gui.setup.setup_model import SetupFileController, named
from radargui.model.errors import CancelledError, SessionError
from radargui.model.setup import Setup
from radargui.model.setup_error import changed_settings
from radargui.model.words import counted
from radargui.session.catalogue import default_index_path
from radargui.session.info import SessionInfo, read_info
from radargui.session.lock import Owner, SessionLock, SessionLockedError, owner_of
from radargui.session.session import Session


def _opened(path: Path, task: Task) -> Session:
    session = Session.open(path)
    try:
        task.report(1.0)
    except CancelledError:
        session.close()
        raise
    return session


_Answer = Literal["new", "add", "correct"]
_SAVE_DETAILS_MS = 800
"""After the last key (chosen by hand): a shorter wait writes within a word, a longer one loses more at a crash."""


_ENTER_MS = 500
"""After which it is looked who else works in the data folder (chosen by hand): nobody waits for that."""


class SessionController(QObject):
    """Joins browser, session panel and the session that is open."""

    opened, setup_taken = Signal(), Signal()

    def __init__(
        self,
        panel: SessionPanel,
        browser: SessionBrowser,
        runs: RunController,
        file: SetupFileController,
        services: Services,
    ) -> None:
        super().__init__(services.parent)
        self.panel, self.run_controller, self.setup_file, self.services = panel, runs, file, services
        self.control, self.runs = services.control, runs.runs
        self.browser = browser
        self.browser.open_asked.connect(self.open)
        self.browser.setup_asked.connect(self.take_setup)
        self.browser.elsewhere_asked.connect(self.ask_folder)
        self.browser.series_asked.connect(self.report_series)
        self._save = ticking(self, _SAVE_DETAILS_MS, self._save_aside, once=True)
        panel.details_changed.connect(self._said)
        self._asks = False
        self._corrected: dict[str, str] = {}
        """Names that are on their way to the disk."""
        self._held: Session | None = None
        self._opening: Path | None = None
        self._writes: list[Future[None]] = []
        self._typed: Details | None = None
        self.control.session_changed.connect(self._let_go)
        self._right: SessionLock | None = None
        # once the window is drawn, and once the path is typed
        self._entering = ticking(self, _ENTER_MS, self._enter_folder, once=True)
        self._entering.start()
        panel.folder_changed.connect(self._entering.start)
        panel.mark_asked.connect(self.mark)

    def _enter_folder(self) -> None:
        """Say where another window works in the data folder; sessions are locked each by itself, whatever is said."""
        folder, board = self.panel.data_folder, self.services.board
        self._show_sessions()

        def work() -> SessionLock | Owner | None:
            # beside the index, where it can be written although there may be no data folder yet
            place = default_index_path(folder).with_suffix(".window")
            try:
                place.mkdir(parents=True, exist_ok=True)
                return SessionLock(place)
            except SessionLockedError:
                return owner_of(place)
            except (SessionError, OSError):
                return None

        def show(found: SessionLock | Owner | None) -> None:
            self.leave_folder()
            if isinstance(found, SessionLock):
                self._right = found
            elif found is not None:
                others = "what is recorded there is seen here once the list of sessions is opened anew"
                board.post("warning", f"A second window works in {folder} ({found}): {others}.")

        self.services.jobs.start(
            "looking for a second window", work, show, wanted=lambda: folder == self.panel.data_folder
        )

    def leave_folder(self) -> None:
        """Let another window work in the data folder alone."""
        if self._right is not None:
            self._right.release()
            self._right = None

    def begin_new(self) -> None:
        """Let the next Record make a new session."""
        self.flush()
        self.control.use_session(None)

    def ask_folder(self) -> None:
        """Let the operator choose a session folder anywhere."""
        name = QFileDialog.getExistingDirectory(self.services.parent, "Open session", str(self.panel.data_folder))
        if name:
            self.open(Path(name))

    def open(self, path: Path) -> None:
        """Read a session that was recorded before, in the background, and show it; of several the last one asked for.

        One that cannot be written is opened for looking.
        """
        if self.control.state.running:
            self.services.board.post("warning", "Stop before another session is opened.")
        elif path != self._opening:
            self._opening = path
            self.services.work.start(
                f"opening {path.name}",
                partial(_opened, path),
                partial(self._show, path),
                partial(self._not_opened, path),
                partial(self._not_opened, path),
            )

    def _show(self, path: Path, session: Session) -> None:
        board, unwanted = self.services.board, path != self._opening
        if unwanted or self.control.state.running:
            self._leave(session)
            if not unwanted:
                self._opening = None
                board.post("warning", f"{path.name} was not opened: stop first, then open it again.")
            return
        info = session.info
        # what was typed is still said of the session before
        self.flush()
        if self._typed is None:
            self._typed = self.panel.details
        self.panel.set_details(info.operator, info.notes, info.sample, info.target)
        self.control.use_session(session, reviewed=True)
        self.opened.emit()
        if session.read_only:
            board.post("warning", f"{path.name} is opened for looking only. {session.read_only}")

    def _not_opened(self, path: Path, error: BaseException | None = None) -> None:
        """Say why, unless it was cancelled or another one was asked for since."""
        if path == self._opening:
            self._opening = None
            if error is not None:
                self.services.board.post_error(error)

    def report_series(self, sessions: tuple[Path, ...]) -> None:
        """Let the operator choose a folder, and write the report of several sessions together into it."""
        begin = str(self.panel.data_folder)
        name = QFileDialog.getExistingDirectory(self.browser, "Folder for the report of the series", begin)
        if name:
            board = self.services.board
            self.services.work.start(
                f"the report of {len(sessions)} sessions",
                lambda task: report_series(sessions, Path(name), task.report),
                lambda made: board.post("info", f"Report of the series written: {made}"),
            )

    def may_add(self, setup: Setup) -> bool:
        """Return whether Record may begin; asks where it would add to a session that was opened for review."""
        if not self._settle_names():
            return False
        session = self.control.session
        if session is not None and session.setup != setup:
            changed = named([one.key for one in changed_settings(session.setup, setup)])
            self.services.board.post("info", f"New session begins: {changed} changed.")
        if session is None or session.read_only or not self.control.is_reviewed or session.setup != setup:
            return True
        answer = self.ask_where(session.path.name)
        if answer == "new":
            self.begin_new()
        elif answer == "add":
            self.control.is_reviewed = False
            self._typed = None
        return answer != ""

    def ask_where(self, name: str) -> _Answer | Literal[""]:
        """Ask the operator where the next runs go; empty: nowhere, do not record."""
        words = f"{name} was opened for review. Where shall the next runs go?"
        return self._ask(words, {"new": "New session", "add": f"Add to {name}"})

    def _ask(self, words: str, answers: Mapping[_Answer, str], *, may_begin: bool = True) -> _Answer | Literal[""]:
        """Ask which of some answers holds; empty: none. Enter gives the first one, where a session may begin."""
        box = having(QMessageBox(self.services.parent), windowTitle="RadarGUI", text=words)
        buttons = {name: box.addButton(said, QMessageBox.ButtonRole.AcceptRole) for name, said in answers.items()}
        buttons["new"].setEnabled(may_begin)
        cancel = box.addButton(QMessageBox.StandardButton.Cancel)
        box.setDefaultButton(buttons["new"] if may_begin else cancel)
        box.exec()
        return next((name for name, one in buttons.items() if one is box.clickedButton()), "")

    def take_setup(self, path: Path) -> None:
        """Use the settings of a session for the next one."""
        self.services.jobs.start("the setup of a session", lambda: read_info(path), self._take)

    def mark(self, text: str) -> None:
        """Keep a note of this moment, in the background: the disk may take its time."""
        session = self.control.session
        if session is None:
            self.services.board.post("warning", "There is no session yet: record a run, or open a session.")
            return
        # the moment is now, not when a thread gets its turn
        now = datetime.now().astimezone()
        self._write("a note", lambda: session.mark(text, now=now), self.panel.show_marked)

    def reread(self) -> None:
        """Show anew what may have changed on the disk: the list of runs, the browser."""
        session = self.control.session
        if session is not None and self.control.state.running:
            self.run_controller.renew()
        elif session is not None:
            chosen = self.runs.table.chosen
            self.run_controller.show_session(session, chosen.path if chosen else None)
        self._show_sessions()

    def _show_sessions(self, _written: object = None) -> None:
        """Look at all sessions again where they are seen: one has changed."""
        if self.browser.isVisible():
            self.browser.refresh()

    def flush(self) -> None:
        """Save now what was typed of the session that is open, in the background."""
        if self._save.isActive():
            self._save.stop()
            self._save_aside()

    def _let_go(self) -> None:
        """Let other programs write to the session that was open before."""
        before, self._held = self._held, self.control.session
        if not self.control.state.running:
            # what is still being read was asked for before
            self._opening = None
        if before is not self._held:
            self._corrected = {}
            if before is not None:
                self._leave(before)
        if self._held is not None and self.control.is_reviewed:
            self.setup_file.model.review(self._held.setup, self._held.path.name)
        else:
            self.setup_file.model.end_review()
        if not self.control.is_reviewed and self._typed is not None:
            # what an old session says of itself is not said of the next one
            self.panel.set_details(*self._typed)
            self._typed = None

    def _leave(self, session: Session) -> None:
        """Close a session once all is written that is on its way, in the background: its disk may take its time."""
        writes, self._writes = self._writes, []

        def work() -> None:
            wait(writes)
            session.close()

        self.services.jobs.start("the end of a session", work)

    @property
    def _renamed(self) -> dict[str, str]:
        """Of sample and target what is called otherwise now than runs of the session are, with the name they have."""
        session, said = self.control.session, self.panel.details._asdict()
        if session is None or session.read_only or not self.runs.model.entries:
            return {}
        known = {"sample": session.info.sample, "target": session.info.target} | self._corrected
        return {key: was for key, was in known.items() if said[key] != was}

    def _said(self) -> None:
        if self._renamed:
            self._settle_names()
        else:
            self._save.start()

    def _settle_names(self) -> bool:
        """Ask what another name means where runs have one: what comes next, or a mistake; return whether it is settled.

        The runs that are there would be called by it, and pooled with the next ones.
        """
        session, renamed = self.control.session, self._renamed
        if session is None or not renamed or self._asks:
            return not renamed
        self._asks = True
        n_runs, said = len(self.runs.model.entries), self.panel.details._asdict()
        known = ", ".join(f"{key} “{was}”" if was else f"no {key}" for key, was in renamed.items())
        answer = self.ask_name(n_runs, known, may_begin=not self.control.state.running)
        self._asks = False
        if answer == "new":
            # what was typed is said of the next one
            self._typed = None
            self.control.use_session(None)
        elif answer == "correct":
            now, runs = datetime.now().astimezone(), counted(n_runs, "run")
            before = {key: f"“{was}”" if was else "none" for key, was in renamed.items()}
            words = [f"{key.capitalize()} of {runs} corrected: {was} is “{said[key]}”" for key, was in before.items()]

            def correct() -> None:
                session.update(**{key: said[key] for key in renamed})
                for text in words:
                    session.mark(text, now=now)

            self._write("the session's record", correct, self._show_sessions)
            self._corrected = {key: said[key] for key in renamed}
        else:
            self.panel.set_details(**said | renamed)
        return answer != ""

    def ask_name(self, n_runs: int, known: str, *, may_begin: bool) -> _Answer | Literal[""]:
        """Ask what another sample or target means; empty: the name stays as it was."""
        runs, has = counted(n_runs, "run"), "has" if n_runs == 1 else "have"
        words = f"{runs} of this session {has} {known}. Does another one come now, or was that wrong?"
        answers: dict[_Answer, str] = {"new": "New session", "correct": f"Correct the name of {runs}"}
        return self._ask(words, answers, may_begin=may_begin)

    def _save_aside(self) -> None:
        session, panel = self.control.session, self.panel
        if session is None or session.read_only:
            return
        # another name is asked for, never taken over beside something else
        details = panel.details._asdict() | self._renamed
        self._write("the session's record", lambda: session.update(**details), self._show_sessions)

    def _write(self, what: str, work: Work, then: Then) -> None:
        under_way = (one for one in self._writes if not one.done())
        self._writes = [*under_way, self.services.jobs.start(what, work, then)]

    def _take(self, info: SessionInfo) -> None:
        if self.control.state.running:
            self.services.board.post("warning", "Stop before the setup is changed.")
            return
        if not self.setup_file.may_discard():
            return
        self.setup_file.model.take(info.setup)
        self.begin_new()
        self.setup_taken.emit()
        self.services.board.post("info", f"Set up as in {info.name}. The next Record makes a new session.")
