"""Lines and words handed to matplotlib's renderer as they are: artists of its own take a second for a full page."""

import re
from dataclasses import dataclass
from functools import lru_cache
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from matplotlib.artist import Artist
from matplotlib.backends.backend_pdf import Op
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.path import Path
from matplotlib.transforms import Bbox, IdentityTransform

from radargui.model.arrays import FloatArray
from radargui.report import sheet
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
                left, top, width, height = one.clip
                gc.set_clip_rectangle(
                    Bbox.from_bounds(left * scale, high - (top + height) * scale, width * scale, height * scale)
                )
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


class _Recorder:
    """Takes what is written to a page of a PDF."""

    def __init__(self) -> None:
        self.content = b""

    def write(self, data: bytes) -> None:
        self.content += data


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
        page, file.currentstream = file.currentstream, _Recorder()
        try:
            renderer.draw_text(gc, 0.0, 0.0, word.text, _font(word.size, word.bold), 0.0)
        finally:
            recorder, file.currentstream = file.currentstream, page
        known[key] = _TINY_KERN.sub(b"", recorder.content)
    file.output(Op.gsave, 1, 0, 0, 1, round(x, 2), round(y, 2), Op.concat_matrix)
    file.write(known[key])
    file.output(Op.grestore)


@lru_cache(maxsize=32)
def _font(size: float, bold: bool) -> FontProperties:
    return FontProperties(family=list(sheet.fonts()), size=size, weight="bold" if bold else "normal")
