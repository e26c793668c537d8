"""Draw on a page: the canvas, and panels with axes, curves and names."""

import io
import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from matplotlib.artist import Artist
from matplotlib.backends.backend_pdf import Op
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.path import Path
from matplotlib.ticker import MaxNLocator
from matplotlib.transforms import Bbox, IdentityTransform

from radargui.model.arrays import FloatArray
from radargui.report import sheet
from radargui.report.decimation import Curve
from radargui.report.sheet import Area


@dataclass(frozen=True, slots=True)
class Line:
    """How a line looks: colour, width in points, dashes and gaps in points (none: drawn through)."""

    colour: str
    width: float = 0.5
    dashes: tuple[float, ...] = ()


@dataclass(frozen=True, slots=True)
class _Drawn:
    """Lines through places in mm from the upper left corner, shape (n, 2); NaN breaks them."""

    places: FloatArray
    line: Line
    clip: Area | None = None
    filled: bool = False
    codes: Any = None


@dataclass(frozen=True, slots=True)
class _Written:
    x: float
    y: float
    text: str
    size: float
    colour: str = "black"
    bold: bool = False


MARKS: tuple[tuple[tuple[float, float], ...], ...] = (
    (),
    ((-0.44, -0.44), (0.44, -0.44), (0.44, 0.44), (-0.44, 0.44)),
    ((0.0, -0.62), (0.62, 0.45), (-0.62, 0.45)),
    ((0.0, -0.66), (0.66, 0.0), (0.0, 0.66), (-0.66, 0.0)),
    ((0.0, 0.62), (0.62, -0.45), (-0.62, -0.45)),
)
"""Corners of marks in diameters of the first one, a dot; y downwards."""


class Canvas(Artist):
    """Lines and words on a figure, handed to the renderer as they are."""

    def __init__(self, figure: Figure) -> None:
        super().__init__()
        self._figure = figure
        self._drawn: list[_Drawn] = []
        self._written: list[_Written] = []
        figure.add_artist(self)

    def line(self, places: FloatArray, line: Line, clip: Area | None = None, **looks: Any) -> None:
        """Add a line through places in mm."""
        self._drawn.append(_Drawn(places, line, clip, **looks))

    def marks(self, places: FloatArray, colour: str, size: float, mark: int = 0, clip: Area | None = None) -> None:
        """Add a mark of a size in points at each known place in mm: a dot, or another of `MARKS`."""
        places = places[np.isfinite(places).all(axis=1)]
        if mark == 0:
            places = np.repeat(places, 2, axis=0)
            # a line without length is not drawn
            places[1::2, 0] += 0.04
            codes = np.tile(np.array([Path.MOVETO, Path.LINETO], np.uint8), len(places) // 2)
            self.line(places, Line(colour, size), clip, codes=codes)
            return
        shape = np.array([*MARKS[mark], (0.0, 0.0)]) * size * (sheet.MM_PER_INCH / 72.0)
        begun = [Path.MOVETO, *[Path.LINETO] * (len(shape) - 2), Path.CLOSEPOLY]
        corners = (places[:, None, :] + shape).reshape(-1, 2)
        self.line(corners, Line(colour, 0.0), clip, codes=np.tile(np.array(begun, np.uint8), len(places)), filled=True)

    def write(self, x: float, y: float, text: str, size: float, align: float = 0.0, **looks: Any) -> None:
        """Add text at its base line; `align` is the share of its width that lies left of x."""
        if align:
            x -= align * sheet.width_mm(text, size, bold=bool(looks.get("bold")))
        self._written.append(_Written(x, y, text, size, **looks))

    @property
    def words(self) -> list[tuple[float, float, float, str]]:
        """Where each word begins and ends, the height of its base line, in mm, and what it is."""
        width = sheet.width_mm
        return [(one.x, one.x + width(one.text, one.size, bold=one.bold), one.y, one.text) for one in self._written]

    def draw(self, renderer: Any) -> None:
        """Draw everything; called by matplotlib."""
        figure = self._figure
        scale = figure.dpi / sheet.MM_PER_INCH
        high = figure.bbox.height
        for one in self._drawn:
            gc = renderer.new_gc()
            gc.set_foreground(one.line.colour)
            gc.set_linewidth(one.line.width)
            gc.set_capstyle("round" if one.codes is not None else "butt")
            gc.set_joinstyle("bevel")
            # a dot on the grid of pixels would have no length
            gc.set_snap(False if one.codes is not None else None)
            if one.line.dashes:
                gc.set_dashes(0.0, one.line.dashes)
            if one.clip is not None:
                left, top, width, height = (mm * scale for mm in one.clip)
                gc.set_clip_rectangle(Bbox.from_bounds(left, high - top - height, width, height))
            # a tenth of a point is not seen, and is written in half of the room
            places = np.round(np.column_stack([one.places[:, 0] * scale, high - one.places[:, 1] * scale]), 1)
            renderer.draw_path(gc, Path(places, one.codes), IdentityTransform(), gc.get_rgb() if one.filled else None)
            gc.restore()
        for word in self._written:
            gc = renderer.new_gc()
            gc.set_foreground(word.colour)
            y = word.y * scale if renderer.flipy() else high - word.y * scale
            _draw_word(renderer, gc, word.x * scale, y, word)
            gc.restore()
        self.stale = False


_TINY_KERN = re.compile(rb"(?<!\\)\)\s+-?[01]\.\d+\s+\(")
"""Below two thousandths of the font's size, between almost all letters: half of a page's size."""
_recorded: WeakKeyDictionary[Any, dict[tuple[str, float, bool], bytes]] = WeakKeyDictionary()
"""For each PDF what it writes for a word at its origin: to lay one out takes a millisecond, and most come again."""


def _draw_word(renderer: Any, gc: Any, x: float, y: float, word: _Written) -> None:
    file: Any = getattr(renderer, "file", None)
    if file is None:
        renderer.draw_text(gc, x, y, word.text, _font(word.size, word.bold), 0.0)
        return
    renderer.check_gc(gc, gc.get_rgb())
    known = _recorded.setdefault(file, {})
    key = word.text, word.size, word.bold
    if key not in known:
        page, file.currentstream = file.currentstream, io.BytesIO()
        try:
            renderer.draw_text(gc, 0.0, 0.0, word.text, _font(word.size, word.bold), 0.0)
        finally:
            recorder, file.currentstream = file.currentstream, page
        known[key] = _TINY_KERN.sub(b"", recorder.getvalue())
    file.output(Op.gsave, 1, 0, 0, 1, round(x, 2), round(y, 2), Op.concat_matrix)
    file.write(known[key])
    file.output(Op.grestore)


@lru_cache(maxsize=32)
def _font(size: float, bold: bool) -> FontProperties:
    return FontProperties(family=list(sheet.fonts()), size=size, weight="bold" if bold else "normal")


SIZE = 6.0
"""Of all text in a panel, in points."""
_FRAME = "#404040"
_MARGIN = 0.06
"""Of the range of curves, left free above and below (chosen by hand)."""
_TICK_MM, _TITLE_MM = 0.8, 1.0
"""Length of the ticks, and the base line of the title above the frame (chosen by hand)."""
_KEY_LINE_MM, _KEY_GAP_MM = 3.6, 1.9
"""From where the piece of a line begins to the name behind it, and from that name to the next (chosen by hand)."""
_LINE_SHARE = 0.47
"""From one line of text to the next above a frame, in mm for each point of its size (chosen by hand)."""
_STEPS = (1, 2, 5, 10)
"""From tick to tick, times a power of ten; the last one is the first of the next decade."""
_MOST_DECIMALS = 6
"""Of a number at an axis (chosen by hand): more are written in powers of ten."""
Span = tuple[float, float]


def span_of(curves: Sequence[Curve], factor: float = 1.0) -> Span:
    """Return the range of the known values of curves times `factor`, and a margin; -1 to 1 where nothing is known."""
    known = np.concatenate([one.y[np.isfinite(one.y)] for one in curves] or [np.empty(0)])
    if known.size == 0:
        return -1.0, 1.0
    low, high = float(known.min()) * factor, float(known.max()) * factor
    room = _MARGIN * (high - low) or 0.5 * abs(high) or 1.0
    return low - room, high + room


@dataclass
class Panel:
    """One frame with its two axes; drawn by `frame`, once it is known how many lines of words stand above it.

    Parameters
    ----------
    canvas
        What it is drawn on.
    area
        The frame, without the words around it; its top comes down where title and key need more than one line.
    x, y
        First and last value of the axes.
    """

    canvas: Canvas
    area: Area
    x: Span
    y: Span
    size: float = SIZE
    _keys: list[tuple[str, Line, int | None]] = field(default_factory=list, init=False)
    _later: list[Callable[[], None]] = field(default_factory=list, init=False)

    def place(self, x: Any, y: Any) -> FloatArray:
        """Return where values lie, shape (n, 2), in mm."""
        (left, top, width, height), (x0, x1), (y0, y1) = self.area, self.x, self.y
        across = left + width * (np.asarray(x, np.float64) - x0) / (x1 - x0)
        # far outside is outside: a page knows no kilometres
        up = np.clip((np.asarray(y, np.float64) - y0) / (y1 - y0), -5.0, 6.0)
        return np.column_stack([across, top + height * (1.0 - up)])

    def curve(self, curve: Curve, line: Line, factor: float = 1.0, name: str = "") -> bool:
        """Draw a curve times `factor`; False where nothing of it is known."""
        known = bool(np.isfinite(curve.y).any())
        if known:
            self.later(lambda: self.canvas.line(self.place(curve.x, curve.y * factor), line, self.area))
            if name:
                self.key(name, line)
        return known

    def dots(self, x: FloatArray, y: FloatArray, colour: str, size: float = 0.35, mark: int = 0) -> None:
        """Draw a dot, or another of `MARKS`, at each place."""
        self.later(lambda: self.canvas.marks(self.place(x, y), colour, size, mark, self.area))

    def upright(self, times: Sequence[float], line: Line) -> None:
        """Draw a line from top to bottom at each of the values of x."""
        inside = [one for one in times if self.x[0] < one < self.x[1]]
        if inside:
            x = np.repeat(np.array(inside, np.float64), 3)
            y = np.tile(np.array([self.y[0], self.y[1], np.nan]), len(inside))
            self.later(lambda: self.canvas.line(self.place(x, y), line, self.area))

    def shade(self, first: float, last: float, colour: str) -> None:
        """Shade a range of x."""
        first, last = max(first, self.x[0]), min(last, self.x[1])
        if first < last:
            x, y = (first, last, last, first), (self.y[0], self.y[0], self.y[1], self.y[1])
            self.later(lambda: self.canvas.line(self.place(x, y), Line(colour, 0.0), self.area, filled=True))

    def later(self, draw: Callable[[], None]) -> None:
        """Draw something inside the frame, once it is known where that is."""
        self._later.append(draw)

    def key(self, name: str, line: Line, mark: int | None = None) -> None:
        """Name a line, or a line with marks, above the frame; the first one stands at the right."""
        self._keys.append((name, line, mark))

    def _head(self, title: str) -> None:
        """Write title and key above the frame: on one line where both fit, else the key below, and the frame lower."""
        left, top, width, height = self.area
        base, line_mm = top - _TITLE_MM, _LINE_SHARE * self.size
        keys = [
            (name, _KEY_LINE_MM + sheet.width_mm(name, self.size), line, mark)
            for full, line, mark in reversed(self._keys)
            for name in sheet.wrapped(full, self.size, width - _KEY_LINE_MM)[:1]
        ]
        titles = sheet.wrapped(title, self.size, width)
        for number, text in enumerate(titles):
            self.canvas.write(left, base + number * line_mm, text, self.size)
        used = sum(own + _KEY_GAP_MM for _, own, _, _ in keys)
        if len(titles) == 1 and sheet.width_mm(title, self.size) + used <= width:
            row, x = 0, left + width - used + _KEY_GAP_MM
        else:
            row, x = len(titles), left
        first = x
        for name, own, line, mark in keys:
            if x > first and x + own > left + width + 1e-6:
                row, x = row + 1, left
            y = base + row * line_mm
            self.canvas.write(x + _KEY_LINE_MM, y, name, self.size)
            y -= 0.1 * self.size
            self.canvas.line(np.array([[x, y], [x + 2.8, y]]), Line(line.colour, 0.8, line.dashes))
            if mark is not None:
                self.canvas.marks(np.array([[x + 1.4, y]]), line.colour, 0.5 * self.size, mark)
            x += own + _KEY_GAP_MM
        lower = max(row, len(titles) - 1) * line_mm
        self.area = self.area._replace(top=top + lower, height=height - lower)

    def clear(self, margin_mm: float) -> None:
        """Hide what lies below the frame and the words around it."""
        left, top, width, height = self.area
        x = np.array([left - margin_mm, left + width, left + width, left - margin_mm]) + 0.5
        y = np.array([top, top, top + height, top + height]) + np.array([-1.0, -1.0, 1.0, 1.0]) * 0.6 * margin_mm
        self.canvas.line(np.column_stack([x, y]), Line("white", 0.0), filled=True)

    def say(self, text: str) -> None:
        """Write in the middle that there is nothing to draw."""
        self.later(lambda: self.canvas.write(*self.area.middle, text, self.size, 0.5, colour="#808080"))

    def draw(self, title: str = "") -> None:
        """Draw what is inside, without a frame, below the words above it."""
        self._head(title)
        for one in self._later:
            one()

    def frame(self, title: str, label: str = "", *, ticks: bool = True, numbers: bool = True) -> None:
        """Draw the frame, its ticks and numbers, the title above and the name of the axis beneath.

        Parameters
        ----------
        title
            Above the frame.
        label
            Of the axis of x.
        ticks
            Whether there are any ticks.
        numbers
            Whether the axis of x has numbers.
        """
        self.draw(title)
        left, top, width, height = self.area
        bottom = top + height
        corners = np.array([[left, top], [left + width, top], [left + width, bottom], [left, bottom], [left, top]])
        marks: list[tuple[float, float]] = []
        if ticks:
            ticks_x = _ticks(self.x, max(2, min(6, round(width / 11.0))))
            at_x = self.place(ticks_x, np.full(len(ticks_x), self.y[0]))[:, 0].tolist()
            marks += [end for x in at_x for end in ((x, bottom), (x, bottom + _TICK_MM), (np.nan, np.nan))]
            for x, text in self._apart(at_x, ticks_x) if numbers else ():
                self.canvas.write(x, bottom + 0.48 * self.size, text, self.size, 0.5)
            ticks_y = _ticks(self.y, max(1, min(6, round(height / 6.0))))
            for value, text in zip(ticks_y, _numbers(ticks_y), strict=True):
                y = self.place([self.x[0]], [value])[0, 1]
                marks += [(left, y), (left - _TICK_MM, y), (np.nan, np.nan)]
                self.canvas.write(left - 1.2, y + 0.13 * self.size, text, self.size, 1.0)
            self.canvas.line(np.array(marks).reshape(-1, 2), Line(_FRAME, 0.5))
        self.canvas.line(corners, Line(_FRAME, 0.5))
        if label:
            self.canvas.write(left + 0.5 * width, bottom + 0.93 * self.size, label, self.size, 0.5)

    def _apart(self, at: list[float], values: list[float]) -> list[tuple[float, str]]:
        """Return the numbers of the axis of x with their places: of as many ticks as there is room for."""
        texts = _numbers(values)
        widest = max((sheet.width_mm(text, self.size) for text in texts), default=0.0)
        step = at[1] - at[0] if len(at) > 1 else np.inf
        every = next(n for n in (1, 2, 5, len(at) + 1) if n * step > widest + 0.6)
        # zero is one of them
        zero = min(range(len(at)), key=lambda number: abs(values[number]), default=0)
        return [
            (x, text) for number, (x, text) in enumerate(zip(at, texts, strict=True)) if not (number - zero) % every
        ]


def _ticks(span: Span, most: int) -> list[float]:
    """Return round values within a range."""
    low, high = span
    slack = 1e-9 * (high - low)
    found = MaxNLocator(most, steps=_STEPS).tick_values(low, high)
    return [float(one) for one in found if low - slack <= one <= high + slack]


def _numbers(values: Sequence[float]) -> list[str]:
    """Return the numbers of an axis, all with the decimals that their steps need."""
    step = min(np.diff(values), default=1.0)
    decimals = max(0, -math.floor(math.log10(step) + 1e-9))
    if decimals > _MOST_DECIMALS:
        return [f"{value:.6g}".replace("-", "−") for value in values]
    return [f"{value + 0.0:.{decimals}f}".replace("-", "−") for value in np.round(values, decimals)]
