"""What stands of the calibration beside the antennas."""

from datetime import datetime

from PySide6.QtCore import Signal

from radargui.gui.layout import FaultText, Group, PlainLabel, button, follow
from radargui.gui.setup.setup_model import SetupModel
from radargui.gui.setup.words import in_words
from radargui.model.calibrated_setup import calibration_words, edited_since, too_old
from radargui.processing.calibration_check import CalibrationCheck


class CalibrationGroup(Group):
    """Beside the antennas: which calibration they have, what is wrong with it, and the way to another."""

    asked = Signal()

    def __init__(self, model: SetupModel) -> None:
        super().__init__("Calibration")
        self._model = model
        self.words, self.checked, self.fault = PlainLabel(), PlainLabel(), FaultText()
        self.begin = button("Calibrate the antennas…", self.asked, "From drops, or a known motion (Shift+F7)")
        for part in (self.words, self.fault, self.checked, self.begin):
            self.whole(part)
        self.checked.hide()
        follow(model.changed, self.refresh)

    def refresh(self) -> None:
        """Show what holds for the setup now."""
        setup = self._model.setup
        words = calibration_words(setup) or "none: angles and distances as measured by hand"
        self.words.setText(f"{words[0].upper()}{words[1:]}")
        faults = filter(None, (too_old(setup, datetime.now().astimezone()), in_words(edited_since(setup))))
        self.fault.say(". ".join(f"{one[0].upper()}{one[1:]}" for one in faults))

    def show_check(self, check: CalibrationCheck | None) -> None:
        """Show what the last first drop said."""
        self.checked.setText("" if check is None else f"Last check: {check.words}")
        self.checked.setVisible(check is not None)
