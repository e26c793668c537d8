"""One A4 page: places in millimetres for title, axes and text; colours, fonts and prefixes of units."""

from collections.abc import Sequence
from contextlib import AbstractContextManager
from functools import lru_cache
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.font_manager import get_font_names
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator
from matplotlib.transforms import Bbox

from radargui.report.curves import Curve, RunCurves

A4_INCH = (8.27, 11.69)
_STYLE = Path(__file__).with_name("page.mplstyle")

I_COLOUR = "#0060a8"
Q_COLOUR = "#c8500a"
RAW_COLOUR = "#8c8c8c"
FIT_COLOUR = "#b0005a"
IMPACT_COLOUR = "#404040"
GAP_COLOUR = "#f2c14e"
RECEIVER_COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7")
"""Of Okabe and Ito: distinguished by colour-blind readers and in grey."""

_FALLBACK_FONTS = (
    "Microsoft YaHei",
    "Yu Gothic",
    "Malgun Gothic",
    "PingFang SC",
    "Noto Sans CJK SC",
    "Noto Sans CJK JP",
)


@lru_cache(maxsize=1)
def fonts() -> tuple[str, ...]:
    """Return the font that comes with matplotlib, and what the system has for scripts it lacks."""
    there = set(get_font_names())
    return ("DejaVu Sans", *(name for name in _FALLBACK_FONTS if name in there))


def page_style() -> AbstractContextManager[None]:
    """Return the context in which all pages are made and saved; what is set outside of it stays as it was."""
    return mpl.rc_context({"font.family": list(fonts())}, _STYLE)


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


WIDTH_MM, HEIGHT_MM = 210.0, 297.0
LEFT_MM, RIGHT_MM, TOP_MM = 18.0, 12.0, 24.0
ROOM_MM = WIDTH_MM - LEFT_MM - RIGHT_MM
MM_PER_INCH = 25.4
_LABELS_MM = 12.0


def new_page() -> Figure:
    """Return an empty A4 page."""
    return Figure(figsize=A4_INCH)


def body(figure: Figure) -> Bbox:
    """Return the part of a page from the header down to the labels of its lowest axes, in inches: what HTML shows."""
    lowest_mm = min((axes.get_position().y0 for axes in figure.axes), default=0.0) * HEIGHT_MM
    edges_mm = (2.0, max(lowest_mm - _LABELS_MM, 0.0), WIDTH_MM - 2.0, HEIGHT_MM - TOP_MM + 4.0)
    return Bbox.from_extents(*(edge / MM_PER_INCH for edge in edges_mm))


def write(figure: Figure, x_mm: float, y_mm: float, text: str, **looks: Any) -> None:
    """Write text; x from the left, y from the top, at its base line. The text is never read as mathematics."""
    figure.text(x_mm / WIDTH_MM, 1.0 - y_mm / HEIGHT_MM, text, parse_math=False, **looks)


def rule(figure: Figure, y_mm: float, length_mm: float = ROOM_MM, width: float = 0.5) -> None:
    """Draw a line from the left margin, y from the top; across the page where no length is given."""
    y = 1.0 - y_mm / HEIGHT_MM
    ends = [LEFT_MM / WIDTH_MM, (LEFT_MM + length_mm) / WIDTH_MM]
    figure.add_artist(Line2D(ends, [y, y], transform=figure.transFigure, linewidth=width, color="#404040"))


def add_axes(figure: Figure, left_mm: float, top_mm: float, width_mm: float, height_mm: float) -> Axes:
    """Add axes whose frame has this place and size; left and top from the page's upper left corner."""
    axes = figure.add_axes(
        (left_mm / WIDTH_MM, 1.0 - (top_mm + height_mm) / HEIGHT_MM, width_mm / WIDTH_MM, height_mm / HEIGHT_MM)
    )
    axes.xaxis.set_major_locator(MaxNLocator(_ticks(width_mm), steps=(1, 2, 5, 10)))
    axes.yaxis.set_major_locator(MaxNLocator(_ticks(height_mm), steps=(1, 2, 5, 10)))
    return axes


def _ticks(length_mm: float) -> int:
    """Return at most how many intervals an axis of this length is divided into."""
    return max(3, min(10, round(length_mm / 11.0)))


def rows_mm(count: int, top_mm: float, bottom_mm: float, space_mm: float) -> list[tuple[float, float]]:
    """Return top and height of `count` rows between two heights (from the page's top) with space between."""
    height = (bottom_mm - top_mm - (count - 1) * space_mm) / count
    return [(top_mm + number * (height + space_mm), height) for number in range(count)]


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


def time_axis(axes: Axes, curves: RunCurves, *, labelled: bool) -> None:
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


def label(axes: Axes, title: str, y_label: str, *, drawn: bool) -> None:
    """Write title, name of the upright axis and legend; say so where nothing was drawn."""
    axes.set_title(title)
    axes.set_ylabel(y_label)
    legend(axes)
    if not drawn:
        say_nothing_known(axes)


def largest(curves: Sequence[Curve]) -> float:
    """Return the largest size of the known values of several curves."""
    return max((curve.largest for curve in curves), default=0.0)


def legend(axes: Axes, *, raised: bool = False) -> None:
    """Put a legend above the frame at the right, where it hides no curve; raised: above the title too."""
    handles, names = axes.get_legend_handles_labels()
    if names:
        place = (1.0, 1.0 + 4.0 / (axes.get_position().height * HEIGHT_MM) * raised)
        axes.legend(handles, names, loc="lower right", bbox_to_anchor=place, ncols=len(names), columnspacing=1.0)
