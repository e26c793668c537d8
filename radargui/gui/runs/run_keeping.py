"""What happens when a run is done, and the one key that rejects it and takes it back."""

from pathlib import Path

from PySide6.QtCore import QObject, QTimer
from PySide6.QtWidgets import QApplication

from radargui.experiment.event import RecordedRun
from radargui.gui.control.banner import RunWords
from radargui.gui.control.health_line import HealthLine
from radargui.gui.control.run_control import RunControl
from radargui.gui.menus import Actions
from radargui.gui.runs.run_controller import RunController
from radargui.gui.runs.run_list_panel import RunListPanel
from radargui.gui.runs.run_model import RunEntry
from radargui.gui.services import Services
from radargui.session.session import BY_OPERATOR

_BETWEEN_SOUNDS_MS = 220
"""Two sounds that are heard as two (chosen by ear)."""


class RunKeeping(QObject):
    """Joins the recorded runs with list, sound, health line and the key.

    Attributes
    ----------
    last_result
        The newest result as the banner says it: which run, what it gave; empty where there is none yet.
    """

    def __init__(
        self,
        control: RunControl,
        runs: RunListPanel,
        controller: RunController,
        health: HealthLine,
        does: Actions,
        services: Services,
    ) -> None:
        super().__init__(services.parent)
        self._control, self._runs, self._controller, self._health = control, runs, controller, health
        self._settings, self._board, self._jobs = services.settings, services.board, services.jobs
        self.last_result = ""
        self._of_result: Path | None = None
        self._heard: set[Path] = set()
        self._sound = does.sound
        does.sound.setChecked(self._settings.text("sound", "on") == "on")
        does.sound.toggled.connect(lambda on: self._settings.put("sound", "on" if on else "off"))
        does.reject.triggered.connect(self.toggle)
        does.show_rejected.setChecked(self._settings.text("show_rejected", "no") == "yes")
        runs.set_show_rejected(does.show_rejected.isChecked())
        does.show_rejected.toggled.connect(self._switch_rejected)
        runs.show_rejected_toggled.connect(does.show_rejected.setChecked)
        control.run_preliminary.connect(self._preliminary)
        control.run_recorded.connect(self._recorded)
        control.run_taken.connect(controller.take)
        control.session_changed.connect(self._forget)

    @property
    def words(self) -> RunWords:
        """What the banner calls the runs; its news are a number and what belongs to it, never of two runs as of one."""
        model, backlog, news = self._runs.model, self._control.backlog, self.last_result
        coming = f"replay {model.n_replays + 1}" if self._control.kind == "replay" else f"drop {model.n_drops + 1}"
        computed, last = (model.entry_of(path) for path in (backlog.computed, backlog.last_recorded))
        if last is not None and last.path != self._of_result:
            news = "; ".join(filter(None, (f"{last.called} recorded", news)))
        return RunWords(coming, computed.called if computed else "", news)

    def _forget(self) -> None:
        self._health.show_run("")
        self.last_result = ""
        self._of_result = None

    def toggle(self) -> None:
        """Reject the chosen run, or the last one; take it back where it was rejected already."""
        entry = self._runs.chosen or self._runs.model.last_kept
        if entry is None:
            self._board.post("warning", "There is no run to reject.")
            return
        back = bool(entry.rejected)
        self._jobs.start(
            "taking a run back" if back else "rejecting a run",
            lambda: self._control.reject(entry.path, back=back),
            lambda _done: self._toggled(entry, back),
        )

    def _toggled(self, entry: RunEntry, back: bool) -> None:
        self._runs.reject(entry.path, "" if back else BY_OPERATOR)
        if back:
            self._board.post("info", f"{entry.name} counts again.")
        else:
            self._beep(twice=True)
            self._board.post("info", f"{entry.name} is rejected: kept, not counted. The same key (Del) takes it back.")

    def _preliminary(self, recorded: RecordedRun) -> None:
        """Show what stands while the joint correction is computed; the operator can go on, and hears so."""
        self._controller.add(recorded)
        if recorded.path is not None:
            self._heard.add(recorded.path)
        self._beep()
        self._say(recorded)

    def _recorded(self, recorded: RecordedRun) -> None:
        self._controller.add(recorded)
        if recorded.path is None:
            return
        self._health.show_run(f"{recorded.path.stem}: {recorded.health_line}" if recorded.health_line else "")
        if recorded.set_aside:
            self._beep(twice=True)
            return
        if recorded.path not in self._heard:
            self._beep()
        self._heard.discard(recorded.path)
        self._say(recorded)

    def _say(self, recorded: RecordedRun) -> None:
        if recorded.path is None:
            return
        entry = self._runs.model.entry_of(recorded.path)
        if entry is None:
            return
        self._of_result = recorded.path
        known = (entry.summary or {}).get("e") is not None
        preliminary = ", preliminary" if recorded.result is not None and recorded.result.preliminary else ""
        said = f"e = {entry.restitution()}{preliminary}" if known else f"no e, {entry.verdict}"
        self.last_result = f"{entry.called}: {said}"

    def _beep(self, *, twice: bool = False) -> None:
        """Make the system's own sound, for who stands at the tracer: once a run is done, twice it was rejected."""
        if self._sound.isChecked():
            QApplication.beep()
            if twice:
                QTimer.singleShot(_BETWEEN_SOUNDS_MS, self, QApplication.beep)

    def _switch_rejected(self, shown: bool) -> None:
        self._runs.set_show_rejected(shown)
        self._settings.put("show_rejected", "yes" if shown else "no")
