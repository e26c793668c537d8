"""The offer to compute, in the background, the results of runs that were left for later."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import QTimer, Signal
from PySide6.QtWidgets import QFrame, QHBoxLayout, QPushButton

from radargui.experiment.reprocess import Outcome, compute_later
from radargui.gui.control.run_control import RunControl
from radargui.gui.services import Services
from radargui.gui.setup.form import plain_label
from radargui.gui.setup.session_panel import SessionPanel
from radargui.gui.work_strip import Task
from radargui.model.errors import CancelledError
from radargui.model.result import RunResult
from radargui.session.catalogue import Catalogue, RunLine

_LOOK_AFTER_MS = 600
"""After the look for unfinished runs has begun, which reads the same folders."""


class LaterOffer(QFrame):
    """Words and two buttons; hidden where every run has its result. `computed` comes when runs got theirs."""

    computed = Signal()

    def __init__(self, control: RunControl, panel: SessionPanel, services: Services) -> None:
        super().__init__()
        self._control, self._panel, self._services = control, panel, services
        self.runs: tuple[RunLine, ...] = ()
        self.setObjectName("later")
        self._words = plain_label()
        self.compute = QPushButton("Compute in the background")
        self.compute.setToolTip("One after the other, in a process of its own; runs can be recorded meanwhile")
        self.compute.clicked.connect(self._compute)
        self.not_now = QPushButton("Not now")
        self.not_now.setToolTip("Offered again at the next start; radargui batch computes them too")
        self.not_now.clicked.connect(self.hide)
        row = QHBoxLayout(self)
        row.setContentsMargins(8, 4, 4, 4)
        row.addWidget(self._words, 1)
        row.addWidget(self.compute)
        row.addWidget(self.not_now)
        services.theme.changed.connect(self._paint)
        self._paint()
        self.hide()
        self._soon = QTimer(self)
        self._soon.setSingleShot(True)
        self._soon.timeout.connect(self.look)
        self._soon.start(_LOOK_AFTER_MS)
        control.state_changed.connect(self._look_again)

    @property
    def text(self) -> str:
        """What is offered."""
        return self._words.text()

    def look(self) -> None:
        """Look for runs without a final result, in the background; not while some are being computed."""
        folder = self._panel.data_folder
        if folder.is_dir() and not self._control.state.running:
            task = self._services.work.quiet()
            self._services.jobs.start(
                "looking for runs to compute", lambda: _to_compute(folder, task), self._offer, self._failed
            )

    def _look_again(self) -> None:
        """Take the offer back while runs are recorded; afterwards look again where some were left."""
        if self._control.state.running:
            self.hide()
        elif self._control.leaves:
            self.look()

    def _offer(self, runs: tuple[RunLine, ...]) -> None:
        self.runs = runs
        count = "1 run waits for its result" if len(runs) == 1 else f"{len(runs)} runs wait for their results"
        folders = sorted({run.path.parent.name for run in runs})
        where = folders[-1] if len(folders) == 1 else f"{len(folders)} sessions"
        self._words.setText(f"{count}, in {where}: left for later.")
        self.setVisible(bool(runs) and not self._control.state.running)

    def _compute(self) -> None:
        paths = [run.path for run in self.runs]
        self.hide()
        self._services.work.start(
            f"computing {len(paths)} results",
            lambda task: compute_later(paths, task.report),
            self._done,
            self._failed,
            self.computed.emit,
        )

    def _done(self, outcomes: tuple[Outcome[RunResult], ...]) -> None:
        board = self._services.board
        for outcome in outcomes:
            if outcome.error is not None:
                board.post("error", f"{outcome.run.name}: {outcome.error}", topic="computed later")
        good = sum(outcome.value is not None for outcome in outcomes)
        board.post("info", f"{good} of {len(outcomes)} results that were left for later are computed")
        self.computed.emit()

    def _failed(self, error: BaseException) -> None:
        if not isinstance(error, CancelledError):
            self._services.board.post_error(error)

    def _paint(self) -> None:
        colours = self._services.theme.colours
        self.setStyleSheet(
            f"QFrame#later {{ background: {colours.raised}; border: none; border-left: 6px solid {colours.busy}; }}"
        )


def _to_compute(folder: Path, task: Task) -> tuple[RunLine, ...]:
    with Catalogue(folder) as catalogue:
        catalogue.refresh(task.report)
        return catalogue.to_compute()
