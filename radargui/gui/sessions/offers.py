"""Offers at the start of the window: finish runs that a crash left, compute results that were left for later."""

from collections.abc import Sequence
from datetime import datetime
from pathlib import Path

from PySide6.QtCore import QTimer, Signal

from radargui.experiment.reprocess import RecoveredRun, compute_later, recover_run, unfinished_runs
from radargui.files.access import Outcome, Progress, each_run
from radargui.gui.background import Task
from radargui.gui.control.state import Asked
from radargui.gui.layout import Edge, Strip, button
from radargui.gui.services import Services
from radargui.gui.setup.session_panel import SessionPanel
from radargui.model.errors import CancelledError
from radargui.model.result import RunResult
from radargui.model.words import counted
from radargui.session.catalogue import Catalogue, RunLine

_NAMED = 3
"""Runs named in an offer; more would not fit its line."""
_RECOVERY_AFTER_MS, _LATER_AFTER_MS = 300, 600
"""The window is drawn first; the second look finds the index that the first one, of the same folders, has renewed."""


class _Offer(Strip):
    """Words and two buttons; hidden where there is nothing to offer, and nothing is done without being asked for."""

    accepted, tip, refusal_tip, what = "", "", "", ""
    edge: Edge = "link-visited"
    after_ms = 0
    only_at_rest = False

    def __init__(self, panel: SessionPanel, services: Services) -> None:
        self.accept = button(self.accepted, self._accept, self.tip)
        self.refuse = button("Not now", self.hide, self.refusal_tip)
        super().__init__(self.edge, self.accept, self.refuse)
        self._control, self._panel, self._services = services.control, panel, services
        self.runs: tuple[RunLine, ...] = ()
        QTimer.singleShot(self.after_ms, self, self.look)

    def look(self) -> None:
        """Look for such runs, in the background; the first look at a large folder takes its time."""
        folder, task = self._panel.data_folder, self._services.work.quiet()
        busy = self.only_at_rest and self._control.state.running
        if not busy and self._services.parent.isVisible():

            def work() -> tuple[RunLine, ...]:
                return self._find(folder, task) if folder.is_dir() else ()

            self._services.jobs.start(self.what, work, self._offer, self._failed)

    def _find(self, folder: Path, task: Task) -> tuple[RunLine, ...]:
        raise NotImplementedError

    def _offer(self, runs: tuple[RunLine, ...]) -> None:
        raise NotImplementedError

    def _accept(self) -> None:
        raise NotImplementedError

    def _failed(self, error: BaseException) -> None:
        if not isinstance(error, CancelledError):
            self._services.board.post_error(error)


class RecoveryOffer(_Offer):
    """Runs that a crash or a power cut left unfinished."""

    recovered = Signal(object)
    accepted = "Recover"
    tip = "Finish the runs, mark them as recovered, process them; the samples stay as they are"
    refusal_tip = "Leave them as they are; offered again at the next start"
    after_ms = _RECOVERY_AFTER_MS
    what = "the search for unfinished runs"

    def _find(self, folder: Path, task: Task) -> tuple[RunLine, ...]:
        return unfinished_runs(folder, progress=task.report)

    def _offer(self, runs: tuple[RunLine, ...]) -> None:
        recording = self._control.session
        self.runs = tuple(run for run in runs if recording is None or not recording.records(run.path))
        names = [f"{run.path.parent.name}/{run.path.name} ({run.duration_s:.1f} s)" for run in self.runs[:_NAMED]]
        more = len(self.runs) - len(names)
        self.words.setText(
            f"{_counted(self.runs, 'was', 'were')} left unfinished by a crash or a power cut: {', '.join(names)}"
            f"{f' and {more} more' if more else ''}. What was recorded until then is there."
        )
        self.setVisible(bool(self.runs))

    def _accept(self) -> None:
        def recover(path: Path, report: Progress) -> RecoveredRun:
            return recover_run(path, now=datetime.now().astimezone(), progress=report)

        def work(task: Task) -> tuple[Outcome[RecoveredRun], ...]:
            return tuple(each_run(paths, recover, task.report))

        self.hide()
        paths = [run.path for run in self.runs]
        self._services.work.start("recovering runs", work, self._done, cancelled=self.look)

    def _done(self, outcomes: tuple[Outcome[RecoveredRun], ...]) -> None:
        board = self._services.board
        good = [one.value for one in outcomes if one.value is not None]
        for outcome in outcomes:
            if outcome.error is not None:
                board.post_error(outcome.error)
            elif outcome.value is not None and outcome.value.error is not None:
                board.post("warning", f"{outcome.run.name} is recovered, but not processed: {outcome.value.error}")
        if good:
            folders = ", ".join(sorted({one.path.parent.name for one in good}))
            board.post("info", f"{_counted(good, 'is', 'are')} recovered, in {folders}")
        self.recovered.emit(good)


class LaterOffer(_Offer):
    """Runs whose results were left for later; `computed` comes when they got theirs."""

    computed = Signal()
    accepted = "Compute in the background"
    tip = "One after the other, in a process of its own; runs can be recorded meanwhile"
    refusal_tip = "Offered again at the next start; radargui batch computes them too"
    edge = "link"
    after_ms = _LATER_AFTER_MS
    only_at_rest = True
    what = "the search for runs to compute"

    def __init__(self, panel: SessionPanel, services: Services) -> None:
        super().__init__(panel, services)
        self._control.state_changed.connect(self._look_again)
        self._control.left.connect(self.compute)

    def _find(self, folder: Path, task: Task) -> tuple[RunLine, ...]:
        with Catalogue(folder) as catalogue:
            catalogue.refresh(task.report)
            return catalogue.to_compute()

    def _look_again(self) -> None:
        """Take the offer back while runs are recorded; afterwards look again where some were left."""
        if self._control.state.running:
            self.hide()
        elif self._control.reached.asked is Asked.LEAVE:
            self.look()

    def _offer(self, runs: tuple[RunLine, ...]) -> None:
        self.runs = runs
        count = _counted(runs, "waits for its result", "wait for their results")
        folders = {run.path.parent.name for run in runs}
        where = folders.pop() if len(folders) == 1 else f"{len(folders)} sessions"
        self.words.setText(f"{count}, in {where}: left for later.")
        self.setVisible(bool(runs) and not self._control.state.running)

    def _accept(self) -> None:
        self.hide()
        self.compute([run.path for run in self.runs])

    def compute(self, paths: Sequence[Path]) -> None:
        """Compute results in the background, also while further runs are recorded."""
        start, what = self._services.work.start, f"computing {counted(len(paths), 'result')}"
        start(what, lambda task: compute_later(paths, task.report), self._done, cancelled=self.computed.emit)

    def _done(self, outcomes: tuple[Outcome[RunResult], ...]) -> None:
        board = self._services.board
        for outcome in outcomes:
            if outcome.error is not None:
                board.post("error", f"{outcome.run.name}: {outcome.error}", topic="computed later")
        good = sum(outcome.value is not None for outcome in outcomes)
        board.post("info", f"{good} of {len(outcomes)} results that were left for later are computed")
        self.computed.emit()


def _counted(runs: Sequence[object], one: str, many: str) -> str:
    return f"{counted(len(runs), 'run')} {one if len(runs) == 1 else many}"
