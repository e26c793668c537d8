"""The runs of the session as a table: number, time, drop height, impact speed, e, g, verdict."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from datetime import datetime
from pathlib import Path
from typing import Any

from PySide6.QtCore import QAbstractTableModel, QModelIndex, QPersistentModelIndex, Qt
from PySide6.QtGui import QPalette
from PySide6.QtWidgets import QApplication

from radargui.report.rounding import UNKNOWN, plain, quantity

Index = QModelIndex | QPersistentModelIndex
COLUMNS = ("Run", "Time", "Drop [mm]", "Impact [m/s]", "e", "g [m/s²]", "Verdict")


@dataclass(frozen=True, slots=True)
class RunEntry:
    """One line of the list.

    Attributes
    ----------
    path
        Run file.
    started_at
        ISO 8601; empty where unknown.
    summary
        What `files.summary.summarise` gave; None while not processed.
    problem
        Why the file cannot be used; empty where it can.
    rejected
        Why the run does not count; empty where it does. None: as it was known before.
    agreement, health
        How far live was from offline, how the recording went; empty where unknown, or as it was known before.
    """

    path: Path
    started_at: str = ""
    summary: Mapping[str, Any] | None = None
    problem: str = ""
    rejected: str | None = None
    agreement: str = ""
    health: str = ""

    @property
    def name(self) -> str:
        """Name for people: the stem of the file."""
        return self.path.stem

    @property
    def clock(self) -> str:
        """Time of day of the first sample."""
        try:
            return datetime.fromisoformat(self.started_at).strftime("%H:%M:%S")
        except ValueError:
            return UNKNOWN

    @property
    def verdict(self) -> str:
        """How good the run is, in words."""
        if self.problem:
            return self.problem
        if self.rejected:
            return f"set aside: {self.rejected.removeprefix('rejected ')}"
        if self.summary is None:
            return "not processed"
        if self.summary.get("status") == "no_motion":
            return "no motion"
        if self.summary.get("status") == "rejected":
            return f"rejected: {self.summary.get('reason') or 'no reason given'}"
        verdict = str(self.summary.get("verdict") or UNKNOWN)
        return f"preliminary, {verdict}" if self.summary.get("preliminary") else verdict

    def restitution(self) -> str:
        """Return e with its uncertainty."""
        summary = self.summary or {}
        return quantity(summary.get("e"), summary.get("u_e"))

    def cells(self) -> tuple[str, ...]:
        """Return the texts of the columns."""
        summary = self.summary or {}
        return (
            self.name.removeprefix("run-").lstrip("0") or self.name,
            self.clock,
            plain(summary.get("drop_height_m"), scale=1000.0),
            plain(summary.get("impact_speed_m_s")),
            self.restitution(),
            quantity(summary.get("g_m_s2"), summary.get("u_g_m_s2")),
            self.verdict,
        )


class RunModel(QAbstractTableModel):
    """The entries as Qt wants them."""

    def __init__(self) -> None:
        super().__init__()
        self.entries: list[RunEntry] = []

    def replace_all(self, entries: list[RunEntry]) -> None:
        """Show another session."""
        self.beginResetModel()
        self.entries = list(entries)
        self.endResetModel()

    def put(self, entry: RunEntry) -> int:
        """Add an entry, or replace the one of the same file; return its row."""
        for row, old in enumerate(self.entries):
            if old.path == entry.path:
                self.entries[row] = replace(
                    entry,
                    started_at=entry.started_at or old.started_at,
                    rejected=old.rejected if entry.rejected is None else entry.rejected,
                    agreement=entry.agreement or old.agreement,
                    health=entry.health or old.health,
                )
                self.dataChanged.emit(self.index(row, 0), self.index(row, len(COLUMNS) - 1))
                return row
        row = len(self.entries)
        self.beginInsertRows(QModelIndex(), row, row)
        self.entries.append(entry)
        self.endInsertRows()
        return row

    @property
    def n_rejected(self) -> int:
        """How many runs do not count."""
        return sum(bool(entry.rejected) for entry in self.entries)

    @property
    def last_kept(self) -> RunEntry | None:
        """The last run that counts."""
        return next((entry for entry in reversed(self.entries) if not entry.rejected), None)

    def entry_of(self, path: Path) -> RunEntry | None:
        """Return the entry of a file."""
        return next((entry for entry in self.entries if entry.path == path), None)

    def rowCount(self, parent: Index = QModelIndex()) -> int:  # noqa: N802, B008 - Qt's name and default
        """Return the number of runs."""
        return 0 if parent.isValid() else len(self.entries)

    def columnCount(self, parent: Index = QModelIndex()) -> int:  # noqa: N802, B008 - Qt's name and default
        """Return the number of columns."""
        return 0 if parent.isValid() else len(COLUMNS)

    def data(self, index: Index, role: int = Qt.ItemDataRole.DisplayRole) -> Any:
        """Return a cell's text, alignment or full text."""
        if not index.isValid():
            return None
        entry = self.entries[index.row()]
        if role == Qt.ItemDataRole.DisplayRole:
            return entry.cells()[index.column()]
        if role == Qt.ItemDataRole.ToolTipRole:
            if index.column() < len(COLUMNS) - 1:
                return str(entry.path)
            return "\n".join(filter(None, (entry.verdict, entry.agreement, entry.health)))
        if role == Qt.ItemDataRole.ForegroundRole and entry.rejected:
            return QApplication.palette().brush(QPalette.ColorGroup.Disabled, QPalette.ColorRole.Text)
        if role == Qt.ItemDataRole.TextAlignmentRole:
            return Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter
        return None

    def headerData(  # noqa: N802 - Qt's name
        self, section: int, orientation: Qt.Orientation, role: int = Qt.ItemDataRole.DisplayRole
    ) -> Any:
        """Return a column's title."""
        if role == Qt.ItemDataRole.DisplayRole and orientation == Qt.Orientation.Horizontal:
            return COLUMNS[section]
        return None
