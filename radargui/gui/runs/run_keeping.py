"""What happens when a run is done, and the one key that rejects it and takes it back."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject

from radargui.experiment.recorded_run import RecordedRun
from radargui.gui.control.sounds import Sounds
from radargui.gui.runs.run_model import RunEntry

if TYPE_CHECKING:
    from radargui.gui.main_window import MainWindow


class RunKeeping(QObject):
    """Joins the recorded runs with list, sound, health line and the key.

    Attributes
    ----------
    last_run
        What the last run gave, in a few words.
    """

    def __init__(self, window: MainWindow) -> None:
        super().__init__(window)
        self._window = window
        self.last_run = ""
        self._heard: set[Path] = set()
        self.sounds = Sounds(self)
        does, settings = window.actions_, window.settings
        self.sounds.on = settings.text("sound", "on") == "on"
        does.sound.setChecked(self.sounds.on)
        does.sound.toggled.connect(self._switch_sound)
        does.reject.triggered.connect(self.toggle)
        does.show_rejected.setChecked(settings.text("show_rejected", "no") == "yes")
        window.runs.set_show_rejected(does.show_rejected.isChecked())
        does.show_rejected.toggled.connect(self._switch_rejected)
        window.runs.show_rejected_toggled.connect(does.show_rejected.setChecked)
        window.control.run_preliminary.connect(self._preliminary)
        window.control.run_recorded.connect(self._recorded)
        window.control.session_changed.connect(lambda: window.health.show_run(""))

    def toggle(self) -> None:
        """Reject the chosen run, or the last one; take it back where it was rejected already."""
        window = self._window
        entry = window.runs.chosen or window.runs.model.last_kept
        if entry is None:
            window.board.post("warning", "There is no run to reject.")
            return
        back = bool(entry.rejected)
        window.jobs.start(
            "taking a run back" if back else "rejecting a run",
            lambda: window.control.reject(entry.path, back=back),
            lambda _done: self._toggled(entry, back),
            window.board.post_error,
        )

    def _toggled(self, entry: RunEntry, back: bool) -> None:
        runs, board = self._window.runs, self._window.board
        runs.reject(entry.path, "" if back else "by the operator")
        if back:
            board.post("info", f"{entry.name} counts again.")
        else:
            self.sounds.rejected()
            board.post("info", f"{entry.name} is rejected: kept, but not counted. The same key (Del) takes it back.")

    def _preliminary(self, recorded: RecordedRun) -> None:
        """Show what stands while the joint correction is computed; the operator can go on, and hears so."""
        window = self._window
        window.run_desk.add(recorded)
        if recorded.path is not None:
            self._heard.add(recorded.path)
        self.sounds.done()
        self._say(recorded)

    def _recorded(self, recorded: RecordedRun) -> None:
        window = self._window
        window.run_desk.add(recorded)
        if recorded.path is None:
            return
        window.health.show_run(f"{recorded.path.stem}: {recorded.health_line}" if recorded.health_line else "")
        if recorded.set_aside:
            self.sounds.rejected()
            return
        if recorded.path not in self._heard:
            self.sounds.done()
        self._heard.discard(recorded.path)
        self._say(recorded)

    def _say(self, recorded: RecordedRun) -> None:
        if recorded.path is None or recorded.result is None:
            self.last_run = "not processed"
            return
        entry = self._window.runs.model.entry_of(recorded.path)
        if entry is not None:
            known = (entry.summary or {}).get("e") is not None
            preliminary = ", preliminary" if recorded.result.preliminary else ""
            self.last_run = f"e = {entry.restitution()}{preliminary}" if known else entry.verdict

    def _switch_sound(self, on: bool) -> None:
        self.sounds.on = on
        self._window.settings.put("sound", "on" if on else "off")

    def _switch_rejected(self, shown: bool) -> None:
        self._window.runs.set_show_rejected(shown)
        self._window.settings.put("show_rejected", "yes" if shown else "no")
