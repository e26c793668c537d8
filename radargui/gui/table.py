"""Rows under titles, and the list of them to choose one from, whose columns the operator may set."""

from collections.abc import Callable, Iterable, Mapping
from typing import Any, Generic, TypeVar

from PySide6.QtCore import QAbstractTableModel, QModelIndex, QPersistentModelIndex, Qt
from PySide6.QtWidgets import QAbstractItemView, QHeaderView, QTableView

from radargui.gui.layout import TIPS

Index = QModelIndex | QPersistentModelIndex
_R = TypeVar("_R")


class RowModel(QAbstractTableModel, Generic[_R]):
    """Rows under fixed titles, as Qt wants them.

    Parameters
    ----------
    columns
        What stands in each column of a row, by the column's title.
    tip
        Tool tip of a row.
    """

    def __init__(
        self, columns: Mapping[str, Callable[[_R], str]], tip: Callable[[_R], str] = lambda _entry: ""
    ) -> None:
        super().__init__()
        self._titles, self._texts, self._tip = tuple(columns), tuple(columns.values()), tip
        self.entries: list[_R] = []

    def cell(self, entry: _R, column: int, role: int) -> Any:
        """Return what Qt asks of a cell; None where there is nothing to say."""
        if role == Qt.ItemDataRole.DisplayRole:
            return self._texts[column](entry)
        # a tool tip that looks like markup would be taken for it
        return self._tip(entry).replace("<", "‹") if role == Qt.ItemDataRole.ToolTipRole else None

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
        """Return a column's title, and what it means with its unit as the tool tip."""
        if role == Qt.ItemDataRole.ToolTipRole and orientation == Qt.Orientation.Horizontal:
            return TIPS["columns"].get(self._titles[section].replace("\n", " "))
        titled = role == Qt.ItemDataRole.DisplayRole and orientation == Qt.Orientation.Horizontal
        # the unit beneath its name: a column is as wide as its figures, not as its title
        return self._titles[section].replace(" [", "\n[") if titled else None


class RowTable(QTableView, Generic[_R]):
    """Whole rows, nothing to edit; columns fit their words until the operator sets one of them.

    Parameters
    ----------
    model
        The rows.
    name
        What the widths are remembered by.
    """

    def __init__(self, model: RowModel[_R], name: str) -> None:
        super().__init__()
        self._rows = model
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

    @property
    def chosen(self) -> _R | None:
        """The selected row."""
        rows = self.selectionModel().selectedRows()
        return self._rows.entries[rows[0].row()] if rows else None

    @property
    def all_chosen(self) -> list[_R]:
        """Every selected row, in the order of the table."""
        return [self._rows.entries[row] for row in sorted(one.row() for one in self.selectionModel().selectedRows())]

    def choose(self, wanted: Callable[[_R], bool]) -> bool:
        """Select the first row that is wanted; return whether there is one."""
        row = next((number for number, one in enumerate(self._rows.entries) if wanted(one)), None)
        if row is not None:
            self.selectRow(row)
        return row is not None

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
