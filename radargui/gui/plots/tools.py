"""What can be done with any plot: two cursors, and its picture and its numbers for the clipboard."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from functools import partial
from html import escape
from itertools import zip_longest
from typing import TYPE_CHECKING

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QBuffer, QIODevice, QMarginsF, QMimeData, QRectF, QSignalBlocker, QSize, QSizeF, Qt
from PySide6.QtGui import QColor, QImage, QPageSize, QPaintDevice, QPainter, QPdfWriter
from PySide6.QtSvg import QSvgGenerator
from PySide6.QtWidgets import QGraphicsView

from radargui.gui.layout import having
from radargui.gui.plots.view import View
from radargui.gui.theme import inside_pt
from radargui.model.arrays import FloatArray
from radargui.model.rounding import UNKNOWN

if TYPE_CHECKING:
    from radargui.gui.plots.plot import Plot

_UNIT = re.compile(r"\[([^\]]+)\]")
_REACH_PX = 12.0
"""A cursor this near to a curve stands on it: a hand holds the mouse to a few pixels (chosen by hand)."""
_PLACES = (0.1, 0.3)
"""Where the two stand at first, as shares of what is seen: beside the words in the upper right corner."""
_RATES = {"mm": ("m/s", 1e-3), "µm": ("m/s", 1e-6), "turns": ("Hz", 1.0), "m/s": ("m/s²", 1.0)}
"""What a change in a second is called, by the unit of what changes, and its scale."""
_FAR_PX = 10
"""Pixels that an arrow with Shift moves a cursor; without it one."""


def unit_of(words: str) -> str:
    """Return the unit that the words of an axis name in brackets; empty where they name none."""
    found = _UNIT.search(words)
    return found[1] if found else ""


class Cursors:
    """Crosses A and B that the mouse or the keys move; near a curve they stand on its samples.

    Parameters
    ----------
    view
        In which they stand.
    plot
        Of which it is the view; its axes give the units, and `value_of` the value of a curve that is drawn scaled.
    """

    def __init__(self, view: View, plot: Plot) -> None:
        self._view, self._plot = view, plot
        self._on: list[pg.GraphicsObject | None] = [None, None]
        self._chosen = 0
        self._words = pg.TextItem(anchor=(1, 0))
        self._words.setParentItem(self._view)
        self._words.setZValue(100)
        self.marks, self._lines = [], []
        for number in range(2):
            mark = pg.TargetItem(size=14, symbol="crosshair", label="AB"[number], movable=True)
            mark.setZValue(99)
            line = pg.InfiniteLine(angle=90, movable=False)
            for item in (line, mark):
                view.addItem(item, ignoreBounds=True)
            self.marks.append(mark)
            self._lines.append(line)
        (left, right), (low, high) = self._view.viewRange()
        for number, share in enumerate(_PLACES):
            self.put(number, left + share * (right - left), 0.5 * (low + high))
            self.marks[number].sigPositionChanged.connect(partial(self._moved, number))
            self._moved(number)
        self._view.sigResized.connect(self._write)
        self._view.sigRangeChanged.connect(self._write)
        self.retheme()

    @property
    def text(self) -> str:
        """What is said, as plain text."""
        return "\n".join(self._said())

    def put(self, number: int, x: float, y: float) -> None:
        """Put cursor 0 or 1 at a place of the axes; near a curve it stands on it."""
        self.marks[number].setPos(x, y)

    def meant(self, key: Qt.Key, *, far: bool) -> Callable[[], None] | None:
        """Return what a key does: A and B choose a cursor, the arrows move it; None where it means nothing here."""
        steps = {Qt.Key.Key_Left: (-1, 0), Qt.Key.Key_Right: (1, 0), Qt.Key.Key_Down: (0, -1), Qt.Key.Key_Up: (0, 1)}
        if key in (Qt.Key.Key_A, Qt.Key.Key_B):
            return partial(self._choose, int(key == Qt.Key.Key_B))
        return partial(self._step, *steps[key], _FAR_PX if far else 1) if key in steps else None

    def _choose(self, number: int) -> None:
        self._chosen = number

    def _step(self, across: int, up: int, pixels: int) -> None:
        pixel, place = self._view.viewPixelSize(), self.marks[self._chosen].pos()
        on = self._on[self._chosen]
        if across and on is not None:
            # from sample to sample of the curve it stands on
            x, y = self._plot.points_of(on)
            order = np.flatnonzero(np.isfinite(x) & np.isfinite(y))
            order = order[np.argsort(x[order], kind="stable")]
            at = int(np.searchsorted(x[order], place.x()))
            every = max(1, round(pixels * pixel[0] * order.size / max(float(np.ptp(x[order])), 1e-300)))
            at = int(order[min(max(at + across * every, 0), order.size - 1)])
            self.put(self._chosen, float(x[at]), float(y[at]))
        else:
            self.put(self._chosen, place.x() + across * pixels * pixel[0], place.y() + up * pixels * pixel[1])

    def retheme(self) -> None:
        """Take over the colours of the theme."""
        colour = QColor(self._plot.colour("text"))
        for mark, line in zip(self.marks, self._lines, strict=True):
            for paint in (mark.setPen, mark.setHoverPen):
                paint(pg.mkPen(colour, width=2))
            mark.label().setColor(colour)
            line.setPen(pg.mkPen(colour, style=Qt.PenStyle.DotLine))
        self._write()

    def remove(self) -> None:
        """Take them away."""
        for item in (*self.marks, *self._lines):
            self._view.removeItem(item)
        self._view.sigResized.disconnect(self._write)
        self._view.sigRangeChanged.disconnect(self._write)
        self._view.scene().removeItem(self._words)

    def _moved(self, number: int, _mark: object = None) -> None:
        mark = self.marks[number]
        self._on[number], x, y = self._nearest(mark.pos().x(), mark.pos().y())
        with QSignalBlocker(mark):
            mark.setPos(x, y)
        self._lines[number].setValue(x)
        self._write()

    def _nearest(self, x: float, y: float) -> tuple[pg.GraphicsObject | None, float, float]:
        """Return the curve within reach of a place and its nearest point; no curve and the place itself without."""
        pixel_x, pixel_y = self._view.viewPixelSize()
        best, place = _REACH_PX, (None, x, y)
        for item in self._plot.curves():
            xs, ys = self._plot.points_of(item)
            far = np.nan_to_num(np.hypot((xs - x) / pixel_x, (ys - y) / pixel_y), nan=np.inf)
            if far.min(initial=best) < best:
                at = int(far.argmin())
                best, place = float(far[at]), (item, float(xs[at]), float(ys[at]))
        return place

    def _said(self) -> list[str]:
        plot = self._plot
        x_unit, y_unit = unit_of(plot.words("bottom")), unit_of(plot.words("left"))
        pixel_x, pixel_y = self._view.viewPixelSize()
        lines, places = [], []
        for number, mark in enumerate(self.marks):
            x, y = mark.pos().x(), plot.value_of(self._on[number], mark.pos().y())
            places.append((x, y))
            across, up = _said(x, pixel_x, x_unit), _said(y, pixel_y, y_unit)
            lines.append(f"{'AB'[number]}  {across}{plot.also(x)}   {up}{plot.also(y, 'left')}")
        dx, dy = (b - a for a, b in zip(*places, strict=True))
        also = f" = {abs(1.0 / dx):.4g} Hz" if x_unit == "s" and dx else plot.also(dx)
        unit, scale = _RATES.get(y_unit, ("", 0.0)) if x_unit == "s" and dx else ("", 0.0)
        slope = f"   {scale * dy / dx:+.4g} {unit}" if unit else ""
        across, up = _said(dx, pixel_x, x_unit), _said(dy, pixel_y, y_unit)
        lines.append(f"B−A  {across}{also}   {up}{plot.also(dy, 'left')}{slope}")
        return lines

    def _write(self, *_: object) -> None:
        colours, behind = self._plot.colour, QColor(self._plot.colour("raised"))
        paper = f"rgba({behind.red()}, {behind.green()}, {behind.blue()}, 75%)"
        lines = "<br>".join(escape(line).replace(" ", "&nbsp;") for line in self._said())
        look = f"background:{paper}; color:{colours('text')}; font-size:{inside_pt()}pt"
        self._words.setHtml(f'<div style="{look}">{lines}</div>')
        self._words.setPos(self._view.width() - 2, 2)


def _said(value: float, pixel: float, unit: str) -> str:
    """Return a value to a pixel, with its unit."""
    if not math.isfinite(value):
        return UNKNOWN
    digits = min(9, max(0, 1 - math.floor(math.log10(pixel)))) if pixel > 0.0 and math.isfinite(pixel) else 3
    return f"{value:.{digits}f} {unit}".rstrip()


_SCALE = 3
"""Pixels of the bitmap for one of the screen: 288 dots per inch at 96."""
_KEY_PX = 20
"""Height of the key above a copied plot: a line of its font and some room (chosen by hand)."""
_SVG, _PDF = "image/svg+xml", "application/pdf"
_POINT = 0.75
"""Of a pixel at 96 to an inch."""


def picture_of(plot: QGraphicsView, title: str, key: Sequence[tuple[str, str]], text: str) -> QMimeData:
    """Return a plot on white, with a key: as SVG, as PDF and as a bitmap.

    Parameters
    ----------
    plot
        Looks as on paper already.
    title
        Of the SVG.
    key
        Colour and name of each curve.
    text
        Colour of the names.
    """
    size, data = QSize(plot.width(), plot.height() + _KEY_PX * bool(key)), QMimeData()
    svg, pdf, image = QBuffer(), QBuffer(), QImage(size * _SCALE, QImage.Format.Format_RGB32)
    whole = QRectF(0, 0, size.width(), size.height())

    def paint(device: QPaintDevice) -> None:
        painter = QPainter(device)
        painter.fillRect(whole, Qt.GlobalColor.white)
        left, words = 8.0, painter.fontMetrics()
        for colour, name in key:
            painter.fillRect(QRectF(left, _KEY_PX / 2 - 1, 16, 2), QColor(colour))
            painter.setPen(QColor(text))
            painter.drawText(QRectF(left + 20, 0, size.width(), _KEY_PX), Qt.AlignmentFlag.AlignVCenter, name)
            left += 36 + words.horizontalAdvance(name)
        top = size.height() - plot.height()
        plot.render(painter, QRectF(0, top, plot.width(), plot.height()), plot.rect())
        painter.end()

    paint(having(QSvgGenerator(), outputDevice=svg, size=size, viewBox=whole, title=title))
    pdf.open(QIODevice.OpenModeFlag.WriteOnly)
    page = QPageSize(QSizeF(size) * _POINT, QPageSize.Unit.Point)
    paint(having(QPdfWriter(pdf), resolution=96, pageMargins=QMarginsF(), pageSize=page))
    pdf.close()
    image.setDevicePixelRatio(_SCALE)
    image.fill(Qt.GlobalColor.white)
    paint(image)
    data.setData(_SVG, svg.data())
    data.setData(_PDF, pdf.data())
    data.setImageData(image)
    return data


def table_of(columns: Sequence[tuple[str, FloatArray]], notes: Sequence[str] = ()) -> QMimeData:
    """Return columns of any lengths, each under its name with its unit, as text with tabs; `notes` go before them."""
    cells = zip_longest(*([f"{value:.9g}" for value in values] for _, values in columns), fillvalue="")
    titles = [name for name, _ in columns]
    # two curves without a name, or with times of their own, are told apart all the same
    titles = [f"{name} ({n})" if (n := titles[: at + 1].count(name)) > 1 else name for at, name in enumerate(titles)]
    lines = (*(f"# {note}" for note in notes), *map("\t".join, (titles, *cells)))
    data = QMimeData()
    data.setText("\n".join(lines) + "\n")
    data.setData("text/tab-separated-values", data.text().encode())
    return data
