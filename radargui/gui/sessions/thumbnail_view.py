"""Thumbnails of z(t), one a run, drawn only where they are seen."""

import numpy as np
from PySide6.QtCore import QPointF, QRectF, QSize, Qt
from PySide6.QtGui import QColor, QPainter, QPen, QPolygonF
from PySide6.QtWidgets import QListView, QListWidget, QListWidgetItem, QStyledItemDelegate, QStyleOptionViewItem

from radargui.files.run_card import Thumbnail
from radargui.gui.sessions.session_model import RunLook
from radargui.gui.table import Index
from radargui.gui.theme import Theme
from radargui.model.rounding import UNKNOWN

_WIDTH, _HEIGHT, _GAP = 148, 96, 5
"""Of a picture in pixels: six beside each other in the dialog, high enough to tell bounces apart (chosen by hand)."""


class ThumbnailView(QListWidget):
    """The runs of a session as pictures."""

    def __init__(self, theme: Theme) -> None:
        super().__init__()
        self.looks: tuple[RunLook, ...] = ()
        self.setItemDelegate(_Painter(theme, self))
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
        self.looks = runs
        self.clear()
        for look in runs:
            item = QListWidgetItem(look.entry.name, self)
            # a tool tip that looks like markup would be taken for it
            item.setToolTip(f"{look.entry.name}: {look.entry.verdict}".replace("<", "‹"))


class _Painter(QStyledItemDelegate):
    """Draws number, e and the curve."""

    def __init__(self, theme: Theme, view: ThumbnailView) -> None:
        super().__init__(view)
        self._theme, self._view = theme, view

    def sizeHint(self, _option: QStyleOptionViewItem, _index: Index) -> QSize:  # noqa: N802 - Qt's name
        """Return the size of one picture."""
        return QSize(_WIDTH, _HEIGHT)

    def paint(self, painter: QPainter, option: QStyleOptionViewItem, index: Index) -> None:
        """Draw one picture."""
        look = self._view.looks[index.row()]
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
