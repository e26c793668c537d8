"""The main window: puts panels, state, messages and health together and lets them know of each other."""

from __future__ import annotations

import time
from pathlib import Path

from PySide6.QtCore import QTimer
from PySide6.QtGui import QCloseEvent
from PySide6.QtWidgets import QMainWindow, QMessageBox, QVBoxLayout, QWidget

from radargui.gui.about import About, facts
from radargui.gui.actions import Actions
from radargui.gui.background import Jobs
from radargui.gui.control.app_state import AppState
from radargui.gui.control.control_bar import MOST_RUNS, ControlBar
from radargui.gui.control.feed import Feed
from radargui.gui.control.health_line import HealthLine
from radargui.gui.control.run_control import MakeSource, RunControl, RunRequest
from radargui.gui.control.state_detail import detail_of
from radargui.gui.memory import remember, restore
from radargui.gui.menus import fill_menus
from radargui.gui.notice_strip import NoticeStrip
from radargui.gui.notices import NoticeBoard
from radargui.gui.opengl_probe import OpenGLProbe
from radargui.gui.panels import Panels
from radargui.gui.runs.run_desk import RunDesk
from radargui.gui.runs.run_keeping import RunKeeping
from radargui.gui.runs.run_list_panel import RunListPanel
from radargui.gui.runs.run_panel import RunPanel
from radargui.gui.scopes.iq_plane_panel import IQPlanePanel
from radargui.gui.scopes.scope_panel import WINDOWS_S, ScopePanel
from radargui.gui.sessions.desk import SessionsDesk
from radargui.gui.sessions.recovery_offer import RecoveryOffer
from radargui.gui.sessions.reprocess_desk import ReprocessDesk
from radargui.gui.sessions.transfer_desk import TransferDesk
from radargui.gui.sessions.work_strip import WorkStrip
from radargui.gui.settings import Settings
from radargui.gui.setup.antenna_panel import AntennaPanel
from radargui.gui.setup.hardware_panel import HardwarePanel
from radargui.gui.setup.ni_form import FindDevices, find_ni_devices
from radargui.gui.setup.session_panel import SessionPanel
from radargui.gui.setup_desk import SetupDesk, first_setup
from radargui.gui.theme import Theme, ThemeChoice
from radargui.gui.track.track_panel import TrackPanel
from radargui.gui.wiring.wiring_desk import WiringDesk
from radargui.session.data_folder import default_data_folder
from radargui.sources.factory import SourceKind, make_source

FRAME_MS = 33
_HEALTH_S = 0.2


class MainWindow(QMainWindow):
    """The program's one window.

    Parameters
    ----------
    theme, settings, board
        Look, memory and messages; made before the window so that their faults can be shown in it.
    setup_path
        Setup to begin with; the last one where left out.
    source
        Source to begin with.
    source_maker, find_devices
        Injected by tests.
    probe
        The test of OpenGL; None: projections.
    """

    def __init__(
        self,
        theme: Theme,
        settings: Settings,
        board: NoticeBoard,
        *,
        setup_path: Path | None = None,
        source: SourceKind = "simulated",
        source_maker: MakeSource = make_source,
        find_devices: FindDevices = find_ni_devices,
        probe: OpenGLProbe | None = None,
    ) -> None:
        super().__init__()
        self.theme, self.settings, self.board = theme, settings, board
        self.jobs = Jobs(self)
        self.setup_model = first_setup(setup_path, settings, board)
        self.control = RunControl(source_maker, self)
        self.actions_ = Actions(self)
        self.opengl_answer = ""
        self._health_due = 0.0

        self.hardware = HardwarePanel(
            self.setup_model,
            theme,
            self.jobs,
            source=source,
            replay_file=settings.path("replay_file"),
            find_devices=find_devices,
        )
        self.antennas = AntennaPanel(self.setup_model, theme)
        data_folder = settings.path("data_folder") or default_data_folder()
        self.session_panel = SessionPanel(data_folder, settings.text("operator"))
        self.scopes = ScopePanel(theme, settings.number("scope_window_s", 3.0, WINDOWS_S[0], WINDOWS_S[-1]))
        self.planes = IQPlanePanel(theme)
        self.track = TrackPanel(theme, self.setup_model.setup)
        self.runs = RunListPanel()
        self.run = RunPanel(theme)
        self.panels = Panels(
            {
                "hardware": self.hardware,
                "antennas": self.antennas,
                "session": self.session_panel,
                "scopes": self.scopes,
                "planes": self.planes,
                "track": self.track,
                "runs": self.runs,
                "run": self.run,
            }
        )
        self.bar = ControlBar(theme, self.actions_.start, self.actions_.record, self.actions_.stop)
        self.bar.runs.setValue(int(settings.number("runs", 1, 1, MOST_RUNS)))
        self.strip = NoticeStrip(board, theme)
        self.health = HealthLine(theme)
        self.work = WorkStrip(self.jobs)
        self._put_together()
        self.theme_actions = fill_menus(self.menuBar(), self.actions_, self.panels, theme)

        self.setup_desk = SetupDesk(self.setup_model, settings, board, self)
        self.run_desk = RunDesk(self.runs, self.run, self.track, self.work, self.jobs, board, self)
        self.keeping = RunKeeping(self)
        self.wiring = WiringDesk(self)
        self.sessions = SessionsDesk(self)
        self.transfer = TransferDesk(self)
        self.again = ReprocessDesk(self)
        self._connect()
        restore(self)
        self._show_setup()
        self._show_state()

        self._probe = probe
        if probe is not None:
            probe.answered.connect(self._opengl_answered)
            probe.start()
        self._timer = QTimer(self)
        self._timer.setInterval(FRAME_MS)
        self._timer.timeout.connect(self.refresh)
        self._timer.start()

    def start(self) -> None:
        """Show what the source gives, without recording."""
        if self._ready():
            self._follow_live()
            self.control.start_live(self.setup_model.setup, self.hardware.kind, self.hardware.replay.path)

    def record(self) -> None:
        """Record as many runs as the bar says."""
        if not self._ready():
            return
        self._follow_live()
        self.control.record(
            RunRequest(
                setup=self.setup_model.setup,
                kind=self.hardware.kind,
                file=self.hardware.replay.path,
                n_runs=self.bar.runs.value(),
                data_folder=self.session_panel.data_folder,
                operator=self.session_panel.operator,
                notes=self.session_panel.notes,
                sample=self.session_panel.sample,
                target=self.session_panel.target,
                setup_file=self.setup_model.path,
            )
        )

    def stop(self) -> None:
        """End what runs."""
        self.control.stop()

    def refresh(self) -> None:
        """Pull what is new and draw it; the timer's work."""
        self.control.poll()
        health, now = None, time.monotonic()
        if now >= self._health_due:
            self._health_due = now + _HEALTH_S
            health = self.control.health
            self.health.show_health(health)
            if health is not None and health.live_error is not None:
                self.board.post_once("error", str(health.live_error))
            self._show_detail()
        self.scopes.refresh(health)
        self.planes.refresh()
        self.track.refresh()

    def _ready(self) -> bool:
        if self.control.state.running and self.control.state is not AppState.LIVE:
            return False
        if not self.setup_model.valid:
            self.board.post("error", self.setup_model.error)
            return False
        if self.hardware.kind == "replay" and self.hardware.replay.path is None:
            self.board.post("error", "No file to replay is chosen. Choose one under Hardware setup.")
            return False
        return True

    def _follow_live(self) -> None:
        self.track.show_live()
        self.panels.bring_up("scopes")

    def _put_together(self) -> None:
        centre = QWidget()
        column = QVBoxLayout(centre)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(2)
        column.addWidget(self.strip)
        self.recovery = RecoveryOffer(self)
        column.addWidget(self.recovery)
        column.addWidget(self.work)
        column.addWidget(self.bar)
        column.addWidget(self.panels, 1)
        self.setCentralWidget(centre)
        self.statusBar().setSizeGripEnabled(True)
        self.statusBar().addWidget(self.health, 1)

    def _connect(self) -> None:
        does = self.actions_
        does.start.triggered.connect(self.start)
        does.record.triggered.connect(self.record)
        does.stop.triggered.connect(self.stop)
        does.pause.toggled.connect(self.scopes.pause.setChecked)
        does.show_live.triggered.connect(self._follow_live)
        self.panels.docks["track"].topLevelChanged.connect(lambda _floating: QTimer.singleShot(0, self._renew_view))
        does.open_setup.triggered.connect(self.setup_desk.ask_open)
        does.save_setup.triggered.connect(self.setup_desk.save)
        does.save_setup_as.triggered.connect(self.setup_desk.ask_save)
        does.new_session.triggered.connect(lambda: self.control.use_session(None))
        does.sessions.triggered.connect(self.sessions.browse)
        does.open_session.triggered.connect(self.sessions.ask_folder)
        does.import_.triggered.connect(self.transfer.ask_import)
        does.export_samples.triggered.connect(self.transfer.ask_export)
        does.compare.triggered.connect(self.again.ask)
        does.mark.triggered.connect(self._write_mark)
        does.report.triggered.connect(self.run_desk.report)
        does.export.triggered.connect(self.run_desk.ask_export)
        does.reprocess.triggered.connect(lambda: self.run_desk.reprocess(self.setup_model.setup))
        does.quit.triggered.connect(self.close)
        does.reset_layout.triggered.connect(self.panels.reset)
        does.dismiss.triggered.connect(self.board.clear)
        does.about.triggered.connect(self._about)
        does.in_space.toggled.connect(self.track.use_space_view)
        does.in_space.triggered.connect(
            lambda wanted: self.settings.put("track_view", "space" if wanted else "projections")
        )
        self.theme_actions.triggered.connect(lambda action: self._choose_theme(action.data()))

        self.scopes.paused_changed.connect(does.pause.setChecked)
        self.scopes.paused_changed.connect(self.planes.set_paused)
        self.scopes.paused_changed.connect(self.track.set_paused)
        self.hardware.open_asked.connect(self.setup_desk.ask_open)
        self.hardware.save_asked.connect(self.setup_desk.save)
        self.hardware.save_as_asked.connect(self.setup_desk.ask_save)
        self.session_panel.new_asked.connect(does.new_session.trigger)
        self.session_panel.folder_changed.connect(lambda: self.control.use_session(None))
        self.setup_model.changed.connect(self._show_setup)

        self.control.state_changed.connect(self._show_state)
        self.control.feed_changed.connect(self._show_feed)
        self.control.session_changed.connect(self._show_session)
        self.control.failed.connect(self.board.post_error)
        self.control.warned.connect(lambda text: self.board.post("warning", text))
        self.runs.run_chosen.connect(lambda _entry: self.panels.bring_up("run"))

    def _show_setup(self) -> None:
        self._show_actions()
        if self.setup_model.valid and not self.control.state.running:
            setup = self.setup_model.setup
            self.scopes.set_receivers(setup.n_receivers, setup.daq.range_v)
            self.planes.set_receivers(setup.n_receivers)
            if not self.track.result_shown:
                self.track.show_setup(setup)
        self._write_title()

    def _show_state(self) -> None:
        state = self.control.state
        running = state.running
        for panel in (self.hardware, self.antennas, self.session_panel):
            panel.set_running(running)
        self._show_actions()
        self._show_detail()
        if not running:
            self.health.show_health(None)
            self.scopes.idle()

    def _show_actions(self) -> None:
        does, state = self.actions_, self.control.state
        free = not state.running
        valid = self.setup_model.valid
        does.start.setEnabled(free and valid)
        does.record.setEnabled((free or state is AppState.LIVE) and valid)
        does.stop.setEnabled(not free)
        self.bar.runs.setEnabled(free or state is AppState.LIVE)
        for action in (does.open_setup, does.new_session, does.open_session):
            action.setEnabled(free)
        does.save_setup.setEnabled(valid)
        does.save_setup_as.setEnabled(valid)

    def _show_detail(self) -> None:
        self.bar.state.show_state(self.control.state, detail_of(self.control, self.keeping.last_run))

    def _show_feed(self, feed: Feed | None) -> None:
        for panel in (self.scopes, self.planes, self.track):
            panel.show_feed(feed)

    def _show_session(self) -> None:
        session = self.control.session
        self.session_panel.show_session(
            session.path if session else None, read_only=bool(session and session.read_only)
        )
        self.run_desk.show_session(session)
        self._write_title()

    def _write_mark(self) -> None:
        self.panels.bring_up("session")
        self.session_panel.write_mark()

    def open_session(self, path: Path) -> None:
        """Show a session that was recorded before."""
        self.sessions.open(path)

    def _choose_theme(self, choice: ThemeChoice) -> None:
        self.theme.apply(choice)
        self.settings.put("theme", choice)

    def _opengl_answered(self, usable: bool, good: bool, words: str) -> None:
        self.opengl_answer = words
        self.actions_.in_space.setEnabled(usable)
        chosen = self.settings.text("track_view", "space" if good else "projections")
        if usable and chosen == "space":
            self.actions_.in_space.setChecked(True)

    def _renew_view(self) -> None:
        self.track.renew_space_view()

    def _about(self) -> None:
        About(
            facts(self.opengl_answer or "not tested", self.session_panel.data_folder, self.setup_model.path), self
        ).exec()

    def _write_title(self) -> None:
        path, session = self.setup_model.path, self.control.session
        changed = "*" if self.setup_model.modified else ""
        where = f" · session {session.path.name}" if session else ""
        self.setWindowTitle(f"RadarGUI · {path.name if path else 'setup'}{changed}{where}")

    def closeEvent(self, event: QCloseEvent) -> None:  # noqa: N802 - Qt's name
        """Stop, join and close; asks only while a run is recorded."""
        if self.control.state.holds_a_run and not self.may_leave():
            event.ignore()
            return
        self._timer.stop()
        self.sessions.flush()
        self.work.cancel()
        self.again.close()
        if not self.control.stop_and_wait():
            self.board.post("error", "The source does not stop: unplug it, or end the program by the system.")
        if self._probe is not None:
            self._probe.close()
        self.jobs.wait()
        remember(self)
        event.accept()

    def may_leave(self) -> bool:
        """Ask whether to leave although a run is being recorded."""
        answer = QMessageBox.question(
            self, "RadarGUI", "A run is being recorded. Stop it, keep what is there, and leave?"
        )
        return answer == QMessageBox.StandardButton.Yes
