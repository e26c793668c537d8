"""Sounds for who stands at the tracer: patterns of the system's own beep for trigger, result and fault."""

from __future__ import annotations

from PySide6.QtCore import QObject, QTimer
from PySide6.QtWidgets import QApplication

from radargui.gui.control.run_control import RunControl
from radargui.gui.control.state import AppState
from radargui.gui.panels import Actions
from radargui.gui.settings import Settings

_STEP_MS = 220
"""Two sounds that are heard as two (chosen by ear)."""
PATTERNS_MS = {
    "result": (0,),
    "rejected": (0, _STEP_MS),
    "trigger": (0, _STEP_MS, 2 * _STEP_MS),
    "fault": (0, _STEP_MS, 2 * _STEP_MS, 5 * _STEP_MS, 6 * _STEP_MS, 7 * _STEP_MS),
}
"""When each beep comes: told apart by counting, also where the system's sound cannot be changed."""
_SWITCHES = {"result": ("sound", "on"), "trigger": ("sound_trigger", "off"), "fault": ("sound_fault", "on")}
"""Action and setting of each, and what holds at the first start."""


class Sounds(QObject):
    """Plays a pattern where its switch is on; the switches are remembered."""

    def __init__(self, control: RunControl, does: Actions, settings: Settings, parent: QObject) -> None:
        super().__init__(parent)
        self._control, self._state = control, control.state
        self._switches = {name: getattr(does, key) for name, (key, _) in _SWITCHES.items()}
        self._switches["rejected"] = self._switches["result"]
        for name, (key, at_first) in _SWITCHES.items():
            self._switches[name].setChecked(settings.text(key, at_first) == "on")
            self._switches[name].toggled.connect(lambda on, key=key: settings.put(key, "on" if on else "off"))
        control.state_changed.connect(self._follow)
        control.failed.connect(self._failed)
        control.warned.connect(self._warned)

    def play(self, name: str) -> None:
        """Play the pattern of `trigger`, `result`, `rejected` or `fault`."""
        if self._switches[name].isChecked():
            for after_ms in PATTERNS_MS[name]:
                QTimer.singleShot(after_ms, self, QApplication.beep)

    def _follow(self) -> None:
        before, self._state = self._state, self._control.state
        # the window looks 30 times a second: a very short run may be over its motion by then
        recorded = (AppState.RECORDING, AppState.SETTLING)
        if self._state in recorded and before not in recorded:
            self.play("trigger")

    def _failed(self, _error: BaseException) -> None:
        self.play("fault")

    def _warned(self, _words: str, topic: str) -> None:
        # a device that was started again left a gap in the run; other warnings can wait for the eye
        if topic == "restart":
            self.play("fault")
