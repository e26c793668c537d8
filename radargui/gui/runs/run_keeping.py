"""What happens when a run is done, and the one key that rejects it and takes it back."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from functools import partial
from pathlib import Path

from PySide6.QtCore import QObject, QTimer, Signal
from PySide6.QtWidgets import QApplication, QInputDialog

from radargui.experiment.event import RecordedRun
from radargui.gui.control.state import AppState
from radargui.gui.control.waiting import StoppingStrip
from radargui.gui.layout import follow, having
from radargui.gui.notices import Notice
from radargui.gui.panels import Actions
from radargui.gui.runs.run_controller import RunController
from radargui.gui.runs.run_model import RunEntry
from radargui.gui.runs.situation import SituationModel
from radargui.gui.services import Services
from radargui.gui.setup_words import in_words
from radargui.session.session import BY_OPERATOR, reason_of

REASONS = ("touched something on its way", "released badly", "not the first bounce", "wrong sample")
"""That are offered; others can be typed."""


@dataclass(eq=False, repr=False)
class RunKeeping(QObject):
    """Joins the recorded runs with the list, what is said of them, the sounds and the key.

    Parameters
    ----------
    situation
        What is shown of them.
    stopping
        Where it is said what is waited for.
    """

    controller: RunController
    situation: SituationModel
    stopping: StoppingStrip
    does: Actions
    services: Services

    def __post_init__(self) -> None:
        super().__init__(self.services.parent)
        self.control = control = self.services.control
        self.runs, does, put = self.controller.runs, self.does, self.services.settings.put
        self._heard: set[Path] = set()
        self._said = ""
        self.sounds = Sounds(does, self.services, self)
        follow(self.sounds.changed, self._show_sounds)
        does.show_rejected.setChecked(self.services.settings.text("show_rejected", "no") == "yes")
        does.show_rejected.toggled.connect(lambda on: put("show_rejected", "yes" if on else "no"))
        control.run_preliminary.connect(self._preliminary)
        control.run_recorded.connect(self._recorded)
        control.run_taken.connect(self.controller.take)
        control.failed.connect(self._fail)
        self.services.board.changed.connect(self.look)

    def _show_sounds(self) -> None:
        self.situation.sound = self.sounds.words
        self.situation.look()

    def look(self) -> None:
        """Say what is being done now."""
        self._warn_if_hardly_seen()
        self.situation.look()
        entry = self.runs.model.entry_of(self.control.backlog.computed)
        self.stopping.look(entry.called if entry else "")

    def _warn_if_hardly_seen(self) -> None:
        """Say while it is armed why a fall may not start the run, once as long as it is so."""
        control, said, board = self.control, self.situation.hardly_seen, self.services.board
        health = control.health if control.state is AppState.ARMED else None
        objection = health.hardly_seen if health is not None else ""
        why = in_words(objection)
        if bool(why) == bool(said):
            return
        # before the board: it asks for a look
        self.situation.hardly_seen = why
        if why:
            board.post_of_setup("warning", objection)
        else:
            board.dismiss(Notice("warning", said))

    def _fail(self, error: BaseException) -> None:
        self.services.board.post_error(error)
        # the newest error stands first
        self.situation.fail(self.services.board.notices[0].text)

    def toggle(self) -> None:
        """Reject the chosen runs, or the last one; take them back where all were rejected already."""
        if entries := self._wanted("There is no run to reject."):
            counted = [one for one in entries if not one.rejected]
            self._set_aside(counted or entries, BY_OPERATOR, back=not counted)

    def exclude(self) -> None:
        """Reject the chosen runs, or the last one, with a reason that report and window show."""
        # what was no drop has its reason
        if entries := [one for one in self._wanted("There is no run to reject.") if one.is_drop]:
            said = self.ask_words("Reject with a reason", f"Why does {_named(entries)} not count?", REASONS)
            if said:
                self._set_aside(entries, reason_of(said), back=False)

    def note(self) -> None:
        """Keep a note about the chosen runs, or the last one, in the session's journal."""
        session, entries = self.control.session, self._wanted("There is no run to note anything about.")
        said = self.ask_words("Note", f"What is worth knowing about {_named(entries)}?", ()) if entries else ""
        if session is None or not said:
            return
        now = datetime.now().astimezone()

        def work() -> None:
            for entry in entries:
                session.mark(said, now=now, about=entry.path)

        def show(_done: object) -> None:
            for entry in entries:
                if session is self.control.session:
                    self.runs.change(entry.path, note=session.info.notes_of(entry.path.name))

        self.services.jobs.start("a note", work, show)

    def ask_words(self, title: str, question: str, choices: Sequence[str]) -> str:
        """Let the operator type, or choose; empty: not said, nothing happens."""
        ask = having(QInputDialog(self.services.parent), windowTitle=title, labelText=question)
        if choices:
            having(ask, comboBoxItems=list(choices), comboBoxEditable=True)
        return ask.textValue().strip() if ask.exec() else ""

    def _wanted(self, otherwise: str) -> list[RunEntry]:
        """Return the chosen runs, else the last one; none: it is said that there is none."""
        entries = self.runs.table.all_chosen or [one for one in self.runs.model.entries if not one.rejected][-1:]
        if not entries:
            self.services.board.post("warning", otherwise)
        return entries

    def _set_aside(self, entries: Sequence[RunEntry], reason: str, *, back: bool) -> None:
        session, before = self.control.session, [one.rejected or "" for one in entries]

        def put(reasons: Sequence[str]) -> None:
            if session is self.control.session:
                self._put_aside(entries, reasons)

        after = ["" if back else reason] * len(entries)
        self.services.history.note(f"whether {_named(entries)} counts", partial(put, before), partial(put, after))
        put(after)

    def _put_aside(self, entries: Sequence[RunEntry], reasons: Sequence[str]) -> None:
        """Set runs aside, each for its reason; without one it counts again."""
        back = not any(reasons)

        def work() -> None:
            for entry, reason in zip(entries, reasons, strict=True):
                self.control.reject(entry.path, reason, back=not reason)

        def show(_done: object) -> None:
            for entry, reason in zip(entries, reasons, strict=True):
                self.runs.change(entry.path, rejected=reason)
            are, them, counts = ("is", "it", "counts") if len(entries) == 1 else ("are", "them", "count")
            words = f"{are} rejected: kept, not counted. The same key (Del) takes {them} back."
            if not back:
                self.sounds.play("rejected")
            # what it was before stands beside it no more
            self.services.board.dismiss(Notice("info", self._said))
            self._said = f"{_named(entries)} {f'{counts} again.' if back else words}"
            self.services.board.post("info", self._said)

        self.services.jobs.start("taking a run back" if back else "rejecting a run", work, show)

    def _preliminary(self, recorded: RecordedRun) -> None:
        """Show what stands while the joint correction is computed; the operator can go on, and hears so."""
        self.controller.add(recorded)
        self.sounds.play("result")
        if recorded.path is not None:
            self._heard.add(recorded.path)
            self.situation.take(recorded.path)

    def _recorded(self, recorded: RecordedRun) -> None:
        self.controller.add(recorded)
        if recorded.path is None:
            return
        if recorded.set_aside:
            self.sounds.play("rejected")
            return
        if recorded.path not in self._heard:
            self.sounds.play("result")
        self._heard.discard(recorded.path)
        self.situation.take(recorded.path)


def _named(entries: Sequence[RunEntry]) -> str:
    return entries[0].title if len(entries) == 1 else f"{len(entries)} runs"


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

    changed = Signal()

    def __init__(self, does: Actions, services: Services, parent: QObject) -> None:
        super().__init__(parent)
        control, settings = services.control, services.settings
        self._control, self._state = control, control.state
        self._switches = {name: getattr(does, key) for name, (key, _) in _SWITCHES.items()}
        self._switches["rejected"] = self._switches["result"]
        for name, (key, at_first) in _SWITCHES.items():
            self._switches[name].setChecked(settings.text(key, at_first) == "on")
            self._switches[name].toggled.connect(lambda on, key=key: settings.put(key, "on" if on else "off"))
            self._switches[name].toggled.connect(self.changed)
        control.state_changed.connect(self._follow)
        control.failed.connect(lambda _error: self.play("fault"))
        # a device that was started again left a gap in the run; other warnings can wait for the eye
        control.warned.connect(lambda _words, topic: self.play("fault") if topic == "restart" else None)

    @property
    def words(self) -> str:
        """Which sounds are on."""
        on = [name for name in _SWITCHES if self._switches[name].isChecked()]
        return f"Sound: {', '.join(on)}" if on else "Sound off"

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
