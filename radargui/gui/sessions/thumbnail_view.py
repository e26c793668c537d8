"""Thumbnails of z(t), one a run, drawn only where they are seen."""

from __future__ import annotations

from typing import Any

import numpy as np
from PySide6.QtCore import QAbstractListModel, QModelIndex, QPersistentModelIndex, QPointF, QRectF, QSize, Qt
from PySide6.QtGui import QColor, QPainter, QPen, QPolygonF
from PySide6.QtWidgets import QListView, QStyledItemDelegate, QStyleOptionViewItem, QWidget

from radargui.files.thumbnail import Thumbnail
from radargui.gui.sessions.session_look import RunLook
from radargui.gui.theme import Theme
from radargui.model.rounding import UNKNOWN

Index = QModelIndex | QPersistentModelIndex
_WIDTH, _HEIGHT, _GAP = 148, 96, 5


class ThumbnailView(QListView):
    """The runs of a session as pictures."""

    def __init__(self, theme: Theme) -> None:
        super().__init__()
        self.runs = _RunsModel()
        self.setModel(self.runs)
        self.setItemDelegate(_Painter(theme, self.runs, self))
        self.setViewMode(QListView.ViewMode.IconMode)
        self.setMovement(QListView.Movement.Static)
        self.setResizeMode(QListView.ResizeMode.Adjust)
        self.setUniformItemSizes(True)
        self.setSelectionMode(QListView.SelectionMode.NoSelection)
        self.setMinimumHeight(_HEIGHT + 2 * _GAP)
        self.setAccessibleName("Height against time of each run")
        theme.changed.connect(self.viewport().update)

    def show_runs(self, runs: tuple[RunLook, ...]) -> None:
        """Show other runs."""
        self.runs.show(runs)


class _RunsModel(QAbstractListModel):
    """The runs as Qt wants them."""

    def __init__(self) -> None:
        super().__init__()
        self.looks: tuple[RunLook, ...] = ()

    def show(self, looks: tuple[RunLook, ...]) -> None:
        """Show other runs."""
        self.beginResetModel()
        self.looks = looks
        self.endResetModel()

    def rowCount(self, parent: Index = QModelIndex()) -> int:  # noqa: N802, B008 - Qt's name and default
        """Return the number of runs."""
        return 0 if parent.isValid() else len(self.looks)

    def data(self, index: Index, role: int = Qt.ItemDataRole.DisplayRole) -> Any:
        """Return a run's name and verdict."""
        if not index.isValid():
            return None
        entry = self.looks[index.row()].entry
        if role == Qt.ItemDataRole.DisplayRole:
            return entry.name
        if role == Qt.ItemDataRole.ToolTipRole:
            return f"{entry.name}: {entry.verdict}".replace("<", "‹")
        return None


class _Painter(QStyledItemDelegate):
    """Draws number, e and the curve."""

    def __init__(self, theme: Theme, runs: _RunsModel, parent: QWidget) -> None:
        super().__init__(parent)
        self._theme = theme
        self._runs = runs

    def sizeHint(self, _option: QStyleOptionViewItem, _index: Index) -> QSize:  # noqa: N802 - Qt's name
        """Return the size of one picture."""
        return QSize(_WIDTH, _HEIGHT)

    def paint(self, painter: QPainter, option: QStyleOptionViewItem, index: Index) -> None:
        """Draw one picture."""
        look = self._runs.looks[index.row()]
        colours = self._theme.colours
        box = QRectF(option.rect).adjusted(_GAP, _GAP, -_GAP, -_GAP)
        painter.save()
        painter.setPen(QPen(QColor(colours.line)))
        painter.drawRect(box)
        line = painter.fontMetrics().height()
        head = box.adjusted(4, 1, -4, 0)
        head.setHeight(line + 2)
        painter.setPen(QColor(colours.text))
        painter.drawText(head, Qt.AlignmentFlag.AlignLeft, look.entry.cells()[0])
        e = look.entry.restitution().partition(" ± ")[0]
        e = "" if e == UNKNOWN else f"e = {e}"
        painter.drawText(head, Qt.AlignmentFlag.AlignRight, e)
        body = box.adjusted(4, line + 4, -4, -4)
        if look.thumbnail is None:
            painter.setPen(QColor(colours.faint))
            painter.drawText(body, Qt.AlignmentFlag.AlignCenter | Qt.TextFlag.TextWordWrap, look.entry.verdict)
        else:
            painter.setRenderHint(QPainter.RenderHint.Antialiasing)
            painter.setPen(QPen(QColor(colours.track), 1.3))
            for curve in curves(look.thumbnail, body):
                painter.drawPolyline(curve)
        painter.restore()


def curves(thumbnail: Thumbnail, box: QRectF) -> list[QPolygonF]:
    """Return z(t) scaled into a box, broken where it is unknown."""
    known = np.isfinite(thumbnail.z_m) & np.isfinite(thumbnail.time_s)
    if not known.any():
        return []
    t, z = thumbnail.time_s, thumbnail.z_m
    t0, t1 = float(t[known].min()), float(t[known].max())
    z0, z1 = float(z[known].min()), float(z[known].max())
    x = box.left() + box.width() * (t - t0) / ((t1 - t0) or 1.0)
    y = box.bottom() - box.height() * (z - z0) / ((z1 - z0) or 1.0)
    pieces = np.split(np.arange(t.size), np.flatnonzero(np.diff(known.astype(int))) + 1)
    return [QPolygonF([QPointF(x[k], y[k]) for k in piece]) for piece in pieces if known[piece[0]]]
