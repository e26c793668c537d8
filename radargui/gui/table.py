"""Rows under titles, and the list of them to choose one from, whose columns the operator may set."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from operator import itemgetter
from typing import Any, Generic, TypeVar

from PySide6.QtCore import QAbstractTableModel, QModelIndex, QPersistentModelIndex, QSortFilterProxyModel, Qt
from PySide6.QtGui import QKeySequence
from PySide6.QtWidgets import QApplication, QTableView

from radargui.gui.layout import TIPS, having
from radargui.model.rounding import UNKNOWN

Index = QModelIndex | QPersistentModelIndex
_R = TypeVar("_R")
_LOWERED = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")
"""From a power of ten as people read it to digits that are read as a number."""


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
        if role == Qt.ItemDataRole.UserRole:
            return entry
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


class _Sorted(QSortFilterProxyModel):
    """Rows in the order of the words of a column: numbers by size, before words, before what is not known."""

    def lessThan(self, left: Index, right: Index) -> bool:  # noqa: N802 - Qt's name
        """Return which of two cells comes first."""
        return sort_key(str(left.data())) < sort_key(str(right.data()))


def sort_key(words: str) -> tuple[int, float, str]:
    """Return what words are sorted by: "0.80 ± 0.01" by its number, then words, then dashes and nothing."""
    first = words.lstrip("(").replace(" × 10", "e").translate(_LOWERED).split(" ")[0]
    try:
        return 0, float(first), ""
    except ValueError:
        return (2, 0.0, "") if words in ("", UNKNOWN) else (1, 0.0, words)


class RowTable(QTableView, Generic[_R]):
    """Whole rows, nothing to edit; columns fit their words until the operator sets one of them.

    A click on a title sorts, a third one puts the rows back; Ctrl+C copies rows with their titles.

    Parameters
    ----------
    model
        The rows.
    name
        What the widths are remembered by.
    many
        Whether several rows can be selected.
    """

    def __init__(self, model: RowModel[_R], name: str, *, many: bool = False) -> None:
        super().__init__(showGrid=False, wordWrap=False)
        self.rows = model
        # else what listens to the rows keeps them, and they keep it
        model.setParent(self)
        self._sorted = _Sorted(self)
        self._sorted.setSourceModel(model)
        self.columns_chosen = self._fitting = False
        having(self, objectName=name, model=self._sorted, alternatingRowColors=True, tabKeyNavigation=False)
        self.setAccessibleName(name.replace(".", ": "))
        mode = self.SelectionMode.ExtendedSelection if many else self.SelectionMode.SingleSelection
        having(self, selectionBehavior=self.SelectionBehavior.SelectRows, selectionMode=mode)
        self.setEditTriggers(self.EditTrigger.NoEditTriggers)
        having(self.verticalHeader(), visible=False, defaultSectionSize=self.fontMetrics().height() + 8)
        header = having(self.horizontalHeader(), stretchLastSection=True, highlightSections=False)
        header.setDefaultAlignment(Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter)
        header.sectionResized.connect(self._resized)
        header.setSortIndicator(-1, Qt.SortOrder.AscendingOrder)
        header.setSortIndicatorClearable(True)
        self.setSortingEnabled(True)
        copies = self.addAction("Copy rows with headers", QKeySequence.StandardKey.Copy, self.copy_rows)
        copies.setShortcutContext(Qt.ShortcutContext.WidgetShortcut)
        self.setContextMenuPolicy(Qt.ContextMenuPolicy.ActionsContextMenu)

    @property
    def chosen(self) -> _R | None:
        """The selected row; of several the one that was chosen last."""
        rows = self.selectionModel().selectedRows()
        now = self.currentIndex().siblingAtColumn(0)
        return self._entry(now if now in rows else rows[0]) if rows else None

    @property
    def all_chosen(self) -> list[_R]:
        """Every selected row, in the order of the table."""
        rows = sorted(self.selectionModel().selectedRows(), key=QModelIndex.row)
        return [self._entry(one) for one in rows]

    def selectRow(self, row: int) -> None:  # noqa: N802 - Qt's name
        """Select one row and no other, whatever keys are held while a run comes in."""
        selection = self.selectionModel()
        flags = selection.SelectionFlag
        selection.setCurrentIndex(self.model().index(row, 0), flags.ClearAndSelect | flags.Rows)

    def choose(self, wanted: Callable[[_R], bool]) -> bool:
        """Select the first row that is wanted; return whether there is one."""
        row = next((number for number, one in enumerate(self.rows.entries) if wanted(one)), None)
        if row is not None:
            self.selectRow(self.shown_row(row))
        return row is not None

    def shown_row(self, row: int) -> int:
        """Return where a row of the model stands in the table as it is sorted."""
        return self._sorted.mapFromSource(self.rows.index(row, 0)).row()

    def copy_rows(self) -> None:
        """Put the selected rows, all where none is, with their titles on the clipboard: a spreadsheet takes them."""
        columns = [one for one in range(self._sorted.columnCount()) if not self.isColumnHidden(one)]
        chosen = [one.row() for one in self.selectionModel().selectedRows()] or range(self._sorted.rowCount())
        rows = sorted(row for row in chosen if not self.isRowHidden(row))
        across = Qt.Orientation.Horizontal
        lines = [[str(self._sorted.headerData(column, across)).replace("\n", " ") for column in columns]]
        lines += [[str(self._sorted.index(row, column).data() or "") for column in columns] for row in rows]
        QApplication.clipboard().setText("\n".join("\t".join(line) for line in lines) + "\n")

    def _entry(self, index: QModelIndex) -> _R:
        return self.rows.entries[self._sorted.mapToSource(index).row()]

    def show_rows(self, entries: Iterable[_R]) -> None:
        """Show other entries, in columns that fit them."""
        self.rows.replace_all(entries)
        self.fit_all()

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
            last, header = self.model().columnCount() - 1, self.horizontalHeader()
            # Qt would never make the last one, which takes what is left, narrower than a column is at first
            header.setStretchLastSection(False)
            self.resizeColumnsToContents()
            line = self.fontMetrics().height() if self.isSortingEnabled() else 0
            for column in range(last + 1):
                # Qt keeps room for a sign of sorting as wide as the title is high; in two lines half of that is enough
                if "\n" in str(self.model().headerData(column, Qt.Orientation.Horizontal)):
                    width = max(self.sizeHintForColumn(column), header.sectionSizeHint(column) - line)
                    self.setColumnWidth(column, width)
            self.setColumnWidth(last, min(self.columnWidth(last), header.defaultSectionSize()))
            header.setStretchLastSection(True)
            self._fitting = False

    def _resized(self, column: int, old: int, new: int) -> None:
        # the last one takes what room is left; to hide one is no width that the operator set
        if not self._fitting and old and new and column < self.model().columnCount() - 1:
            self.columns_chosen = True


class WordTable(RowTable[tuple[str, ...]]):
    """Rows of words under titles."""

    def __init__(self, titles: Sequence[str], name: str) -> None:
        columns = {title: itemgetter(at) for at, title in enumerate(titles)}
        super().__init__(RowModel[tuple[str, ...]](columns), name)
