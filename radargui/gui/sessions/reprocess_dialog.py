"""The dialog that processes runs with other settings, shows old and new side by side, and keeps or discards."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import get_args

from PySide6.QtCore import QObject, Signal
from PySide6.QtWidgets import QComboBox, QDialog, QPushButton, QVBoxLayout, QWidget

from radargui.experiment.compare import Comparison, reprocess_runs
from radargui.experiment.reprocess import Outcome
from radargui.gui.background import Jobs
from radargui.gui.control.run_control import RunControl
from radargui.gui.runs.run_list_panel import RunListPanel
from radargui.gui.services import Services
from radargui.gui.sessions.comparison_table import ComparisonTable, settings_words
from radargui.gui.setup.form import Group, plain_label, side_by_side
from radargui.gui.setup.processing_form import CORRECTIONS, GEOMETRIES, offered
from radargui.gui.setup.setup_model import SetupModel
from radargui.gui.work_strip import WorkStrip
from radargui.model.processing import Correction, Geometry
from radargui.model.setup import Setup


class ReprocessDialog(QDialog):
    """The samples are never touched; stored results stay until the new ones are kept."""

    kept = Signal(object)

    def __init__(
        self,
        jobs: Jobs,
        runs: Sequence[Path],
        chosen: Path | None,
        setup: Setup,
        *,
        read_only: bool = False,
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(parent)
        self.setWindowTitle("Process again and compare")
        self.resize(760, 620)
        self._read_only = read_only
        self._other: tuple[Setup | None, dict[str, str]] = (None, {})
        self._good: tuple[Path, ...] = ()
        self.what = QComboBox()
        if chosen is not None:
            self.what.addItem(f"The chosen run, {chosen.stem}", (chosen,))
        self.what.addItem(f"All {len(runs)} runs of the session", tuple(runs))
        self.setup = QComboBox()
        self.setup.addItem("As recorded", None)
        self.setup.addItem("Setup in the window", setup)
        self.correction = _choice(offered(CORRECTIONS, get_args(Correction)))
        self.geometry_choice = _choice(offered(GEOMETRIES, get_args(Geometry)))
        group = Group("With")
        group.row("Runs", self.what)
        group.row("Antennas and processing", self.setup)
        group.row("IQ correction", self.correction)
        group.row("Geometry", self.geometry_choice)
        self.compare = QPushButton("Process and compare")
        self.compare.setDefault(True)
        self.compare.clicked.connect(self._compare)
        self.work = WorkStrip(jobs)
        self.settings = plain_label()
        self.table = ComparisonTable()
        self.words = plain_label()
        self.keep = QPushButton("Keep the new results")
        self.keep.setToolTip("They take the place of the stored ones, whose figures stay beside them")
        self.keep.setAutoDefault(False)
        self.keep.clicked.connect(self._keep)
        self.discard = QPushButton("Discard")
        self.discard.setAutoDefault(False)
        self.discard.clicked.connect(self.reject)
        column = QVBoxLayout(self)
        column.addWidget(group)
        column.addWidget(self.compare)
        column.addWidget(self.work)
        column.addWidget(self.settings)
        column.addWidget(self.table, 1)
        column.addWidget(self.words)
        column.addWidget(side_by_side(self.keep, self.discard))
        for box in (self.what, self.setup, self.correction, self.geometry_choice):
            box.currentIndexChanged.connect(lambda _index: self._forget())
        self._show_buttons()

    def done(self, result: int) -> None:
        """Cancel what is under way, and close."""
        self.work.cancel()
        super().done(result)

    def _compare(self) -> None:
        self._forget()
        changes = {
            "processing.correction": self.correction.currentData(),
            "processing.geometry": self.geometry_choice.currentData(),
        }
        runs = tuple(map(Path, self.what.currentData()))
        setup, wanted = self._other = self.setup.currentData(), {key: one for key, one in changes.items() if one}
        self.work.start(
            "processing again",
            lambda task: tuple(reprocess_runs(runs, setup, wanted, progress=task.report)),
            self._show_outcomes,
            self._failed,
            lambda: self._ended("Cancelled; nothing was changed."),
        )
        self._show_buttons()

    def _keep(self) -> None:
        runs, (setup, wanted) = self._good, self._other
        self.work.start(
            "keeping the new results",
            lambda task: tuple(reprocess_runs(runs, setup, wanted, keep=True, progress=task.report)),
            self._kept,
            self._failed,
            lambda: self._ended("Cancelled; runs that were done keep their new results."),
        )
        self._show_buttons()

    def _show_outcomes(self, outcomes: tuple[Outcome[Comparison], ...]) -> None:
        self.table.show_outcomes(outcomes)
        compared = [one.value for one in outcomes if one.value is not None]
        self._good = tuple(one.run for one in compared)
        self.settings.setText(settings_words(compared[0]) if compared else "")
        self._ended("Nothing is changed yet." if compared else "")

    def _kept(self, outcomes: tuple[Outcome[Comparison], ...]) -> None:
        failed = [one for one in outcomes if one.error is not None]
        self._good = ()
        self._ended("\n".join(str(one.error) for one in failed) or "The new results are kept with the runs.")
        self.kept.emit(tuple(one.run for one in outcomes if one.error is None))

    def _failed(self, error: BaseException) -> None:
        self._ended(str(error))

    def _ended(self, words: str) -> None:
        self.words.setText(words)
        self._show_buttons()

    def _forget(self) -> None:
        self._good = ()
        self.words.setText("")
        self.settings.setText("")
        self.table.show_outcomes(())
        self._show_buttons()

    def _show_buttons(self) -> None:
        busy = self.work.busy
        for widget in (self.compare, self.what, self.setup, self.correction, self.geometry_choice):
            widget.setEnabled(not busy)
        self.keep.setEnabled(bool(self._good) and not busy and not self._read_only)
        if self._read_only:
            self.keep.setToolTip("The session is opened for looking only.")


def _choice(words: dict[str, str]) -> QComboBox:
    box = QComboBox()
    box.addItem("As in the setup", None)
    for value, text in words.items():
        box.addItem(text, value)
    return box


class ReprocessController(QObject):
    """Opens the dialog for the session that is open; `kept`: results took the place of the stored ones."""

    kept = Signal()

    def __init__(self, control: RunControl, runs: RunListPanel, setup_model: SetupModel, services: Services) -> None:
        super().__init__(services.parent)
        self._control, self._runs, self._setup_model, self._services = control, runs, setup_model, services
        self.dialog: ReprocessDialog | None = None

    def ask(self) -> None:
        """Let the operator choose other settings."""
        session = self._control.session
        runs = session.run_paths() if session is not None else ()
        if session is None or not runs or self._control.state.holds_a_run:
            self._services.board.post("warning", "There is no run to process again: record one, or open a session.")
            return
        self.close()
        chosen = self._runs.chosen
        self.dialog = ReprocessDialog(
            self._services.jobs,
            runs,
            chosen.path if chosen else None,
            self._setup_model.setup,
            read_only=bool(session.read_only),
            parent=self._services.parent,
        )
        self.dialog.kept.connect(lambda _runs: self.kept.emit())
        self.dialog.show()

    def close(self) -> None:
        """Cancel and close the dialog."""
        if self.dialog is not None:
            self.dialog.reject()
            self.dialog = None
