"""A list of rows to choose one from, whose columns the operator may set."""

from __future__ import annotations

from PySide6.QtCore import QAbstractItemModel, Qt
from PySide6.QtWidgets import QAbstractItemView, QHeaderView, QTableView


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

    def _resized(self, column: int, _old: int, _new: int) -> None:
        # the last one takes what room is left
        if not self._fitting and column < self.model().columnCount() - 1:
            self.columns_chosen = True
