"""Rows under titles, and the list of them to choose one from, whose columns the operator may set."""

from collections.abc import Iterable, Sequence
from typing import Any, Generic, TypeVar

from PySide6.QtCore import QAbstractItemModel, QAbstractTableModel, QModelIndex, QPersistentModelIndex, Qt
from PySide6.QtWidgets import QAbstractItemView, QHeaderView, QTableView

Index = QModelIndex | QPersistentModelIndex
_R = TypeVar("_R")


class RowModel(QAbstractTableModel, Generic[_R]):
    """Rows under fixed titles, as Qt wants them; what stands in a cell is the subclass's to say.

    Parameters
    ----------
    titles
        One a column.
    """

    def __init__(self, titles: Sequence[str]) -> None:
        super().__init__()
        self._titles = tuple(titles)
        self.entries: list[_R] = []

    def cell(self, entry: _R, column: int, role: int) -> Any:
        """Return what Qt asks of a cell; None where there is nothing to say. A row that is texts shows them."""
        return entry[column] if role == Qt.ItemDataRole.DisplayRole and isinstance(entry, tuple) else None

    def replace_all(self, entries: Iterable[_R]) -> None:
        """Show other rows."""
        self.beginResetModel()
        self.entries = list(entries)
        self.endResetModel()

    def rowCount(self, parent: Index = QModelIndex()) -> int:  # noqa: N802, B008 - Qt's name and default
        """Return the number of rows."""
        return 0 if parent.isValid() else len(self.entries)

    def columnCount(self, parent: Index = QModelIndex()) -> int:  # noqa: N802, B008 - Qt's name and default
        """Return the number of columns."""
        return 0 if parent.isValid() else len(self._titles)

    def data(self, index: Index, role: int = Qt.ItemDataRole.DisplayRole) -> Any:
        """Return what `cell` says."""
        return self.cell(self.entries[index.row()], index.column(), role) if index.isValid() else None

    def headerData(  # noqa: N802 - Qt's name
        self, section: int, orientation: Qt.Orientation, role: int = Qt.ItemDataRole.DisplayRole
    ) -> Any:
        """Return a column's title."""
        titled = role == Qt.ItemDataRole.DisplayRole and orientation == Qt.Orientation.Horizontal
        # the unit beneath its name: a column is as wide as its figures, not as its title
        return self._titles[section].replace(" [", "\n[") if titled else None


class RowTable(QTableView):
    """Whole rows, nothing to edit; columns fit their words until the operator sets one of them.

    Parameters
    ----------
    model
        The rows.
    name
        What the widths are remembered by.
    """

    def __init__(self, model: QAbstractItemModel, name: str) -> None:
        super().__init__()
        self.setObjectName(name)
        self.columns_chosen = False
        self._fitting = False
        self.setModel(model)
        self.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        self.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
        self.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        self.setAlternatingRowColors(True)
        self.setShowGrid(False)
        self.setWordWrap(False)
        self.setTabKeyNavigation(False)
        self.verticalHeader().hide()
        self.verticalHeader().setDefaultSectionSize(self.fontMetrics().height() + 8)
        header = self.horizontalHeader()
        header.setSectionResizeMode(QHeaderView.ResizeMode.Interactive)
        header.setStretchLastSection(True)
        header.setHighlightSections(False)
        header.setDefaultAlignment(Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter)
        header.sectionResized.connect(self._resized)

    def fit(self, column: int, width: int) -> None:
        """Set a width, unless the operator has set the columns."""
        if not self.columns_chosen:
            self._fitting = True
            self.setColumnWidth(column, width)
            self._fitting = False

    def fit_all(self) -> None:
        """Make each column as wide as its words, unless the operator has set the columns."""
        if not self.columns_chosen:
            self._fitting = True
            self.resizeColumnsToContents()
            self._fitting = False

    def _resized(self, column: int, _old: int, _new: int) -> None:
        # the last one takes what room is left
        if not self._fitting and column < self.model().columnCount() - 1:
            self.columns_chosen = True
