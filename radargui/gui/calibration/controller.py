"""What leads to a calibration, and what is said of the one in use: its age, edits, and what the next drop says."""

from dataclasses import dataclass
from datetime import datetime
from functools import cached_property
from pathlib import Path

from PySide6.QtCore import QObject

from radargui.experiment.calibrating import Calibrate
from radargui.experiment.event import RecordedRun
from radargui.gui.calibration.dialog import CalibrationDialog
from radargui.gui.control.run_control import RunControl
from radargui.gui.services import Services
from radargui.gui.sessions.browser import SessionBrowser
from radargui.gui.setup.antenna_panel import CalibrationGroup
from radargui.gui.setup.session_panel import SessionPanel
from radargui.gui.setup.setup_model import SetupModel
from radargui.model.calibrated_setup import too_old
from radargui.processing.calibration_check import CalibrationCheck, check_calibration
from radargui.session.session import Session


@dataclass(eq=False, repr=False)
class CalibrationController(QObject):
    """Joins dialog, antenna panel, session browser and the runs that are recorded."""

    control: RunControl
    model: SetupModel
    panel: SessionPanel
    browser: SessionBrowser
    group: CalibrationGroup
    calibrate: Calibrate
    services: Services

    def __post_init__(self) -> None:
        super().__init__(self.services.parent)
        self.group.asked.connect(self.begin)
        self.browser.calibrate_asked.connect(self.begin_with)
        self.control.run_recorded.connect(self._recorded)

    @cached_property
    def dialog(self) -> CalibrationDialog:
        """Made when it is first wanted: the window starts sooner without it."""
        panel = self.panel
        made = CalibrationDialog(
            self.model, self.calibrate, lambda: panel.data_folder, lambda: panel.details.operator, self.services
        )
        self.services.settings.restore_sizes(made)
        return made

    def begin(self) -> None:
        """Calibrate from the runs of the session that is open, or from what the operator adds."""
        session = self.control.session
        self.dialog.begin(() if session is None else session.run_paths())

    def begin_with(self, session: Path) -> None:
        """Ask what the drops of a session say about the antennas."""
        jobs = self.services.jobs
        jobs.start("the runs of a session", lambda: Session.open(session, write=False).run_paths(), self.dialog.begin)

    def warn(self) -> None:
        """Say that the calibration is too old; called before runs are recorded."""
        if words := too_old(self.model.setup, datetime.now().astimezone()):
            self.services.board.post_once("warning", f"{words[0].upper()}{words[1:]}.")

    def _recorded(self, run: RecordedRun) -> None:
        """Let the first drop of a series say whether the calibration still holds."""
        result = run.result
        if result is not None and result.setup.calibration.content and self.control.kept == 1 and not run.set_aside:
            self.services.jobs.start("the check of the calibration", lambda: check_calibration(result), self._checked)

    def _checked(self, check: CalibrationCheck | None) -> None:
        self.group.show_check(check)
        if check is not None:
            words = f"{check.words[0].upper()}{check.words[1:]}."
            self.services.board.post("info" if check.holds else "warning", words)
