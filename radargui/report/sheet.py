"""The paper: places of title and text in millimetres, colours, fonts and prefixes of units."""

from collections.abc import Sequence
from contextlib import AbstractContextManager
from functools import lru_cache
from pathlib import Path
from typing import Any, Literal, NamedTuple

import matplotlib as mpl
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties, findfont, get_font, get_font_names

from radargui.report.decimation import Curve

Paper = Literal["a4", "letter"]
PAPERS_MM: dict[Paper, tuple[float, float]] = {"a4": (210.0, 297.0), "letter": (215.9, 279.4)}
"""Width and height: ISO 216, and 8.5 by 11 inches (ANSI A)."""
_STYLE = Path(__file__).with_name("page.mplstyle")

I_COLOUR = "#0060a8"
Q_COLOUR = "#c8500a"
RAW_COLOUR = "#8c8c8c"
FIT_COLOUR = "#b0005a"
GAP_COLOUR = "#f2c14e"
RECEIVER_COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7")
"""Of Okabe and Ito: distinguished by colour-blind readers and in grey."""

_FONTS = ("Microsoft YaHei", "Yu Gothic", "Malgun Gothic", "PingFang SC", "Noto Sans CJK SC", "Noto Sans CJK JP")
"""Of Windows and macOS, then free ones."""


@lru_cache(maxsize=1)
def fonts() -> tuple[str, ...]:
    """Return the font that comes with matplotlib, and what the system has for scripts it lacks."""
    there = set(get_font_names())
    return ("DejaVu Sans", *(name for name in _FONTS if name in there))


def page_style() -> AbstractContextManager[None]:
    """Return the context in which all pages are made and saved; what is set outside of it stays as it was.

    The file is read here: where `rc_context` reads one it imports a module that warns, and suppresses the warning
    by filters that belong to all threads, so that it came through beside a thread that put back its own.
    """
    style = mpl.rc_params_from_file(_STYLE, use_default_template=False)
    settings: dict[Any, Any] = {name: value for name, value in mpl.rcParamsDefault.items() if name != "backend"}
    return mpl.rc_context({**settings, **style, "font.family": list(fonts())})


def scaled(unit: str, largest: float) -> tuple[float, str]:
    """Return the factor and the unit with the prefix that brings `largest` between 1 and 1000.

    Metres stay at mm from 1 mm to 10 m, as laboratories speak of them.
    """
    if unit == "m" and 1e-3 <= largest < 10.0:
        return 1e3, "mm"
    for factor, prefix in ((1.0, ""), (1e3, "m"), (1e6, "µ"), (1e9, "n")):
        if largest * factor >= 1.0:
            return factor, prefix + unit
    return (1.0, unit) if largest <= 0.0 else (1e12, "p" + unit)


LEFT_MM, RIGHT_MM, TOP_MM = 18.0, 12.0, 24.0
"""From the edges of the paper to the text (chosen by hand); the title of the page stands above the last."""
FOOT_MM = 9.0
"""Base line of the foot above the lower edge."""
ROOM_MM = PAPERS_MM["a4"][0] - LEFT_MM - RIGHT_MM
"""What text and figures are as wide as, on any paper."""
MM_PER_INCH = 25.4  # exact by definition (international inch of 1959)


class Area(NamedTuple):
    """A rectangle on a figure in mm: left and top from its upper left corner."""

    left: float
    top: float
    width: float
    height: float

    def inside(self, left: float, top: float, width: float, height: float) -> "Area":
        """Return a part of it, measured from its own corner."""
        return Area(self.left + left, self.top + top, width, height)

    @property
    def middle(self) -> tuple[float, float]:
        """Its middle, on the figure."""
        return self.left + 0.5 * self.width, self.top + 0.5 * self.height


def new_page(paper: Paper = "a4") -> Figure:
    """Return an empty page."""
    return new_figure(*PAPERS_MM[paper])


def new_figure(width_mm: float, height_mm: float) -> Figure:
    """Return an empty figure of this size."""
    return Figure(figsize=(width_mm / MM_PER_INCH, height_mm / MM_PER_INCH))


def size_mm(figure: Figure) -> tuple[float, float]:
    """Return width and height of a figure."""
    width, height = figure.get_size_inches()
    return float(width) * MM_PER_INCH, float(height) * MM_PER_INCH


def largest(curves: Sequence[Curve]) -> float:
    """Return the largest size of the known values of several curves."""
    return max((curve.largest for curve in curves), default=0.0)


@lru_cache(maxsize=2)
def _font_path(bold: bool) -> str:
    return str(findfont(FontProperties(family=fonts()[0], weight="bold" if bold else "normal")))


@lru_cache(maxsize=8192)
def _advance(character: str, bold: bool) -> float:
    """Return the width of one character in sizes of the font; what the font lacks counts as a square."""
    font = get_font(_font_path(bold))
    if ord(character) not in font.get_charmap():
        return 1.0
    font.set_size(100.0, 72.0)
    return float(font.load_char(ord(character)).linearHoriAdvance) / 65536.0 / 100.0


def width_mm(text: str, size: float, *, bold: bool = False) -> float:
    """Return the width of a line of text in a font size in points."""
    return sum(_advance(character, bold) for character in text) * size * (MM_PER_INCH / 72.0)


def wrapped(text: str, size: float, room_mm: float) -> list[str]:
    """Return the lines of a text that fit into a width; words longer than a line are cut."""
    lines: list[str] = []
    for paragraph in text.split("\n"):
        line = ""
        for word in paragraph.split():
            for piece in _pieces(word, size, room_mm):
                longer = f"{line} {piece}".strip()
                if line and width_mm(longer, size) > room_mm:
                    lines.append(line)
                    line = piece
                else:
                    line = longer
        lines.append(line)
    return lines


def _pieces(word: str, size: float, room_mm: float) -> list[str]:
    if width_mm(word, size) <= room_mm:
        return [word]
    pieces = [""]
    for character in word:
        if pieces[-1] and width_mm(pieces[-1] + character, size) > room_mm:
            pieces.append("")
        pieces[-1] += character
    return pieces


@lru_cache(maxsize=1)
def _characters() -> frozenset[int]:
    return frozenset(code for name in fonts() for code in get_font(findfont(FontProperties(family=name))).get_charmap())


def printable(text: str) -> str:
    """Return a text in which what no font here can draw is a question mark, and control characters are gone."""
    known = _characters()
    return "".join(
        character if character == "\n" or ord(character) in known else "?"
        for character in text
        if character == "\n" or character.isprintable()
    )
