"""The runs of a session as thumbnails of z(t), and what is read of a run before it is opened."""

from contextlib import suppress
from pathlib import Path

import numpy as np
from PySide6.QtCore import QItemSelectionModel, QMargins, QPointF, QRectF, QSize, Qt
from PySide6.QtGui import QColor, QPainter, QPen, QPolygonF
from PySide6.QtWidgets import QListView, QStyle, QStyledItemDelegate, QStyleOptionViewItem

from radargui.files.run_card import Thumbnail, read_run_card, read_thumbnail
from radargui.gui.control.control_bar import wrapped
from radargui.gui.layout import having
from radargui.gui.runs.run_model import RunEntry
from radargui.gui.table import Index, RowModel, RowTable
from radargui.gui.theme import Theme, scaled_px, write
from radargui.model.errors import RadarGuiError
from radargui.model.rounding import UNKNOWN


def entry_of(path: Path) -> RunEntry:
    """Return what lists show of a run, read without its samples."""
    try:
        card = read_run_card(path)
    except RadarGuiError as error:
        return RunEntry(path, problem=str(error))
    problem = "" if card.finished else "not finished"
    picture = thumbnail_of(path)
    return RunEntry(path, card.started_at, card.summary or None, problem, origin=card.origin, thumbnail=picture)


def thumbnail_of(path: Path) -> Thumbnail | None:
    """Return z(t) of a run in small; None where there is none."""
    with suppress(RadarGuiError):
        return read_thumbnail(path)
    return None


_WIDTH, _HEIGHT, _GAP = 148, 96, 5
"""Of a picture in pixels at the usual font: six beside each other in the dialog, high enough to tell bounces apart
(chosen by hand).
"""


class ThumbnailView(QListView):
    """Runs as pictures, each with its number and e.

    Parameters
    ----------
    runs
        The runs, also as a table shows them; whose selection is shared where it has one.
    """

    def __init__(self, theme: Theme, runs: RowTable[RunEntry] | RowModel[RunEntry]) -> None:
        super().__init__()
        self.setItemDelegate(_Painter(theme, self))
        having(self, viewMode=self.ViewMode.IconMode, movement=self.Movement.Static, resizeMode=self.ResizeMode.Adjust)
        having(self, uniformItemSizes=True, selectionMode=self.SelectionMode.NoSelection)
        self.setAccessibleName("Height against time of each run")
        self.setModel(runs.model() if isinstance(runs, RowTable) else runs)
        if isinstance(runs, RowTable):
            self.setSelectionModel(runs.selectionModel())
            # the table knows whole rows alone
            mode, rows = self.SelectionMode.ExtendedSelection, self.SelectionBehavior.SelectRows
            having(self, selectionMode=mode, selectionBehavior=rows)
            self.addActions(runs.actions())
            # the arrow keys choose none that has the keys already, and Space starts
            select = QItemSelectionModel.SelectionFlag.ClearAndSelect | QItemSelectionModel.SelectionFlag.Rows
            self.activated.connect(lambda index: self.selectionModel().select(index, select))
            self.setContextMenuPolicy(Qt.ContextMenuPolicy.ActionsContextMenu)

    def minimumSizeHint(self) -> QSize:  # noqa: N802 - Qt's name
        """Return room for one picture."""
        return QSize(scaled_px(_WIDTH), scaled_px(_HEIGHT)).grownBy(QMargins(_GAP, _GAP, _GAP, _GAP))


class _Painter(QStyledItemDelegate):
    """Draws number, e and the curve."""

    def __init__(self, theme: Theme, view: ThumbnailView) -> None:
        super().__init__(view)
        self._theme = theme

    def sizeHint(self, _option: QStyleOptionViewItem, _index: Index) -> QSize:  # noqa: N802 - Qt's name
        """Return the size of one picture."""
        return QSize(scaled_px(_WIDTH), scaled_px(_HEIGHT))

    def paint(self, painter: QPainter, option: QStyleOptionViewItem, index: Index) -> None:
        """Draw one picture."""
        look: RunEntry = index.data(Qt.ItemDataRole.UserRole)
        colours = self._theme.colours
        box = QRectF(option.rect).adjusted(_GAP, _GAP, -_GAP, -_GAP)
        painter.save()
        chosen = bool(option.state & QStyle.StateFlag.State_Selected)
        painter.setPen(QPen(option.palette.highlight().color(), 3.0) if chosen else QPen(QColor(colours.line)))
        painter.drawRect(box)
        line = painter.fontMetrics().height()
        head = having(box.adjusted(4, 1, -4, 0), height=line + 2)
        e = look.restitution().partition(" ± ")[0]
        write(painter, head, look.cells[0], colours.text, int(Qt.AlignmentFlag.AlignLeft))
        write(painter, head, "" if e == UNKNOWN else f"e = {e}", colours.text, int(Qt.AlignmentFlag.AlignRight))
        body = box.adjusted(4, line + 4, -4, -4)
        if look.thumbnail is None:
            words = wrapped(look.verdict, painter.fontMetrics(), int(body.width()), int(body.height()))
            write(painter, body, words, colours.faint)
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
    x = box.left() + box.width() * (t - t[known].min()) / (float(np.ptp(t[known])) or 1.0)
    y = box.bottom() - box.height() * (z - z[known].min()) / (float(np.ptp(z[known])) or 1.0)
    pieces = np.split(np.arange(t.size), np.flatnonzero(np.diff(known.astype(int))) + 1)
    return [QPolygonF([QPointF(x[k], y[k]) for k in piece]) for piece in pieces if known[piece[0]]]
