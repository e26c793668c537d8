"""The guided dialog: recordings, unknowns, the fit with its progress, and what to do with what it found."""

from collections.abc import Callable, Iterable
from datetime import datetime
from functools import cached_property
from pathlib import Path

from PySide6.QtWidgets import QFileDialog, QHBoxLayout, QStackedWidget, QVBoxLayout

from radargui.experiment.calibrating import Calibrate, CalibrationOrder, free_path, write_calibration
from radargui.experiment.event import RecordedRun
from radargui.gui.background import OneAtATime, WorkStrip
from radargui.gui.calibration.pages import Recorded, RecordingList, ResultView, UnknownsForm
from radargui.gui.dialog import Dialog
from radargui.gui.layout import TIPS, FaultText, PlainLabel, boxed, button, fill, having, holding
from radargui.gui.notices import NoticeBoard
from radargui.gui.services import Services
from radargui.gui.sessions.session_controller import SessionController
from radargui.gui.setup.antenna_panel import CalibrationGroup
from radargui.gui.setup.session_panel import SessionPanel
from radargui.gui.setup.setup_model import SetupModel, tried
from radargui.gui.theme import scaled_font
from radargui.model.calibrated_setup import calibrated, too_old
from radargui.model.calibration import Calibration, read_calibration
from radargui.model.errors import RadarGuiError
from radargui.model.setup import Setup
from radargui.model.words import counted, sentence
from radargui.processing.calibration_check import CalibrationCheck, check_calibration
from radargui.session.known_setup import calibration_of_runs
from radargui.session.session import Session

STEPS = ("1 of 4: recordings", "2 of 4: what is unknown", "3 of 4: calibrating", "4 of 4: result")
_RECORDINGS, _UNKNOWNS, _FIT, _RESULT = range(4)  # pages, in the order of STEPS
_TITLE = 1.3
"""Times the font of the window (chosen by hand)."""
_FILES = "Calibrations (*.json);;All files (*)"


class CalibrationDialog(Dialog):
    """Leads through a calibration; nothing is changed before the result is used.

    Parameters
    ----------
    model
        The setup that is calibrated.
    calibrate
        The fit.
    panel
        Says where a calibration is kept while the setup has no file of the operator's own, and who calibrates.
    """

    def __init__(self, model: SetupModel, calibrate: Calibrate, panel: SessionPanel, services: Services) -> None:
        super().__init__("Calibrate the antennas", (1060, 640), services.parent, "calibration", services.settings)
        self._model, self.calibrate, self._panel, self._services = model, calibrate, panel, services
        self.found: Calibration | None = None
        self._order: CalibrationOrder | None = None
        self.step, self.fault = PlainLabel(selectable=False), FaultText()
        self.step.setFont(scaled_font(self.font(), _TITLE, bold=True))
        self.recordings = RecordingList(lambda: panel.data_folder)
        self.unknowns, self.view = UnknownsForm(), ResultView(services.theme)
        self.work, self.doing = WorkStrip(services.jobs), PlainLabel()
        fit = boxed(QVBoxLayout(), self.doing, self.work, 1, spacing=6)
        self.pages = holding(QStackedWidget(), self.recordings, self.unknowns, fit, self.view)
        back = {_UNKNOWNS: _RECORDINGS, _RESULT: _UNKNOWNS}
        self.back = button("Back", lambda: self._go(back[self.pages.currentIndex()]))
        self.next = button("Next", self._next, default=True)
        self.use = button("Use in the setup", self._use)
        self.save = button("Save as…", self._ask_save)
        self.compare = button("Compare with an older one…", self._ask_older)
        self.discard = button("Discard", self.reject)
        ends = (self.back, self.next, self.use, self.save, self.compare, 1, self.discard)
        self.lay_out(self.step, (self.pages, 1), self.fault, fill(QHBoxLayout(), *ends, spacing=6))
        for changed in (self.recordings.changed, self.unknowns.changed):
            changed.connect(self._show)
        self._go(_RECORDINGS)

    def begin(self, files: Iterable[Path] = ()) -> None:
        """Come up at the first step with some drops; one that calibrates already stays as it is."""
        if not self.work.busy:
            self.found = None
            self.recordings.show_recordings(map(Recorded, files))
            self._go(_RECORDINGS)
        self.come_up()

    def done(self, result: int) -> None:
        """Cancel what is under way, and close."""
        self.work.cancel()
        super().done(result)

    def _next(self) -> None:
        if self.pages.currentIndex() == _RECORDINGS:
            self.unknowns.show_setup(self._model.setup)
            self._go(_UNKNOWNS)
            return
        if not self._model.valid:
            self.fault.say(self._model.error)
            return
        files, known = zip(*((one.file, one.known) for one in self.recordings.table.rows.entries), strict=True)
        operator = self._panel.details.operator
        order = CalibrationOrder(files, known, self._model.setup, self.unknowns.free, operator)
        self._order, calibrate = order, self.calibrate
        count = counted(len(files), "recording")
        self.doing.setText(f"{count}, together. The window can be used meanwhile.")
        self._go(_FIT)
        self.work.start(
            "calibrating",
            lambda task: calibrate(order, task.report),
            self._show_found,
            self._failed,
            lambda: self._stopped("Cancelled; nothing was changed."),
        )

    def _show_found(self, found: Calibration) -> None:
        self.found = found
        self.view.show_calibration(found)
        self._go(_RESULT)

    def _failed(self, error: BaseException) -> None:
        self._stopped(str(error))
        if not isinstance(error, RadarGuiError):
            self._services.board.post_error(error)

    def _stopped(self, words: str) -> None:
        self._go(_UNKNOWNS)
        self.fault.say(words)

    def _go(self, page: int) -> None:
        self.pages.setCurrentIndex(page)
        self.step.setText(f"Step {STEPS[page]}")
        self.fault.say("")
        self._show()

    def _show(self) -> None:
        page = self.pages.currentIndex()
        for one in (self.use, self.save, self.compare):
            one.setVisible(page == _RESULT)
        having(self.next, visible=page in (_RECORDINGS, _UNKNOWNS), text="Calibrate" if page == _UNKNOWNS else "Next")
        goes = bool(self.unknowns.free if page == _UNKNOWNS else self.recordings.table.rows.entries)
        missing = "Check what is unknown" if page == _UNKNOWNS else "Add recordings, or open a session with drops"
        having(self.next, enabled=goes, toolTip=TIPS["buttons"]["Next"] if goes else f"{missing} first")
        self.back.setVisible(page in (_UNKNOWNS, _RESULT))
        refused = self.found is not None and self.found.verdict == "refused"
        self.use.setEnabled(self.found is not None and not refused)
        self.discard.setText("Discard" if page == _RESULT else "Close")

    def _use(self) -> None:
        """Keep the calibration as a file of its own, older ones beside it, and take it into the setup."""
        found, order, model = self.found, self._order, self._model
        if found is None or order is None:
            return
        if model.setup != order.setup:
            self.fault.say("The setup was changed since the calibration began: go back and calibrate it again.")
            return
        if self._tried(lambda: keep_calibration(model, self._panel, found, self._services.board)):
            self.accept()

    def _ask_save(self) -> None:
        found = self.found
        if found is None:
            return
        start = free_path(own_folder(self._model, self._panel), found.origin.made_at)
        name, _ = QFileDialog.getSaveFileName(self, "Save calibration", str(start), _FILES)
        # whether to write over a file that is there the operator has just been asked
        if name and self._tried(lambda: write_calibration(Path(name), found, force=True)):
            self._services.board.post("info", f"The calibration is saved in {name}.")

    def _ask_older(self) -> None:
        name, _ = QFileDialog.getOpenFileName(
            self, "Older calibration", str(own_folder(self._model, self._panel)), _FILES
        )
        if name and self.found is not None:
            found = self.found
            self._tried(lambda: self.view.show_older(Path(name).name, read_calibration(Path(name)), found))

    def _tried(self, step: Callable[[], None]) -> bool:
        self.fault.say("")
        return tried(step, lambda error: self.fault.say(str(error)))


def own_folder(model: SetupModel, panel: SessionPanel) -> Path:
    """Return where calibrations are kept: beside the setup's file, else in the folder of the sessions."""
    return panel.data_folder if model.path is None or model.shipped else model.path.parent


def keep_calibration(model: SetupModel, panel: SessionPanel, found: Calibration, board: NoticeBoard) -> None:
    """Write a calibration beside older ones, and take it into the setup, where it can be undone.

    Raises
    ------
    FileError, SetupError
        It cannot be written, or no setup can have its values.
    """
    path = free_path(own_folder(model, panel), found.origin.made_at)
    setup = calibrated(model.setup, found, path)
    write_calibration(path, found)
    model.replace(setup)
    board.post("info", f"Calibrated: {path.name} is kept. Save the setup to keep its values.")


class CalibrationController:
    """Joins dialog, antenna panel, session browser and the runs that are recorded."""

    def __init__(self, sessions: SessionController, group: CalibrationGroup, calibrate: Calibrate) -> None:
        self.group, self.calibrate = group, calibrate
        self.runs = sessions.runs
        self.panel, self.model, self.services = sessions.panel, sessions.setup_file.model, sessions.services
        sessions.browser.calibrate_asked.connect(self.begin_with)
        self.services.control.run_recorded.connect(self._recorded)
        self._found: tuple[Calibration, Setup] | None = None
        self._reading = OneAtATime(self.services.jobs, "what the drops say of the antennas", self.look)
        group.taken.connect(self.take_over)
        self.runs.model.altered.connect(self.look)

    @cached_property
    def dialog(self) -> CalibrationDialog:
        """Made when it is first wanted: the window starts sooner without it."""
        return CalibrationDialog(self.model, self.calibrate, self.panel, self.services)

    def begin(self) -> None:
        """Calibrate from the runs of the session that is open, or from what the operator adds."""
        self.dialog.begin(self.runs.counting)

    def begin_with(self, session: Path) -> None:
        """Ask what the drops of a session say about the antennas."""
        jobs = self.services.jobs
        jobs.start("the runs of a session", lambda: Session.open(session, write=False).run_paths(), self.dialog.begin)

    def look(self) -> None:
        """Show what the drops of the session that is open say of the antennas that the setup states."""
        runs, setup, operator = self.runs.counting, self.model.setup, self.panel.details.operator
        made_at = datetime.now().astimezone().isoformat(timespec="seconds")
        self._reading.start(
            lambda: calibration_of_runs(runs, setup, made_at, operator),
            lambda found: self._show(found, setup),
            lambda _error: self._show(None, setup),
        )

    def _show(self, found: Calibration | None, setup: Setup) -> None:
        self._found = None if found is None else (found, setup)
        self.group.show_drops(found)

    def take_over(self) -> None:
        """Write what the drops say into the setup, and keep it as a file of its own, older ones beside it."""
        if self._found is None:
            return
        found, setup = self._found
        if self.model.setup != setup:
            self.group.fault.say("The setup was changed since the drops were looked at.")
            self.look()
            return
        keep_calibration(self.model, self.panel, found, self.services.board)

    def warn(self) -> None:
        """Say that the calibration is too old; called before runs are recorded."""
        if words := too_old(self.model.setup, datetime.now().astimezone()):
            self.services.board.post_once("warning", sentence(words))

    def _recorded(self, run: RecordedRun) -> None:
        """Let the first drop of a series say whether the calibration still holds."""
        result, is_first = run.result, self.services.control.kept == 1 and not run.set_aside
        if result is not None and result.setup.calibration.content and is_first:
            self.services.jobs.start("the check of the calibration", lambda: check_calibration(result), self._checked)

    def _checked(self, check: CalibrationCheck | None) -> None:
        self.group.checked.say("" if check is None else f"Last check: {check.words}")
        if check is not None:
            self.services.board.post("info" if check.holds else "warning", sentence(check.words))
