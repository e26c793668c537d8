"""A plot with the window's look, explicit units, cached axes, no prefix that lies; and its key as words beside it."""

from html import escape
from typing import TypeVar

import pyqtgraph as pg
from PySide6.QtCore import Qt
from PySide6.QtGui import QColor
from PySide6.QtWidgets import QLabel

from radargui.gui.layout import TIPS, follow
from radargui.gui.theme import Theme

pg.setConfigOptions(antialias=False, useNumba=False, useOpenGL=False)


NOW = "time before now [s]"
LAST = "time before the last sample shown [s]"
"""While the picture is held, or nothing comes in any more, the right edge is not now."""


_Item = TypeVar("_Item", bound=pg.GraphicsObject)


class Plot(pg.PlotWidget):  # type: ignore[misc] # pyqtgraph has no types
    """A `PlotWidget` that follows the theme.

    Parameters
    ----------
    theme
        Gives the colours.
    bottom, left
        Axis labels with their units.
    left_px
        Width of the left axis, the same for plots beneath one another so that one instant stands above the other.
    equal
        One unit is as long on both axes.
    live
        For plots drawn many times a second: axes are cached and the mouse does not move them.
    """

    def __init__(
        self,
        theme: Theme,
        bottom: str = "",
        left: str = "",
        *,
        left_px: int | None = None,
        equal: bool = False,
        live: bool = False,
    ) -> None:
        super().__init__(enableMenu=not live)
        self._theme = theme
        self._labels = {"bottom": bottom, "left": left}
        self._inside: pg.LabelItem | None = None
        self._inside_text = ""
        self._pens: list[tuple[pg.GraphicsObject, str, bool]] = []
        item = self.getPlotItem()
        if live:
            item.hideButtons()
        # room for the outermost tick words, which are cut otherwise
        item.layout.setContentsMargins(2, 7, 14, 2)
        self.setAspectLocked(equal)
        self.setMouseEnabled(x=not live, y=not live)
        for name in ("bottom", "left"):
            axis = item.getAxis(name)
            # before any range is set: pyqtgraph keeps a scale that it found while the prefix was on
            axis.enableAutoSIPrefix(False)
            axis.setStyle(tickLength=-4)
            if live:
                axis.setCacheMode(axis.CacheMode.DeviceCoordinateCache)
        item.getAxis("left").setWidth(left_px)
        self.setToolTip(TIPS["plots"].get(left) or " against ".join(filter(None, (left, bottom))))
        # below that the words of the axes lie upon another: the panel scrolls instead
        self.setMinimumSize(80, 86 if bottom else 62)
        # no key does anything here
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        follow(theme.changed, self.retheme)

    def relabel(self, bottom: str) -> None:
        """Write other words to the lower axis."""
        if bottom != self._labels["bottom"]:
            self._labels["bottom"] = bottom
            self.getPlotItem().getAxis("bottom").setLabel(bottom)

    def write_inside(self, text: str) -> None:
        """Write a line into the upper left corner of the plot."""
        self._inside_text = text
        self._inside = pg.LabelItem(justify="left")
        self._inside.setParentItem(self.getPlotItem().getViewBox())
        self._inside.anchor((0.0, 0.0), (0.0, 0.0), offset=(2, -4))
        self._write_inside()

    def still_line(self, role: str, *, dashed: bool = False) -> pg.PlotDataItem:
        """Add an empty curve for data that stay, in the colour of a role of the theme (`i`, `receivers.0`, `fit`, ...).

        It is drawn fast at any zoom; NaN breaks the line.
        """
        curve = pg.PlotDataItem(connect="finite", autoDownsample=True, downsampleMethod="peak", clipToView=True)
        return self._add(curve, role, dashed=dashed)

    def fast_line(self, role: str, *, dashed: bool = False) -> pg.PlotCurveItem:
        """Add an empty curve for live data: no decimation of its own, NaN breaks the line."""
        return self._add(pg.PlotCurveItem(connect="finite"), role, dashed=dashed)

    def marker(self, role: str, symbol: str = "o", size: int = 8) -> pg.PlotDataItem:
        """Add an empty set of symbols."""
        return self._add(pg.PlotDataItem(pen=None, symbol=symbol, symbolSize=size), role)

    def rule(self, role: str, position: float, *, angle: int = 90, dashed: bool = True) -> pg.InfiniteLine:
        """Add a straight line across the plot."""
        return self._add(pg.InfiniteLine(position, angle=angle), role, dashed=dashed, ignoreBounds=True)

    def show_nothing(self) -> None:
        """Empty all curves; they stay for what comes."""
        for item in self.getPlotItem().listDataItems():
            item.clear()

    def take_all_out(self) -> None:
        """Take all curves and lines out."""
        self._pens.clear()
        self.getPlotItem().clear()

    def colour(self, role: str) -> str:
        """Return the colour of a role now."""
        return self._theme.colours.role(role)

    def retheme(self) -> None:
        """Take over the colours of the theme."""
        colours = self._theme.colours
        self.setBackground(colours.base)
        item = self.getPlotItem()
        for name, words in self._labels.items():
            axis = item.getAxis(name)
            axis.setPen(pg.mkPen(colours.line))
            axis.setTextPen(pg.mkPen(colours.text))
            if words:
                axis.setLabel(words)
        self._write_inside()
        for entry, role, dashed in self._pens:
            self._paint(entry, role, dashed=dashed)
        if item.legend is not None:
            item.legend.setLabelTextColor(colours.text)

    def _write_inside(self) -> None:
        colour = self._theme.colours.text
        if self._inside is not None:
            self._inside.setText(self._inside_text, color=colour, size="8pt")

    def _add(self, item: _Item, role: str, *, dashed: bool = False, **options: object) -> _Item:
        self.addItem(item, **options)
        self._pens.append((item, role, dashed))
        self._paint(item, role, dashed=dashed)
        return item

    def _paint(self, item: pg.GraphicsObject, role: str, *, dashed: bool) -> None:
        colour = QColor(self.colour(role))
        if isinstance(item, pg.PlotDataItem) and item.opts["symbol"] is not None:
            item.setSymbolBrush(colour)
            item.setSymbolPen(None)
            return
        # width 1 is ten times faster to draw than 2
        style = Qt.PenStyle.DashLine if dashed else Qt.PenStyle.SolidLine
        item.setPen(pg.mkPen(colour, width=1, style=style))


IQ_KEY = (("▬", "i", "I"), ("▬", "q", "Q"))


class Key(QLabel):
    """Signs in the colours of the theme, each with its words.

    Parameters
    ----------
    entries
        Sign, role of the theme's colours (`i`, `receivers.0`), words.
    """

    def __init__(self, theme: Theme, *entries: tuple[str, str, str]) -> None:
        super().__init__()
        self._theme = theme
        self._entries = entries
        self.setTextFormat(Qt.TextFormat.RichText)
        self.setContentsMargins(6, 0, 6, 0)
        self.setMinimumWidth(40)
        follow(theme.changed, self._write)

    def show_entries(self, *entries: tuple[str, str, str]) -> None:
        """Show another key."""
        if entries != self._entries:
            self._entries = entries
            self._write()

    def _write(self) -> None:
        parts = []
        for sign, role, words in self._entries:
            colour = self._theme.colours.role(role)
            parts.append(f'<span style="color:{colour}"><b>{escape(sign)}</b></span>&nbsp;{escape(words)}')
        self.setText("&emsp;".join(parts))
