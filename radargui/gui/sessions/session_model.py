"""The sessions found as a table: date, operator, sample, target, runs, e, setup, notes."""

from __future__ import annotations

from datetime import datetime
from typing import Any

from PySide6.QtCore import QAbstractTableModel, QModelIndex, QPersistentModelIndex, Qt

from radargui.restitution.series import series_of
from radargui.session.catalogue import SessionSummary

Index = QModelIndex | QPersistentModelIndex
COLUMNS = ("Date", "Operator", "Sample", "Target", "Runs", "e", "Setup", "Notes")


def cells(found: SessionSummary) -> tuple[str, ...]:
    """Return the texts of the columns."""
    return (
        _when(found),
        found.operator,
        found.sample,
        found.target,
        _runs(found),
        _restitution(found),
        found.setup_name,
        found.problem or " ".join(found.notes.split()),
    )


def _when(found: SessionSummary) -> str:
    try:
        return datetime.fromisoformat(found.created_at).strftime("%Y-%m-%d %H:%M")
    except ValueError:
        return found.name


def _runs(found: SessionSummary) -> str:
    more = [f"{found.n_rejected} set aside"] if found.n_rejected else []
    more += [f"{found.n_unfinished} unfinished"] if found.n_unfinished else []
    return f"{found.n_runs} ({', '.join(more)})" if more else str(found.n_runs)


def _restitution(found: SessionSummary) -> str:
    series = series_of(found.drops)
    many = f" (n = {series.e.n})" if series.e.n > 1 else ""
    mark = "" if series.kind in (None, "measured") else f", {series.kind}"
    return f"{series.e.words()}{many}{mark}"


class SessionModel(QAbstractTableModel):
    """The summaries as Qt wants them."""

    def __init__(self) -> None:
        super().__init__()
        self.found: tuple[SessionSummary, ...] = ()

    def show(self, found: tuple[SessionSummary, ...]) -> None:
        """Show what was found."""
        self.beginResetModel()
        self.found = found
        self.endResetModel()

    def rowCount(self, parent: Index = QModelIndex()) -> int:  # noqa: N802, B008 - Qt's name and default
        """Return the number of sessions."""
        return 0 if parent.isValid() else len(self.found)

    def columnCount(self, parent: Index = QModelIndex()) -> int:  # noqa: N802, B008 - Qt's name and default
        """Return the number of columns."""
        return 0 if parent.isValid() else len(COLUMNS)

    def data(self, index: Index, role: int = Qt.ItemDataRole.DisplayRole) -> Any:
        """Return a cell's text or full text."""
        if not index.isValid():
            return None
        found = self.found[index.row()]
        if role == Qt.ItemDataRole.DisplayRole:
            return cells(found)[index.column()]
        if role == Qt.ItemDataRole.ToolTipRole:
            # a tool tip that looks like markup would be taken for it
            return (found.problem or found.notes or str(found.path)).replace("<", "‹")
        return None

    def headerData(  # noqa: N802 - Qt's name
        self, section: int, orientation: Qt.Orientation, role: int = Qt.ItemDataRole.DisplayRole
    ) -> Any:
        """Return a column's title."""
        if role == Qt.ItemDataRole.DisplayRole and orientation == Qt.Orientation.Horizontal:
            return COLUMNS[section]
        return None
