"""The offer at the start to finish runs that a crash left; nothing is changed without being asked for."""

from __future__ import annotations

from datetime import datetime
from pathlib import Path

from PySide6.QtCore import QTimer, Signal
from PySide6.QtWidgets import QFrame, QHBoxLayout, QPushButton

from radargui.experiment.reprocess import Outcome, RecoveredRun, each_run, recover_run
from radargui.files.progress import Progress
from radargui.gui.control.run_control import RunControl
from radargui.gui.services import Services
from radargui.gui.setup.form import plain_label
from radargui.gui.setup.session_panel import SessionPanel
from radargui.gui.work_strip import Task
from radargui.model.errors import CancelledError
from radargui.session.catalogue import Catalogue, RunLine
from radargui.session.recovery import unfinished_runs

_NAMED = 3
_LOOK_AFTER_MS = 300


class RecoveryOffer(QFrame):
    """Words and two buttons; hidden where no run is unfinished."""

    recovered = Signal(object)

    def __init__(self, control: RunControl, panel: SessionPanel, services: Services) -> None:
        super().__init__()
        self._control, self._panel, self._services = control, panel, services
        self.runs: tuple[RunLine, ...] = ()
        self.setObjectName("recovery")
        self._words = plain_label()
        self.recover = QPushButton("Recover")
        self.recover.setToolTip("Finish the runs, mark them as recovered, process them; the samples stay as they are")
        self.recover.clicked.connect(self._recover)
        self.later = QPushButton("Not now")
        self.later.setToolTip("Leave them as they are; offered again at the next start")
        self.later.clicked.connect(self.hide)
        row = QHBoxLayout(self)
        row.setContentsMargins(8, 4, 4, 4)
        row.addWidget(self._words, 1)
        row.addWidget(self.recover)
        row.addWidget(self.later)
        services.theme.changed.connect(self._paint)
        self._paint()
        self.hide()
        self._soon = QTimer(self)
        self._soon.setSingleShot(True)
        self._soon.timeout.connect(self.look)
        self._soon.start(_LOOK_AFTER_MS)

    @property
    def text(self) -> str:
        """What is offered."""
        return self._words.text()

    def look(self) -> None:
        """Look for unfinished runs, in the background."""
        folder = self._panel.data_folder
        if not folder.is_dir():
            return
        task = self._services.work.quiet()
        self._services.jobs.start(
            "looking for unfinished runs",
            lambda: _unfinished(folder, task),
            self._offer,
            self._failed,
        )

    def _failed(self, error: BaseException) -> None:
        if not isinstance(error, CancelledError):
            self._services.board.post_error(error)

    def _offer(self, runs: tuple[RunLine, ...]) -> None:
        recording = self._control.session
        own = None if recording is None else recording.recording
        self.runs = tuple(run for run in runs if run.path != own)
        names = [f"{run.path.parent.name}/{run.path.name} ({run.duration_s:.1f} s)" for run in self.runs[:_NAMED]]
        more = len(self.runs) - len(names)
        count = "1 run was" if len(self.runs) == 1 else f"{len(self.runs)} runs were"
        self._words.setText(
            f"{count} left unfinished by a crash or a power cut: {', '.join(names)}"
            f"{f' and {more} more' if more else ''}. What was recorded until then is there."
        )
        self.setVisible(bool(self.runs))

    def _recover(self) -> None:
        paths = [run.path for run in self.runs]
        self.hide()
        self._services.work.start(
            "recovering runs",
            lambda task: _recovered(paths, task),
            self._done,
            self._services.board.post_error,
            self.look,
        )

    def _done(self, outcomes: tuple[Outcome[RecoveredRun], ...]) -> None:
        board = self._services.board
        good = [one.value for one in outcomes if one.value is not None]
        for outcome in outcomes:
            if outcome.error is not None:
                board.post_error(outcome.error)
            elif outcome.value is not None and outcome.value.error is not None:
                board.post("warning", f"{outcome.run.name} is recovered, but not processed: {outcome.value.error}")
        if good:
            count = "1 run is" if len(good) == 1 else f"{len(good)} runs are"
            folders = ", ".join(sorted({one.path.parent.name for one in good}))
            board.post("info", f"{count} recovered, in {folders}")
        self.recovered.emit(good)

    def _paint(self) -> None:
        colours = self._services.theme.colours
        self.setStyleSheet(
            f"QFrame#recovery {{ background: {colours.raised}; border: none; border-left: 6px solid {colours.mark}; }}"
        )


def _unfinished(folder: Path, task: Task) -> tuple[RunLine, ...]:
    # the first look at a large folder takes its time: it can be cancelled, and is kept in the index
    with Catalogue(folder) as catalogue:
        catalogue.refresh(task.report)
    return unfinished_runs(folder)


def _recovered(paths: list[Path], task: Task) -> tuple[Outcome[RecoveredRun], ...]:
    def recover(path: Path, report: Progress) -> RecoveredRun:
        return recover_run(path, now=datetime.now().astimezone(), progress=report)

    return tuple(each_run(paths, recover, task.report))
