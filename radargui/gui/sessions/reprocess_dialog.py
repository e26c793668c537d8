"""The dialog that processes runs with other settings, shows old and new side by side, and keeps or discards."""

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

from PySide6.QtCore import QObject, Signal
from PySide6.QtWidgets import QWidget

from radargui.experiment.compare import ComparedFigure, Comparison, Side, reprocess_runs
from radargui.experiment.reprocess import Outcome
from radargui.gui.background import Jobs
from radargui.gui.control.run_control import RunControl
from radargui.gui.layout import Choice, Dialog, Group, PlainLabel, button, side_by_side
from radargui.gui.runs.run_list_panel import RunListPanel
from radargui.gui.runs.run_model import RunEntry
from radargui.gui.services import Services
from radargui.gui.setup.setup_model import SetupModel
from radargui.gui.setup.words import words_of
from radargui.gui.table import RowModel, RowTable
from radargui.gui.work_strip import WorkStrip
from radargui.model.rounding import alone, plain, quantity
from radargui.model.setup import Setup

HEADS = ("Run", "Quantity", "Stored", "New", "New − stored")
_NAMES = {
    "e": ("e", "", 1.0),
    "drop_height_m": ("Drop height", "mm", 1000.0),
    "impact_speed_m_s": ("Impact speed", "m/s", 1.0),
    "g_m_s2": ("g", "m/s²", 1.0),
}


class ReprocessDialog(Dialog):
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
        super().__init__("Process again and compare", (760, 620), parent)
        self._read_only = read_only
        self._other: tuple[Setup | None, dict[str, str]] = (None, {})
        self._good: tuple[Path, ...] = ()
        one = [((chosen,), f"The chosen run, {chosen.stem}")] if chosen is not None else []
        self.what = Choice((*one, (tuple(runs), f"All {len(runs)} runs of the session")))
        self.setup = Choice(((None, "As recorded"), (setup, "Setup in the window")))
        as_set = (None, "As in the setup")
        self.correction = Choice((as_set, *words_of("processing.correction").choices.items()))
        self.geometry_choice = Choice((as_set, *words_of("processing.geometry").choices.items()))
        self._choices = {
            "Runs": self.what,
            "Antennas and processing": self.setup,
            "IQ correction": self.correction,
            "Geometry": self.geometry_choice,
        }
        group = Group("With")
        for words, choice in self._choices.items():
            group.row(words, choice)
            choice.currentIndexChanged.connect(lambda _index: self._forget())
        self.compare = button("Process and compare", self._compare, default=True)
        self.work = WorkStrip(jobs)
        self.settings, self.words = PlainLabel(), PlainLabel()
        self.lines = RowModel[tuple[str, ...]](HEADS)
        self.table = RowTable(self.lines, "comparison")
        tip = "They take the place of the stored ones, whose figures stay beside them"
        self.keep = button("Keep the new results", self._keep, tip)
        self.discard = button("Discard", self.reject)
        ends = side_by_side(self.keep, self.discard)
        self.lay_out(group, self.compare, self.work, self.settings, (self.table, 1), self.words, ends)
        self._show_buttons()

    def done(self, result: int) -> None:
        """Cancel what is under way, and close."""
        self.work.cancel()
        super().done(result)

    def _compare(self) -> None:
        self._forget()
        changes = {"correction": self.correction.currentData(), "geometry": self.geometry_choice.currentData()}
        wanted = {f"processing.{name}": value for name, value in changes.items() if value}
        self._other = self.setup.currentData(), wanted
        runs = tuple(map(Path, self.what.currentData()))
        self._work("processing again", runs, self._show_outcomes, "nothing was changed", keep=False)

    def _keep(self) -> None:
        left = "runs that were done keep their new results"
        self._work("keeping the new results", self._good, self._kept, left, keep=True)

    def _work(self, what: str, runs: tuple[Path, ...], then: Callable[[Any], None], left: str, *, keep: bool) -> None:
        setup, wanted = self._other
        self.work.start(
            what,
            lambda task: tuple(reprocess_runs(runs, setup, wanted, keep=keep, progress=task.report)),
            then,
            lambda error: self._ended(str(error)),
            lambda: self._ended(f"Cancelled; {left}."),
        )
        self._show_buttons()

    def _show_outcomes(self, outcomes: tuple[Outcome[Comparison], ...]) -> None:
        self.lines.replace_all(line for outcome in outcomes for line in lines_of(outcome))
        self.table.fit_all()
        compared = [one.value for one in outcomes if one.value is not None]
        self._good = tuple(one.run for one in compared)
        self.settings.setText(settings_words(compared[0]) if compared else "")
        self._ended("Nothing is changed yet." if compared else "")

    def _kept(self, outcomes: tuple[Outcome[Comparison], ...]) -> None:
        failed = [one for one in outcomes if one.error is not None]
        self._good = ()
        self._ended("\n".join(str(one.error) for one in failed) or "The new results are kept with the runs.")
        self.kept.emit(tuple(one.run for one in outcomes if one.error is None))

    def _ended(self, words: str) -> None:
        self.words.setText(words)
        self._show_buttons()

    def _forget(self) -> None:
        self._good = ()
        self.settings.setText("")
        self.lines.replace_all(())
        self._ended("")

    def _show_buttons(self) -> None:
        busy = self.work.busy
        for widget in (self.compare, *self._choices.values()):
            widget.setEnabled(not busy)
        self.keep.setEnabled(bool(self._good) and not busy and not self._read_only)
        if self._read_only:
            self.keep.setToolTip("The session is opened for looking only.")


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


def lines_of(outcome: Outcome[Comparison]) -> Iterator[tuple[str, str, str, str, str]]:
    """Yield the lines of a run."""
    name = outcome.run.stem
    comparison = outcome.value
    if comparison is None:
        yield name, "failed", "", "", str(outcome.error)
        return
    yield name, "Verdict", _verdict(comparison, comparison.before), _verdict(comparison, comparison.after), ""
    for figure in comparison.figures:
        yield "", *_line(figure)


def settings_words(comparison: Comparison) -> str:
    """Return what was set differently, a line each."""
    lines = [f"{one.key}: {_said(one.before)} → {_said(one.after)}" for one in comparison.settings]
    return "\n".join(lines) or "The settings are the same as those of the stored results."


def _line(figure: ComparedFigure) -> tuple[str, str, str, str]:
    words, unit, scale = _NAMES.get(figure.name, (figure.name, figure.unit, 1.0))
    return (
        f"{words} [{unit}]" if unit else words,
        _value(figure.before, figure.u_before, scale),
        _value(figure.after, figure.u_after, scale),
        alone(figure.difference, figure.u_difference, scale, signed=True),
    )


def _value(value: float | None, uncertainty: float | None, scale: float) -> str:
    return plain(value, scale=scale) if uncertainty is None else quantity(value, uncertainty)


def _verdict(comparison: Comparison, side: Side) -> str:
    return RunEntry(comparison.run, summary=side.summary).verdict


def _said(value: object) -> str:
    return "not set" if value is None else str(value)
