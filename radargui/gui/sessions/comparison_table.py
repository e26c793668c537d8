"""Old and new results side by side, and what was set differently."""

from __future__ import annotations

from collections.abc import Iterator

from PySide6.QtWidgets import QAbstractItemView, QHeaderView, QTableWidget, QTableWidgetItem

from radargui.experiment.compare import ComparedFigure, Comparison, Side
from radargui.experiment.reprocess import Outcome
from radargui.gui.runs.run_model import RunEntry
from radargui.model.rounding import alone, plain, quantity

HEADS = ("Run", "Quantity", "Stored", "New", "New − stored")
_NAMES = {
    "e": ("e", "", 1.0),
    "drop_height_m": ("Drop height", "mm", 1000.0),
    "impact_speed_m_s": ("Impact speed", "m/s", 1.0),
    "g_m_s2": ("g", "m/s²", 1.0),
}


class ComparisonTable(QTableWidget):
    """A few lines a run; texts can be selected and copied."""

    def __init__(self) -> None:
        super().__init__(0, len(HEADS))
        self._lines: tuple[tuple[str, ...], ...] = ()
        self.setHorizontalHeaderLabels(list(HEADS))
        self.verticalHeader().hide()
        self.verticalHeader().setDefaultSectionSize(self.fontMetrics().height() + 8)
        self.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        self.setWordWrap(False)
        self.setShowGrid(False)
        self.setAlternatingRowColors(True)
        self.horizontalHeader().setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        self.horizontalHeader().setStretchLastSection(True)

    def show_outcomes(self, outcomes: tuple[Outcome[Comparison], ...]) -> None:
        """Show what came out."""
        self._lines = tuple(line for outcome in outcomes for line in lines_of(outcome))
        self.setRowCount(len(self._lines))
        for row, line in enumerate(self._lines):
            for column, text in enumerate(line):
                self.setItem(row, column, QTableWidgetItem(text))

    def texts(self) -> tuple[tuple[str, ...], ...]:
        """Return what is shown, row by row."""
        return self._lines


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
