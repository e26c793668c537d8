"""What is shown across the room: gathered from what is done, what came of it, and what the operator does next."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import QObject

from radargui.experiment.event import RecordedRun
from radargui.gui.control.across_view import NEXT, AcrossView, Situation
from radargui.gui.control.state import AppState
from radargui.gui.runs.run_keeping import RunKeeping


class AcrossController(QObject):
    """Keeps the view in step; asked by `look` as often as the health line.

    Parameters
    ----------
    keeping
        Knows the runs and what the next one is called.
    view
        Where it is shown.
    """

    def __init__(self, keeping: RunKeeping, view: AcrossView) -> None:
        super().__init__(view)
        self._keeping, self._view = keeping, view
        self._of: Path | None = None
        control = keeping.control
        control.run_preliminary.connect(self._take)
        control.run_recorded.connect(self._take)
        control.session_changed.connect(self._forget)
        control.state_changed.connect(self.look)
        # after the view's own answer to the switch
        keeping.does.across.toggled.connect(self.look)

    def look(self, *_: object) -> None:
        """Show the situation now."""
        if self._view.isVisible():
            self._view.show_situation(self.situation())

    def situation(self) -> Situation:
        """Return what is to be shown."""
        state = self._keeping.control.state
        entry = self._keeping.runs.model.entry_of(self._of) if self._of else None
        result = ""
        if entry is not None:
            known = (entry.summary or {}).get("e") is not None
            result = f"e = {entry.restitution()}" if known else "no e"
        coming = state in (AppState.ARMED, AppState.RECORDING, AppState.SETTLING)
        run = self._keeping.coming if coming else entry.called if entry is not None else ""
        if coming and entry is not None:
            run = f"{run}; e of {entry.called}"
        return Situation(state, result, run, self._next(state, entry.verdict if entry and result == "no e" else ""))

    def _next(self, state: AppState, why: str) -> str:
        control, notices = self._keeping.control, self._keeping.services.board.notices
        if state is AppState.FAILED:
            return notices[0].text if notices else "Press R to try again"
        if state is AppState.ARMED:
            return f"Waiting for {control.waits_for}" if control.waits_for else "Let the sphere drop"
        if state is AppState.PROCESSING:
            return f"{NEXT[state]}: {control.reached.progress:.0%}"
        return f"{why[:1].upper()}{why[1:]}. {NEXT[state]}" if why and state is AppState.DONE else NEXT[state]

    def _take(self, recorded: RecordedRun) -> None:
        if recorded.path is not None and not recorded.set_aside:
            self._of = recorded.path
        self.look()

    def _forget(self) -> None:
        self._of = None
