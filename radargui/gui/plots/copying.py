"""What is copied of a plot: its picture on white, as vectors and as pixels, and its data with names and units."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from PySide6.QtCore import QBuffer, QByteArray, QIODevice, QMarginsF, QMimeData, QRectF, QSize, QSizeF, Qt
from PySide6.QtGui import QColor, QImage, QPageSize, QPaintDevice, QPainter, QPdfWriter
from PySide6.QtSvg import QSvgGenerator

from radargui.model.arrays import FloatArray

if TYPE_CHECKING:
    from radargui.gui.plots.plot import Plot

_SCALE = 3
"""Pixels of the bitmap for one of the screen: 288 dots per inch at 96."""
_KEY_PX = 20
_SVG, _PDF = "image/svg+xml", "application/pdf"
_POINT = 0.75
"""Of a pixel at 96 to an inch."""


def picture_of(plot: Plot) -> QMimeData:
    """Return a plot in the light colours on white, with its key: as SVG, as PDF and as a bitmap."""
    size = QSize(plot.width(), plot.height() + _KEY_PX * bool(plot.entries()))
    data = QMimeData()
    with plot.on_paper():
        svg, pdf, image = QBuffer(), QBuffer(), QImage(size * _SCALE, QImage.Format.Format_RGB32)
        vector = QSvgGenerator()
        vector.setOutputDevice(svg)
        vector.setSize(size)
        vector.setViewBox(QRectF(0, 0, size.width(), size.height()))
        vector.setTitle(plot.words("left"))
        _paint(plot, vector, size)
        pdf.open(QIODevice.OpenModeFlag.WriteOnly)
        paper = QPdfWriter(pdf)
        paper.setResolution(96)
        paper.setPageMargins(QMarginsF())
        paper.setPageSize(QPageSize(QSizeF(size) * _POINT, QPageSize.Unit.Point))
        _paint(plot, paper, size)
        pdf.close()
        image.setDevicePixelRatio(_SCALE)
        image.fill(Qt.GlobalColor.white)
        _paint(plot, image, size)
    data.setData(_SVG, svg.data())
    data.setData(_PDF, pdf.data())
    data.setImageData(image)
    return data


def _paint(plot: Plot, device: QPaintDevice, size: QSize) -> None:
    painter = QPainter(device)
    painter.fillRect(QRectF(0, 0, size.width(), size.height()), Qt.GlobalColor.white)
    left, words = 8.0, painter.fontMetrics()
    for role, name in plot.entries():
        painter.fillRect(QRectF(left, _KEY_PX / 2 - 1, 16, 2), QColor(plot.colour(role)))
        painter.setPen(QColor(plot.colour("text")))
        painter.drawText(QRectF(left + 20, 0, size.width(), _KEY_PX), Qt.AlignmentFlag.AlignVCenter, name)
        left += 36 + words.horizontalAdvance(name)
    top = size.height() - plot.height()
    plot.render(painter, QRectF(0, top, plot.width(), plot.height()), plot.rect())
    painter.end()


def table_of(columns: Sequence[tuple[str, FloatArray]], notes: Sequence[str] = ()) -> QMimeData:
    """Return columns of any lengths, each under its name with its unit, as text with tabs; `notes` go before them."""
    length = max((values.size for _, values in columns), default=0)
    cells: Any = np.full((length, len(columns)), "", dtype=object)
    for place, (_, values) in enumerate(columns):
        cells[: values.size, place] = [f"{value:.9g}" for value in values]
    titles = [name for name, _ in columns]
    # two curves without a name, or with times of their own, are told apart all the same
    titles = [f"{name} ({n})" if (n := titles[: at + 1].count(name)) > 1 else name for at, name in enumerate(titles)]
    lines = [
        *(f"# {note}" for note in notes),
        "\t".join(titles),
        *("\t".join(row) for row in cells),
    ]
    data = QMimeData()
    data.setText("\n".join(lines) + "\n")
    data.setData("text/tab-separated-values", QByteArray(data.text().encode()))
    return data
