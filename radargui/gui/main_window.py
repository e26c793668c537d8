"""The main window: puts panels, state, messages and health together and lets them know of each other."""

import threading
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

from PySide6.QtCore import Qt, QTimer
from PySide6.QtGui import QAction, QCloseEvent
from PySide6.QtWidgets import QMainWindow, QMessageBox, QVBoxLayout, QWidget

from radargui.acquisition.run_output import MINIMUM_FREE_BYTES, free_bytes
from radargui.experiment.calibrating import Calibrate, calibrate_files
from radargui.gui.background import Jobs, WorkStrip
from radargui.gui.calibration.dialog import CalibrationController
from radargui.gui.control.control_bar import MAX_RUNS, ControlBar, HealthLine, MessagePlace
from radargui.gui.control.run_control import HEALTH_S, RunControl
from radargui.gui.control.state import AppState, Asked, MakeSource, RunRequest
from radargui.gui.control.waiting import ClosingStrip, StoppingStrip
from radargui.gui.full_view import DockTitles, FullView
from radargui.gui.guide import EmptyPlots, FirstSteps
from radargui.gui.layout import boxed, having, ticking
from radargui.gui.log_window import LogWindow
from radargui.gui.notices import NoticeBoard, NoticeStrip
from radargui.gui.opengl_probe import OpenGLProbe
from radargui.gui.palette import Palette
from radargui.gui.panels import About, Actions, FocusMark, Panels, RunKeys, fill_menus, show_help
from radargui.gui.runs.across import AcrossView
from radargui.gui.runs.run_controller import RunController
from radargui.gui.runs.run_keeping import RunKeeping
from radargui.gui.runs.run_list_panel import DropsPanel, RunListPanel
from radargui.gui.runs.run_panel import RunPanel
from radargui.gui.runs.situation import SituationModel
from radargui.gui.scopes.iq_plane_panel import IQPlanePanel
from radargui.gui.scopes.scope_panel import WINDOWS_S, ScopePanel
from radargui.gui.series import SeriesPanel
from radargui.gui.services import EditHistory, Services
from radargui.gui.sessions.browser import SessionBrowser
from radargui.gui.sessions.offers import LaterOffer, RecoveryOffer
from radargui.gui.sessions.session_controller import SessionController
from radargui.gui.sessions.transfer_controller import Arrivals, TransferController
from radargui.gui.settings import Settings
from radargui.gui.setup.antenna_panel import AntennaPanel
from radargui.gui.setup.channels import ChannelPanel
from radargui.gui.setup.geometry_sketch import GeometrySketch
from radargui.gui.setup.hardware_panel import FindDevices, HardwarePanel
from radargui.gui.setup.session_panel import SessionPanel
from radargui.gui.setup.setup_model import SetupFileController, first_setup
from radargui.gui.setup_words import called, is_of_antenna, kind_of, words_of
from radargui.gui.theme import Theme
from radargui.gui.track.track_curves import LEVEL_KEY
from radargui.gui.track.track_panel import ResultTrack, TrackPanel
from radargui.gui.wiring_check import WiringCheck
from radargui.model.errors import SessionError
from radargui.report.facts import Glances
from radargui.session.info import default_data_folder
from radargui.sources.factory import SourceKind, make_source
from radargui.sources.ni.discovery import find_devices
from radargui.system.resources import resource_table

FRAME_MS = 33
"""Thirty pictures a second: as many as a falling sphere needs to be followed."""


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
    source_maker, find_devices, calibrator
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
        find_devices: FindDevices = find_devices,
        calibrator: Calibrate = calibrate_files,
        probe: OpenGLProbe | None = None,
    ) -> None:
        super().__init__()
        self.theme, self.settings, self.board = theme, settings, board
        self.jobs = Jobs(board.post_error, self)
        self.setup_model = first_setup(setup_path, settings, board)
        self.control = RunControl(source_maker, self)
        self.actions_ = Actions(self)
        self.work = WorkStrip(self.jobs)
        self.history = EditHistory()
        services = Services(theme, settings, board, self.jobs, self.work, self.control, Glances(), self.history, self)
        self.opengl_answer = ""
        self._health_due = 0.0
        self._left = self._turn = False

        self.hardware = HardwarePanel(self.setup_model, self.actions_, services, source, find_devices)
        self.antennas = AntennaPanel(self.setup_model, self.actions_, self.jobs, theme)
        data_folder = settings.path("data_folder") or default_data_folder()
        self.session_panel = SessionPanel(self.actions_, data_folder, settings.text("operator"))
        self.scopes = ScopePanel(theme, settings.number("scope_window_s", 3.0, WINDOWS_S[0], WINDOWS_S[-1]))
        self.planes = IQPlanePanel(theme)
        self.track = TrackPanel(theme, self.setup_model.setup, self.jobs.start)
        self.runs = RunListPanel(theme, self.actions_)
        self.series = SeriesPanel(self.runs, self.actions_, services)
        self.run = RunPanel(theme, self.jobs.start, self.series, self._track_of_runs)
        self.run.figures.differences = self.setup_model.differences
        forms, live = (self.hardware, self.antennas, self.session_panel), (self.scopes, self.planes, self.track)
        self.browser = SessionBrowser(services, lambda: self.session_panel.data_folder)
        self.drops = DropsPanel(theme, self.runs.model)
        self.sketch = GeometrySketch(self.setup_model, theme)
        self.channels = ChannelPanel(self.setup_model, self.actions_, services)
        seen = self.drops, self.sketch, self.channels
        self.panels = Panels(*forms, *live, self.runs, self.run, self.run.figures, self.browser, *seen)
        does = self.actions_
        sounds = does.sound, does.sound_trigger, does.sound_fault
        self.bar = ControlBar(theme, self.panels.tabs, (does.start, does.record, does.stop), sounds)
        self.bar.runs.setValue(int(settings.number("runs", 1, 1, MAX_RUNS)))
        self.strip = NoticeStrip(board)
        self.health = HealthLine()
        self.recovery = RecoveryOffer(self.session_panel, services)
        self.closing = ClosingStrip(self.unfinished, lambda: self.control.end(Asked.LEAVE))
        self.stopping = StoppingStrip(self.control)
        self.later = LaterOffer(self.session_panel, services)
        offers = (self.recovery, self.later)
        self.setCentralWidget(boxed(QVBoxLayout(), self.bar, (self.panels, 1)))
        messages = self.closing, self.stopping, self.strip, *offers, self.work
        plots = self.sketch, self.track.curves.height_plot, self.run.tabs, self.browser.thumbnails
        self.place = MessagePlace(self.bar.runs, self.panels, plots, *messages)
        for pages in (self.run.tabs, self.series.pages):
            pages.currentChanged.connect(self.place.look)
        self.statusBar().addWidget(self.health, 1)
        self._keys = (FocusMark(self, theme.application), RunKeys(self, theme.application))
        self.titles = DockTitles(self.panels, theme)
        starts, records, _ = self.bar.buttons
        targets = {"source": self.hardware.source, "antennas": self.antennas.table, "monitor": starts, "arm": records}
        targets |= {"drop": self.bar.state, "read": self.bar.state, "end": self.drops}
        self.guide = FirstSteps(targets, self.hardware.source, self.panels, services)
        self.empty = EmptyPlots(self.panels.held | {"run": self.run.tabs}, self.control, self)
        self.log = LogWindow(self.setup_model, services)
        self.full = FullView(self.panels, does)
        model = self.setup_model
        self.setup_file = SetupFileController(model, services)
        self.run_controller = RunController(self.runs, self.run, self.track, services)
        self.situation = SituationModel(self.runs, self.strip, self._chosen_source, services)
        self.keeping = RunKeeping(self.run_controller, self.situation, self.stopping, does, services)
        self.across = AcrossView(self.situation, does.across, services)
        self.wiring = WiringCheck(model, self.hardware, services)
        parts = self.session_panel, self.browser, self.run_controller, self.setup_file
        self.sessions = SessionController(*parts, services)
        self.calibration = CalibrationController(self.sessions, self.antennas.calibration, calibrator)
        self.transfer = TransferController(self.sessions)
        self.arrivals = Arrivals(self.sessions, self.transfer, services)
        several = {"panels": self.panels.fill, "views": self.run.fill, "recent": self.arrivals.fill}
        self.theme_actions = fill_menus(self.menuBar(), self.actions_, theme, settings, **several)
        self.palette_ = Palette(self.menuBar(), self._why_not, self)
        self._connect()
        self.panels.restore_within(self, settings, ready=self.setup_model.valid)
        self._show_setup()
        self._show_state()
        self._show_details()
        self._show_situation()

        self._probe = probe
        self._asks = True
        if probe is not None:
            probe.answered.connect(self._opengl_answered)
            probe.start()
        self._timer = having(ticking(self, FRAME_MS, self.refresh), timerType=Qt.TimerType.PreciseTimer)
        self._timer.start()

    def start(self) -> None:
        """Show what the source gives, without recording."""
        if not self.control.state.running and self._ready():
            # who reads a moment looks at the channels
            if not self.channels.is_reading:
                self.follow_live()
            self.control.start_live(self.setup_model.setup, self.hardware.kind, self.hardware.replay.file.path)

    def record(self) -> None:
        """Record as many runs as the bar says."""
        if not self._ready() or not self.sessions.may_add(self.setup_model.own_setup):
            return
        self.setup_model.end_review()
        self.follow_live()
        self.calibration.warn()
        self.setup_model.note_run()
        self.control.record(
            RunRequest(
                setup=self.setup_model.setup,
                kind=self.hardware.kind,
                file=self.hardware.replay.file.path,
                n_runs=self.bar.runs.value(),
                data_folder=self.session_panel.data_folder,
                details=self.session_panel.details,
                setup_file=self.setup_model.path,
                is_edited=self.setup_model.modified,
            )
        )

    def refresh(self) -> None:
        """Pull what is new and draw it; the timer's work."""
        self.control.poll()
        health, now = None, time.monotonic()
        if now >= self._health_due:
            self._health_due = now + HEALTH_S
            health = self.control.health
            self.health.show_health(health)
            if health is not None and health.disk_free_bytes is not None:
                self.bar.disk.show_room(health.disk_free_bytes, health.disk_left_s)
            if health is not None and health.live_error is not None:
                self.board.post_once("error", str(health.live_error))
            self.keeping.look()
        self.scopes.refresh(health)
        # each costs as much as all scopes, and fifteen pictures a second are smooth enough: they take turns
        self._turn = not self._turn
        if self._turn:
            self.track.refresh()
        elif not self.scopes.pause.isChecked():
            self.planes.refresh()

    def _ready(self) -> bool:
        if self.closing.active or not self.control.state.may_record:
            return False
        self.session_panel.folder.refuse("")
        if fault := self.setup_model.error or self.hardware.check():
            self.board.post("error", fault)
        return not fault

    def _say_at_field(self, error: BaseException) -> None:
        """Say what failed at the field that is to be corrected, besides the message."""
        self.session_panel.say_at_field(error)
        if self.hardware.kind == "replay" and not isinstance(error, SessionError) and not self.control.had_source:
            self.hardware.replay.file.refuse(f"File: {error}")

    def follow_live(self) -> None:
        """Show the live track and the scopes: where it is measured."""
        self.track.show_live()
        self.panels.work_in("measure")
        self.panels.bring_up("scopes")

    def _connect(self) -> None:
        does, history = self.actions_, self.history
        does.connect_to(self)
        for changed in (history.canUndoChanged, history.canRedoChanged):
            changed.connect(self._show_actions)
        self.theme.application.focusChanged.connect(history.seal)
        self.setup_model.edited.connect(self._edited)
        self.session_panel.edited.connect(partial(history.note, "the session", value="session"))
        self._follow_space(self.track, "track")
        does.in_space.triggered.connect(lambda on: self.settings.put("track_view", "space" if on else "projections"))

        does.pause.toggled.connect(self.scopes.pause.setChecked)
        self.scopes.pause.toggled.connect(does.pause.setChecked)
        self.scopes.pause.toggled.connect(self.track.set_paused)
        self.track.curves.level_set.connect(self.setup_model.assign)
        self.session_panel.folder_changed.connect(self.sessions.begin_new)
        self.session_panel.folder_changed.connect(self._look_at_disk)
        for changed in (self.session_panel.details_changed, self.control.session_changed):
            changed.connect(self._show_details)
        self.antennas.calibration.found.connect(self.sketch.show_drops)
        self.drops.change_asked.connect(lambda: self.panels.go_to("session"))
        self.drops.run_asked.connect(self.open_run)
        self.setup_model.changed.connect(self._show_setup)
        self.situation.changed.connect(self._show_situation)

        self.browser.compare_asked.connect(lambda _sessions: self.show_view("table"))
        self.run.view_asked.connect(self.show_view)
        self.browser.compare_asked.connect(self.series.show_beside)
        self.sessions.opened.connect(lambda: self.panels.bring_up("runs"))
        self.sessions.setup_taken.connect(lambda: self.panels.bring_up("hardware"))
        self.recovery.recovered.connect(lambda _runs: self.sessions.reread())
        self.closing.over.connect(self.close)
        self.later.computed.connect(self.sessions.reread)

        self.control.state_changed.connect(self._show_state)
        for panel in (self.scopes, self.planes, self.track):
            self.control.feed_changed.connect(panel.show_feed)
        self.control.session_changed.connect(self._show_session)
        self.control.failed.connect(self._say_at_field)
        self.control.warned.connect(lambda text, topic: self.board.post_of_setup("warning", text, topic=topic))
        for asks in (self.run.figures, self.strip):
            asks.field_asked.connect(self.go_to_field)
        self.runs.run_wanted.connect(lambda: self.panels.bring_up("run"))

    def _show_setup(self) -> None:
        self._show_actions()
        if self.setup_model.valid and not self.control.state.running:
            setup = self.setup_model.setup
            self.scopes.set_receivers(setup.n_receivers, setup.daq.range_v)
            self.planes.set_receivers(setup.n_receivers)
            if self.track.result is None:
                self.track.show_setup(setup)
        self._write_title()

    def _show_state(self) -> None:
        running = self.control.state.running
        for panel in (self.hardware, self.antennas, self.session_panel):
            panel.set_running(running)
        self._show_actions()
        self.keeping.look()
        if not running:
            self.health.show_health(None)
            self._look_at_disk()

    def _look_at_disk(self) -> None:
        """Ask the disk for its room away from the window: one that does not answer holds nothing up."""
        folder, daq = self.session_panel.data_folder, self.setup_model.setup.daq

        def show(free: int | None) -> None:
            if self.control.state.running or folder != self.session_panel.data_folder:
                return
            # as if nothing were compressed: rather warned too early
            per_s = 8.0 * 2 * self.setup_model.setup.n_receivers * daq.rate_hz
            self.bar.disk.show_room(free, None if free is None else max(0.0, free - MINIMUM_FREE_BYTES) / per_s)

        # no job: nobody who closes the window waits for it
        asks = threading.Thread(target=lambda: self.jobs.post(show, room_of(folder)), name="gui disk", daemon=True)
        asks.start()

    def _show_details(self) -> None:
        said, session = self.session_panel.details, self.control.session
        self.drops.show_session(said.operator, said.sample, said.target, session.path.name if session else "")

    def _chosen_source(self) -> tuple[SourceKind, str]:
        return self.hardware.kind, self.setup_model.setup.daq.device

    def _show_situation(self) -> None:
        now = self.situation.now
        self.bar.state.show_state(now.word, now.detail, now.role, now.badge)
        self.health.show_run(now.footer)
        self.bar.show_sounds(now.sound)
        self.runs.show_series(now.series)
        self._write_title()

    def _show_actions(self) -> None:
        state = self.control.state
        # a run that is recorded keeps the level that it was begun with
        may_move = (not state.running or state is AppState.LIVE) and not self.setup_model.reviewed
        self.track.curves.show_level(self.setup_model.value(LEVEL_KEY), movable=may_move)
        edits = {"undo": self.history.canUndo(), "redo": self.history.canRedo()}
        self.actions_.enable(state, valid=self.setup_model.valid, **edits)
        self.bar.runs.setEnabled(state.may_record)

    def _show_session(self) -> None:
        session = self.control.session
        path = session.path if session else None
        self.session_panel.show_session(path, read_only=bool(session and session.read_only))
        self.run_controller.show_session(session)
        if not self.control.state.running:
            # the last samples belong to the session before
            self.scopes.clear()
            self.planes.clear()
        self._write_title()

    def _edited(self, key: str, back: Callable[[], object], again: Callable[[], object]) -> None:
        # what is typed is one edit as long as it is typed, what is chosen each time
        typed = bool(key) and not words_of(key).choices and kind_of(key) != "boolean"
        self.history.note(called(key) if key else "the setup", back, again, key if typed else "")

    def _why_not(self, action: QAction) -> str:
        """Say why an action cannot be chosen now."""
        return self.opengl_answer if action is self.actions_.in_space else str(action.data() or "")

    def go_to_field(self, key: str) -> None:
        """Show the field of a value of the setup, and give it the keys."""
        panel = "antennas" if is_of_antenna(key) else "hardware"
        self.panels.go_to(panel)
        named = {one.objectName(): one for one in self.panels.held[panel].findChildren(QWidget)}
        # of a place in space the first coordinate
        if (field := named.get(key) or named.get(f"{key}[1]")) is not None:
            (self.antennas if panel == "antennas" else self.hardware).sections.reveal(field)
            field.setFocus(Qt.FocusReason.ShortcutFocusReason)

    def open_run(self, path: Path) -> None:
        """Analyse a run, also the one that is chosen already."""
        self.runs.table.clearSelection()
        self.runs.table.choose(lambda one: one.path == path)

    def show_view(self, name: str) -> None:
        """Show another view of the run or of the series, see `VIEWS`."""
        self.panels.bring_up("run")
        self.run.choose(name)

    def _track_of_runs(self) -> ResultTrack:
        """Return the track that stands among the views of a run."""
        made = ResultTrack(self.theme, self.setup_model.setup, self.jobs.start)
        made.use_space_view(self.actions_.in_space.isChecked())
        self._follow_space(made, "run")
        return made

    def _follow_space(self, track: TrackPanel, dock: str) -> None:
        """Let a track be shown in space where that is switched on."""
        self.panels.docks[dock].topLevelChanged.connect(lambda _off: QTimer.singleShot(0, track.renew_space_view))
        self.actions_.in_space.toggled.connect(track.use_space_view)

    def find_sessions(self) -> None:
        """Let the operator search what was recorded before."""
        self.panels.go_to("browser")
        self.browser.refresh()

    def write_mark(self) -> None:
        """Let the operator type a note of this moment."""
        self.panels.bring_up("session")
        self.session_panel.mark.setFocus()

    def _opengl_answered(self, usable: bool, good: bool, words: str) -> None:
        self.opengl_answer = words
        self.actions_.in_space.setEnabled(usable)
        chosen = self.settings.text("track_view", "space" if good else "projections")
        if usable and chosen == "space":
            self.actions_.in_space.setChecked(True)

    def open_help(self) -> None:
        """Show the help, opened at the page of what has the keys."""
        pages = resource_table("window/guide")["help"]
        show_help(self, self.settings, pages.get(self.panels.with_keys, ""))

    def show_about(self) -> None:
        """Show the facts about the program."""
        opengl, folder = self.opengl_answer or "not tested", self.session_panel.data_folder
        About(opengl, folder, self.setup_model.path, self).exec()

    def _write_title(self) -> None:
        path, session = self.setup_model.path, self.control.session
        changed = "*" if self.setup_model.modified else ""
        where, now = f"session {session.path.name}" if session else "", self.situation.now
        name = f"setup of {self.setup_model.reviewed}" if self.setup_model.reviewed else "setup"
        parts = (f"{path.name if path else name}{changed}", where, now.badge, now.title)
        self.setWindowTitle(" · ".join(filter(None, parts)))  # Qt adds the program's name

    def unfinished(self) -> tuple[str, ...]:
        """Return what has to end before the window can close, in words."""
        probe = "the test of OpenGL" if self._probe is not None and self._probe.busy else ""
        return tuple(filter(None, (self.control.unfinished, *self.jobs.running, probe)))

    def closeEvent(self, event: QCloseEvent) -> None:  # noqa: N802 - Qt's name
        """Ask everything to end and close once it has; asks the operator only while a run is recorded."""
        event.setAccepted(self._left)
        if self._left or self.closing.active:
            return
        if not self.closing.isVisible():
            asks = self.control.state is AppState.RECORDING or bool(self.setup_model.error)
            if asks and not self.may_leave():
                return
            self._begin_to_close()
        if self.closing.active:
            return
        self._left = True
        for end in (
            self.jobs.rest,
            self.sessions.leave_folder,
            self.log.end,
            self.history.clear,
            self._timer.stop,
            self._remember,
            event.accept,
        ):
            end()

    def leave(self) -> None:
        """Close as the system wants it: the run that is being recorded is kept, and nobody is asked."""
        self._asks = False
        self.close()
        if self.closing.active:
            self.closing.leave_now()

    def may_leave(self) -> bool:
        """Ask whether to leave although a run is being recorded, or an edit would be lost."""
        if not self._asks:
            return True
        words = f"This edit of the setup cannot be kept: {self.setup_model.error} Leave all the same?"
        if self.control.state is AppState.RECORDING:
            words = "A run is being recorded. Stop it, keep what is there, and leave?"
        button = QMessageBox.StandardButton
        # whoever presses Enter without reading loses nothing
        return QMessageBox.question(self, "RadarGUI", words, button.Yes | button.No, button.No) == button.Yes

    def _begin_to_close(self) -> None:
        self.sessions.flush()
        self.work.cancel()
        self.transfer.close()
        self.control.end(Asked.FINISH)
        if self._probe is not None:
            self._probe.close()
        if self.unfinished():
            for part in (self.menuBar(), self.bar, self.panels):
                part.setEnabled(False)
            self.closing.begin()

    def _remember(self) -> None:
        """Keep size, layout and what the operator typed."""
        put = self.settings.put
        put("geometry", self.saveGeometry())
        self.panels.remember(self.settings)
        self.settings.keep_sizes(self)
        put("operator", self.session_panel.details.operator)
        put("data_folder", self.session_panel.data_folder)
        put("runs", self.bar.runs.value())
        put("scope_window_s", self.scopes.window_s)
        if self.hardware.replay.file.path is not None:
            put("replay_file", self.hardware.replay.file.path)
        self.setup_file.remember()
        self.settings.sync()


def room_of(folder: Path) -> int | None:
    """Return the free bytes where a folder is, or will be made."""
    return free_bytes(next((one for one in (folder, *folder.parents) if one.is_dir()), folder))
