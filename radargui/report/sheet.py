"""Paper: places in millimetres for title, axes and text; colours, fonts and prefixes of units."""

from collections.abc import Sequence
from contextlib import AbstractContextManager
from functools import lru_cache
from pathlib import Path
from typing import Any, Literal, NamedTuple

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties, findfont, get_font, get_font_names
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator
from matplotlib.transforms import Bbox

from radargui.report.curves import RunCurves
from radargui.report.decimation import Curve

Paper = Literal["a4", "letter"]
PAPERS_MM: dict[Paper, tuple[float, float]] = {"a4": (210.0, 297.0), "letter": (215.9, 279.4)}
_STYLE = Path(__file__).with_name("page.mplstyle")

I_COLOUR = "#0060a8"
Q_COLOUR = "#c8500a"
RAW_COLOUR = "#8c8c8c"
FIT_COLOUR = "#b0005a"
IMPACT_COLOUR = "#404040"
GAP_COLOUR = "#f2c14e"
RECEIVER_COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7")
"""Of Okabe and Ito: distinguished by colour-blind readers and in grey."""

_SYSTEM_FONTS = ("Microsoft YaHei", "Yu Gothic", "Malgun Gothic", "PingFang SC")
_FREE_FONTS = ("Noto Sans CJK SC", "Noto Sans CJK JP")


@lru_cache(maxsize=1)
def fonts() -> tuple[str, ...]:
    """Return the font that comes with matplotlib, and what the system has for scripts it lacks."""
    there = set(get_font_names())
    return ("DejaVu Sans", *(name for name in (*_SYSTEM_FONTS, *_FREE_FONTS) if name in there))


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
FOOT_MM = 9.0
"""Base line of the foot above the lower edge."""
ROOM_MM = PAPERS_MM["a4"][0] - LEFT_MM - RIGHT_MM
"""What text and figures are as wide as, on any paper."""
MM_PER_INCH = 25.4
_LABELS_MM = 12.0


class Area(NamedTuple):
    """A rectangle on a figure in mm: left and top from its upper left corner."""

    left: float
    top: float
    width: float
    height: float

    def inside(self, left: float, top: float, width: float, height: float) -> "Area":
        """Return a part of it, measured from its own corner."""
        return Area(self.left + left, self.top + top, width, height)


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


def figure_of(axes: Axes) -> Figure:
    """Return the figure that axes are on."""
    figure: Figure = axes.get_figure()  # type: ignore[assignment]  # they are on one
    return figure


def body(figure: Figure) -> Bbox:
    """Return the part of a page from the header down to the labels of its lowest axes, in inches: what HTML shows."""
    width_mm, height_mm = size_mm(figure)
    lowest_mm = min((axes.get_position().y0 for axes in figure.axes), default=0.0) * height_mm
    edges_mm = (2.0, max(lowest_mm - _LABELS_MM, 0.0), width_mm - 2.0, height_mm - TOP_MM + 4.0)
    return Bbox.from_extents(*(edge / MM_PER_INCH for edge in edges_mm))


def write(figure: Figure, x_mm: float, y_mm: float, text: str, **looks: Any) -> None:
    """Write text; x from the left, y from the top, at its base line. The text is never read as mathematics."""
    width_mm, height_mm = size_mm(figure)
    figure.text(x_mm / width_mm, 1.0 - y_mm / height_mm, text, parse_math=False, **looks)


def rule(figure: Figure, y_mm: float, length_mm: float = ROOM_MM, width: float = 0.5) -> None:
    """Draw a line from the left margin, y from the top; across the page where no length is given."""
    width_mm, height_mm = size_mm(figure)
    y = 1.0 - y_mm / height_mm
    ends = [LEFT_MM / width_mm, (LEFT_MM + length_mm) / width_mm]
    figure.add_artist(Line2D(ends, [y, y], transform=figure.transFigure, linewidth=width, color="#404040"))


def add_axes(figure: Figure, left_mm: float, top_mm: float, width_mm: float, height_mm: float) -> Axes:
    """Add axes whose frame has this place and size; left and top from the page's upper left corner."""
    whole_mm, high_mm = size_mm(figure)
    axes = figure.add_axes(
        (left_mm / whole_mm, 1.0 - (top_mm + height_mm) / high_mm, width_mm / whole_mm, height_mm / high_mm)
    )
    axes.xaxis.set_major_locator(MaxNLocator(_ticks(width_mm), steps=(1, 2, 5, 10)))
    axes.yaxis.set_major_locator(MaxNLocator(_ticks(height_mm), steps=(1, 2, 5, 10)))
    return axes


def _ticks(length_mm: float) -> int:
    """Return at most how many intervals an axis of this length is divided into."""
    return max(3, min(10, round(length_mm / 11.0)))


def add_rows(
    figure: Figure, count: int, top_mm: float, row_mm: float, space_mm: float, *columns: tuple[float, float]
) -> list[list[Axes]]:
    """Add rows of axes from `top_mm` on, each with its space `row_mm` high where the page has room, less where not.

    Parameters
    ----------
    columns
        Left and width of each, in mm.
    """
    height_mm = (min(size_mm(figure)[1] - 26.0 - top_mm, count * row_mm) + space_mm) / count - space_mm
    tops_mm = (top_mm + number * (height_mm + space_mm) for number in range(count))
    return [[add_axes(figure, left, top, width, height_mm) for left, width in columns] for top in tops_mm]


def draw_curve(axes: Axes, curve: Curve, factor: float = 1.0, **looks: Any) -> bool:
    """Draw a curve times `factor`; False where nothing of it is known."""
    if not np.isfinite(curve.y).any():
        return False
    axes.plot(curve.x, curve.y * factor, **looks)
    return True


def say_nothing_known(axes: Axes, text: str = "not known") -> None:
    """Write in the middle of axes that there is nothing to draw."""
    axes.set_yticks([])
    axes.text(0.5, 0.5, text, transform=axes.transAxes, ha="center", va="center", color="#808080")


def time_axis(axes: Axes, curves: RunCurves, *, labelled: bool = True) -> None:
    """Set the common time axis, shade lost samples, mark where a path was lost (a line) and the impacts (dashed)."""
    axes.set_xlim(*curves.span_s)
    for first, last in curves.gaps_s:
        if last > curves.span_s[0] and first < curves.span_s[1]:
            axes.axvspan(first, last, color=GAP_COLOUR, alpha=0.5, linewidth=0)
    for time_s in curves.restarts_s:
        axes.axvline(time_s, color=GAP_COLOUR, linewidth=1.0, zorder=1.0)
    axes.vlines(
        [time_s for time_s, _ in curves.impacts],
        0.0,
        1.0,
        transform=axes.get_xaxis_transform(),
        color=IMPACT_COLOUR,
        linewidth=0.4,
        linestyle=(0, (4, 3)),
        zorder=1.0,
    )
    if labelled:
        axes.set_xlabel(f"time after the {curves.since} / s")
    else:
        axes.tick_params(labelbottom=False)


def draw_panel(
    axes: Axes,
    curves: RunCurves,
    title: str,
    y_label: str,
    lines: Sequence[tuple[Curve, str, str]],
    *,
    unit: str = "",
    labelled: bool = True,
    from_zero: bool = False,
    first_width: float | None = None,
) -> float:
    """Draw curves against the common time, with title, name of the upright axis and legend; say so where none is known.

    Parameters
    ----------
    axes
        Where.
    curves
        Of the run: span, gaps, impacts.
    title, y_label
        Beside the axes; the unit follows the label.
    lines
        Each curve with its colour and its name in the legend.
    unit
        Of the curves, which get the prefix that suits them.
    labelled
        Whether the time axis has its name and numbers.
    from_zero
        Whether the upright axis begins at 0.
    first_width
        Of the first line in points, where it lies below the others.

    Returns
    -------
    float
        The factor that the curves were drawn with.
    """
    factor, prefixed = scaled(unit, largest([curve for curve, _, _ in lines])) if unit else (1.0, "")
    drawn = False
    for number, (curve, colour, name) in enumerate(lines):
        width = {"linewidth": first_width} if first_width and number == 0 else {}
        drawn |= draw_curve(axes, curve, factor, color=colour, label=name, **width)
    time_axis(axes, curves, labelled=labelled)
    axes.set_title(title)
    axes.set_ylabel(f"{y_label} / {prefixed}" if unit else y_label)
    legend(axes)
    if not drawn:
        say_nothing_known(axes)
    elif from_zero:
        axes.set_ylim(bottom=0.0)
    return factor


def largest(curves: Sequence[Curve]) -> float:
    """Return the largest size of the known values of several curves."""
    return max((curve.largest for curve in curves), default=0.0)


def legend(axes: Axes, *, raised: bool = False) -> None:
    """Put a legend above the frame at the right, where it hides no curve; raised: above the title too."""
    handles, names = axes.get_legend_handles_labels()
    if names:
        height_mm = axes.get_position().height * size_mm(figure_of(axes))[1]
        place = (1.0, 1.0 + 4.0 / height_mm * raised)
        axes.legend(handles, names, loc="lower right", bbox_to_anchor=place, ncols=len(names), columnspacing=1.0)


_MM_PER_POINT = 25.4 / 72.0


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
    return sum(_advance(character, bold) for character in text) * size * _MM_PER_POINT


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
