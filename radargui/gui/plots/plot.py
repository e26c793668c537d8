"""A plot with the window's look, explicit units, cached axes, no prefix that lies; ranges that stay put."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any, NamedTuple, TypeVar

import numpy as np
import pyqtgraph as pg
from PySide6.QtCore import QEvent, QPointF, Qt
from PySide6.QtGui import QAction, QContextMenuEvent, QKeyEvent, QKeySequence, QShowEvent
from PySide6.QtWidgets import QApplication, QGraphicsItem, QMenu, QWidget

from radargui.gui.layout import TIPS, follow, having
from radargui.gui.mnemonics import letter_menu
from radargui.gui.plots.items import Axis, Band, Dot, ErrorBars, LiveCurve, Symbols
from radargui.gui.plots.tools import Cursors, picture_of, table_of, unit_of
from radargui.gui.plots.view import View
from radargui.gui.theme import LIGHT, Colours, Theme, inside_pt, scaled_px
from radargui.model.arrays import FloatArray

_STEPS = (1.0, 1.5, 2.0, 3.0, 5.0, 7.5, 10.0)
"""Round numbers in a decade, none above 5/3 of the one before: a range is never much larger than what it holds."""

LEAST = 1e-2
"""Half of a range at the least, in the unit that is shown (chosen by hand): around a speed of 0, or a dead input, finer
figures would be noise of the arithmetic, and have no room beside the axis."""


def round_up(value: float) -> float:
    """Return the next round number at or above a positive value."""
    if not math.isfinite(value) or value <= 0.0:
        return 1.0
    decade = 10.0 ** math.floor(math.log10(value))
    return next(step * decade for step in _STEPS if step * decade >= value * (1.0 - 1e-12))


class SteadyRange:
    """A range low..high around what is shown.

    Parameters
    ----------
    patience
        How many times in a row the shown values must be much smaller before the range shrinks.
    """

    def __init__(self, patience: int = 90) -> None:
        self._patience = patience
        self._small = 0
        self.centre = 0.0
        self.half = 0.0

    def fit(self, low: float, high: float) -> bool:
        """Fit the range to values low..high; return whether it changed."""
        if not (math.isfinite(low) and math.isfinite(high)):
            return False
        fits = self.centre - self.half <= low and high <= self.centre + self.half
        needed = 0.5 * (high - low) * 1.08
        if fits and self.half > 0.0:
            self._small = self._small + 1 if needed < 0.35 * self.half else 0
            if self._small < self._patience:
                return False
        self._small = 0
        half = round_up(max(needed, LEAST, 1e-4 * abs(high + low)))
        grid = half / 5.0
        centre = round(0.5 * (low + high) / grid) * grid
        changed = (centre, half) != (self.centre, self.half)
        self.centre, self.half = centre, half
        return changed

    @property
    def span(self) -> tuple[float, float]:
        """Lowest and highest shown value."""
        return self.centre - self.half, self.centre + self.half


class PerReceiver(QWidget):
    """A widget whose plots depend on how many receivers there are; what inherits from it makes them."""

    def __init__(self) -> None:
        super().__init__()
        self._count = self._made = 0

    def set_receivers(self, count: int) -> None:
        """Show so many receivers."""
        self._count = count
        if self.isVisible():
            self._make()

    def showEvent(self, event: QShowEvent) -> None:  # noqa: N802 - Qt's name
        """Make what is still missing."""
        super().showEvent(event)
        self._make()

    def make_plots(self, count: int) -> None:
        """Replace the plots there are by those of so many receivers."""
        raise NotImplementedError

    def _make(self) -> None:
        if self._made != self._count:
            self._made = self._count
            self.make_plots(self._count)


pg.setConfigOptions(antialias=False, useNumba=False, useOpenGL=False)

NOW = "time before now [s]"
LAST = "time to last sample [s]"
"""While the picture is held, or nothing comes in any more, the right edge is not now."""


_Item = TypeVar("_Item", bound=QGraphicsItem)
_ZOOMED = "zoomed; double click: all"


class _DrawnCurve(NamedTuple):
    """What a plot paints: in which colour, dashed or not, and what it is called in key and copied data."""

    item: QGraphicsItem
    role: str
    dashed: bool
    name: str


class Plot(pg.PlotWidget):  # type: ignore[misc] # pyqtgraph has no types
    """A `PlotWidget` that follows the theme; it zooms, has two cursors, and is copied as a picture and as data.

    The wheel and the keys + - and arrows zoom and move, a double click or Home shows all, C shows the cursors, Ctrl+C
    copies the picture and Ctrl+Shift+C the data; the menu of the right button has the same.

    Parameters
    ----------
    theme
        Gives the colours.
    bottom, left
        Axis labels with their units.
    left_px
        Width of the left axis at the usual font, the same for plots beneath one another so that one instant stands
        above the other.
    equal
        One unit is as long on both axes.
    live
        For plots drawn many times a second: axes are cached, and what is zoomed by hand stays so.
    density
        How close the figures of the left axis stand; less for low plots, several of which share a hand's breadth.
    figures_below
        Whether the lower axis has figures; not where those of a plot beneath are the same.

    Attributes
    ----------
    cursors
        The two; None while they are not shown.
    steady
        What `fit_y` keeps; put a new one to begin anew.
    when_empty
        What to do while it shows nothing; empty: what its panel says.
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
        density: float = 1.0,
        figures_below: bool = True,
    ) -> None:
        self.view = View(live=live)
        axes = {name: Axis(name) for name in ("left", "bottom", "right", "top")}
        super().__init__(viewBox=self.view, enableMenu=False, axisItems=axes)
        self._theme = theme
        self._paper: Colours | None = None
        self.cursors: Cursors | None = None
        self.steady = SteadyRange()
        self.when_empty = ""
        self._inside: pg.LabelItem | None = None
        self._inside_text = ""
        self._pens: list[_DrawnCurve] = []
        item = self.getPlotItem()
        item.hideButtons()
        for name in ("right", "top"):
            item.hideAxis(name)
        item.getAxis("bottom").setStyle(showValues=figures_below)
        # room for the outermost tick words, which are cut otherwise
        item.layout.setContentsMargins(2, 7, 14, 2 if figures_below else 7)
        self.setAspectLocked(equal)
        for name in ("bottom", "left"):
            axis = item.getAxis(name)
            axis.setStyle(tickLength=-4)
            if live:
                axis.setCacheMode(axis.CacheMode.DeviceCoordinateCache)
        width = None if left_px is None else scaled_px(left_px)
        having(item.getAxis("left"), width=width, tickDensity=density)
        self.setToolTip(TIPS["plots"].get(left) or " against ".join(filter(None, (left, bottom))))
        # below that the words of the axes lie upon another: the panel scrolls instead
        self.setMinimumSize(scaled_px(80), scaled_px(86 if bottom else 62 if figures_below else 46))
        # files that are dropped are the window's
        self.setAcceptDrops(False)
        # Tab goes through fields; a plot gets the keys by a click, or by its own key
        self.setFocusPolicy(Qt.FocusPolicy.ClickFocus)
        self.relabel(bottom, left)
        self._hint = self._corner(1.0, 4)
        self._hint.hide()
        self.view.zoom_changed.connect(self._show_hint)
        self.view.menu_asked.connect(lambda place: self.menu().exec(place))
        follow(theme.changed, self.retheme)

    def words(self, axis: str) -> str:
        """Return the words of the `left` or `bottom` axis; where none are written, those of the plot linked with it."""
        words = str(self.getPlotItem().getAxis(axis).labelText or "")
        linked = self.view.linkedView(0) if axis == "bottom" else None
        return str(linked.getViewWidget().words(axis)) if not words and linked is not None else words

    def curves(self) -> list[pg.GraphicsObject]:
        """Return what is drawn from points."""
        return [one.item for one in self._pens if isinstance(one.item, pg.PlotCurveItem | pg.PlotDataItem)]

    def points_of(self, item: pg.GraphicsObject) -> tuple[FloatArray, FloatArray]:
        """Return the points of a curve as they are drawn, on the axes."""
        return _arrays(*item.getData())

    def value_of(self, item: pg.GraphicsObject | None, y: float) -> float:
        """Return the value that a place on the left axis stands for, on a curve or beside all; NaN where none is."""
        del item
        return float(10.0**y if self.getPlotItem().getAxis("left").logMode else y)

    def also(self, value: float, axis: str = "bottom") -> str:
        """Return what else a value of the `bottom` or `left` axis means, for the words of the cursors."""
        del value, axis
        return ""

    def notes(self) -> Sequence[str]:
        """Return what is said above copied data."""
        return ()

    def data_of(self, item: pg.GraphicsObject) -> tuple[FloatArray, FloatArray]:
        """Return the data of a curve, all points in the units of the axes."""
        return _arrays(*(item.getOriginalDataset() if isinstance(item, pg.PlotDataItem) else item.getData()))

    def entries(self) -> list[tuple[str, str]]:
        """Return role and name of each curve that has a name and is shown."""
        named = ((one.role, one.name) for one in self._pens if one.name and self.data_of(one.item)[0].size)
        return list(dict.fromkeys(named))

    def columns(self) -> list[tuple[str, FloatArray]]:
        """Return the data as columns, each under its name; of a plot that is zoomed what is seen of them."""
        columns: list[tuple[str, FloatArray]] = []
        before: FloatArray | None = None
        low, high = self.view.viewRange()[0]
        behind = f" [{unit}]" if (unit := unit_of(self.words("left"))) else ""
        names = {one.item: one.name for one in self._pens}
        for item in self.curves():
            x, y = self.data_of(item)
            if not x.size:
                continue
            if self.view.zoomed:
                seen = (x >= low) & (x <= high)
                x, y = x[seen], y[seen]
            if before is None or not np.array_equal(before, x):
                columns.append((self.words("bottom") or "x", x))
            before = x
            columns.append((f"{names[item]}{behind}" if names[item] else self.words("left") or "y", y))
        return columns

    def copy_image(self) -> None:
        """Put the picture on the clipboard."""
        with self.on_paper():
            key = [(self.colour(role), name) for role, name in self.entries()]
            picture = picture_of(self, self.words("left"), key, self.colour("text"))
        QApplication.clipboard().setMimeData(picture)

    def copy_data(self) -> None:
        """Put the data on the clipboard."""
        QApplication.clipboard().setMimeData(table_of(self.columns(), self.notes()))

    def show_cursors(self, wanted: bool) -> None:
        """Show the two cursors, or take them away."""
        if wanted == (self.cursors is not None):
            return
        if self.cursors is not None:
            self.cursors.remove()
        self.cursors = Cursors(self.view, self) if wanted else None

    def measure(self, begin: QPointF, end: QPointF) -> None:
        """Put the cursors at both ends of what was dragged over: they say duration, frequency, difference and slope."""
        self.show_cursors(True)
        for number, place in enumerate((begin, end)):
            if self.cursors is not None:
                self.cursors.put(number, place.x(), place.y())

    def menu(self) -> QMenu:
        """Return a menu of what can be done with the plot."""
        menu = QMenu(self)
        menu.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self._entry(menu, "Show all (double click)", "Home", self.view.show_all).setEnabled(self.view.zoomed)
        cursors = self._entry(menu, "Two cursors", "C", lambda: self.show_cursors(self.cursors is None))
        having(cursors, checkable=True, checked=self.cursors is not None)
        menu.addSeparator()
        self._entry(menu, "Copy image", "Ctrl+C", self.copy_image)
        self._entry(menu, "Copy data", "Ctrl+Shift+C", self.copy_data)
        letter_menu(menu)
        return menu

    def contextMenuEvent(self, event: QContextMenuEvent) -> None:  # noqa: N802 - Qt's name
        """Show the menu at the key for it; the view answers the mouse."""
        if event.reason() == QContextMenuEvent.Reason.Keyboard:
            self.menu().exec(event.globalPos())

    def event(self, event: QEvent) -> bool:
        """Keep the plot's own keys from the shortcuts of the window."""
        if event.type() == QEvent.Type.ShortcutOverride and isinstance(event, QKeyEvent) and self._meant(event):
            event.accept()
            return True
        return bool(super().event(event))

    def keyPressEvent(self, event: QKeyEvent) -> None:  # noqa: N802 - Qt's name
        """Zoom, move, copy, show the cursors and move them."""
        does = self._meant(event)
        event.setAccepted(does is not None)
        if does is not None:
            does()

    def _meant(self, event: QKeyEvent) -> Callable[[], object] | None:
        """Return what a key does here; None where it means nothing."""
        key, mods = Qt.Key(event.key()), event.modifiers() & ~Qt.KeyboardModifier.KeypadModifier
        control, shift = Qt.KeyboardModifier.ControlModifier, Qt.KeyboardModifier.ShiftModifier
        if key == Qt.Key.Key_C:
            copies = {control: self.copy_image, control | shift: self.copy_data}
            return copies.get(mods) or (None if mods else lambda: self.show_cursors(self.cursors is None))
        if mods & ~shift:
            return None
        if self.cursors is not None and (does := self.cursors.meant(key, far=bool(mods))):
            return does
        return self.view.meant(key)

    def _show_hint(self) -> None:
        self._hint.setVisible(self.view.zoomed)

    def _entry(self, menu: QMenu, words: str, key: str, does: Callable[[], object]) -> QAction:
        action = menu.addAction(words, QKeySequence(key), does)
        # only said here: the plot hears its keys itself
        action.setShortcutContext(Qt.ShortcutContext.WidgetShortcut)
        return action

    def relabel(self, bottom: str | None = None, left: str | None = None) -> None:
        """Write other words to the axes for which they are given."""
        for name, words in (("bottom", bottom), ("left", left)):
            axis = self.getPlotItem().getAxis(name)
            if words is not None and words != axis.labelText:
                axis.setLabel(words)

    def write_inside(self, text: str) -> None:
        """Write a line into the upper left corner of the plot."""
        if text == self._inside_text:
            return
        self._inside_text = text
        self._inside = self._inside or self._corner(0.0, -4)
        self._write_inside()

    def _corner(self, place: float, offset_px: int) -> pg.LabelItem:
        """Return words for the left edge: in the upper corner (0) or the lower one (1)."""
        made = pg.LabelItem(justify="left")
        made.setParentItem(self.view)
        made.anchor((0.0, place), (0.0, place), offset=(2, offset_px))
        return made

    @property
    def height_inside(self) -> int:
        """Height of the line inside, in pixels."""
        return 0 if self._inside is None else round(self._inside.mapRectToParent(self._inside.boundingRect()).bottom())

    def still_line(self, role: str, name: str = "", *, dashed: bool = False) -> pg.PlotDataItem:
        """Add an empty curve for data that stay, in the colour of a role of the theme (`i`, `receivers.0`, `fit`, ...).

        It is drawn fast at any zoom; NaN breaks the line. The `name` stands in copied pictures and above copied data.
        """
        curve = pg.PlotDataItem(connect="finite", autoDownsample=True, downsampleMethod="peak", clipToView=True)
        return self._add(curve, role, name, dashed=dashed)

    def fast_line(self, role: str, name: str = "", *, dashed: bool = False) -> pg.PlotCurveItem:
        """Add an empty curve for live data: no decimation of its own, NaN breaks the line."""
        return self._add(LiveCurve(connect="finite"), role, name, dashed=dashed)

    def bars(self, role: str, name: str) -> ErrorBars:
        """Add bars about points."""
        return self._add(ErrorBars(connect="finite"), role, name)

    def dot(self, role: str, size: int = 7) -> Dot:
        """Add one point that moves, shown nowhere at first; it is no data and not copied as such."""
        return self._add(Dot(size), role, ignoreBounds=True)

    def marker(self, role: str, symbol: str = "o", size: int = 8, name: str = "") -> pg.PlotDataItem:
        """Add an empty set of symbols."""
        return self._add(Symbols(pen=None, symbol=symbol, symbolSize=size, symbolPen=None), role, name)

    def rule(self, role: str, position: float, *, angle: int = 90, dashed: bool = True) -> pg.InfiniteLine:
        """Add a straight line across the plot."""
        return self._add(pg.InfiniteLine(position, angle=angle), role, dashed=dashed, ignoreBounds=True)

    def band(self, role: str) -> Band:
        """Add an empty band around a curve."""
        return self._add(Band(), role)

    def fit_y(self, low: float, high: float) -> None:
        """Show low..high on the left axis, in round steps that stay put."""
        if self.steady.fit(low, high):
            self.setYRange(*self.steady.span, padding=0)

    def show_nothing(self) -> None:
        """Empty all curves; they stay for what comes."""
        for item in self.getPlotItem().listDataItems():
            item.clear()

    def take_all_out(self) -> None:
        """Take all curves and lines out, and the cursors."""
        self.show_cursors(False)
        self._pens.clear()
        self.getPlotItem().clear()

    def colour(self, role: str) -> str:
        """Return the colour of a role now."""
        return (self._paper or self._theme.colours).role(role)

    @contextmanager
    def on_paper(self) -> Iterator[None]:
        """Look as on white paper meanwhile, whatever the theme; nothing is drawn from a cache of pixels."""
        axes = [self.getPlotItem().getAxis(name) for name in ("bottom", "left")]
        modes = [axis.cacheMode() for axis in axes]
        self._paper = LIGHT
        self.retheme()
        self._hint.hide()
        for axis in axes:
            axis.setCacheMode(axis.CacheMode.NoCache)
        try:
            yield
        finally:
            self._paper = None
            self.retheme()
            self._show_hint()
            for axis, mode in zip(axes, modes, strict=True):
                axis.setCacheMode(mode)

    def retheme(self) -> None:
        """Take over the colours of the theme."""
        colours = self._paper or self._theme.colours
        self.setBackground(colours.base)
        for axis in map(self.getPlotItem().getAxis, ("bottom", "left", "top")):
            axis.setPen(pg.mkPen(colours.line))
            axis.setTextPen(pg.mkPen(colours.text))
        self._write_inside()
        self._hint.setText(_ZOOMED, color=colours.faint, size=f"{inside_pt()}pt")
        for one in self._pens:
            self._paint(one.item, one.role, dashed=one.dashed)
        if self.cursors is not None:
            self.cursors.retheme()

    def _write_inside(self) -> None:
        colour = self.colour("text")
        if self._inside is not None:
            self._inside.setText(self._inside_text, color=colour, size=f"{inside_pt()}pt")

    def _add(self, item: _Item, role: str, name: str = "", *, dashed: bool = False, **options: Any) -> _Item:
        self.addItem(item, **options)
        self._pens.append(_DrawnCurve(item, role, dashed, name))
        self._paint(item, role, dashed=dashed)
        return item

    def _paint(self, item: Any, role: str, *, dashed: bool) -> None:
        # width 1 is ten times faster to draw than 2
        style = Qt.PenStyle.DashLine if dashed else Qt.PenStyle.SolidLine
        item.setPen(pg.mkPen(self.colour(role), width=1, style=style))


def _arrays(x: Any, y: Any) -> tuple[FloatArray, FloatArray]:
    return (np.empty(0), np.empty(0)) if x is None else (np.asarray(x, float), np.asarray(y, float))
