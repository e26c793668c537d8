"""What all figures share: sizes, style, colours and scales, and the small parts that several of them draw."""

import io
import re
from collections.abc import Iterable, Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.font_manager import get_font_names
from matplotlib.ticker import NullLocator

from radargui.model.arrays import FloatArray
from radargui.report.curves import Curve

TEXT_WIDTH_MM = 180.0
"""Of the text on A4 and Letter paper: a figure as wide as this is printed in its own size."""
PAGE_HEIGHT_MM = 225.0
"""Of a figure that has a page of its own on either paper."""
MM_PER_INCH = 25.4  # exact by definition (international inch of 1959)
I_COLOUR = "#0060a8"
Q_COLOUR = "#c8500a"
RAW_COLOUR = "#8c8c8c"
FIT_COLOUR = "#b0005a"
SCALE_COLOUR = "#009e73"
GAP_COLOUR = "#f2c14e"
FRAME_COLOUR = "#404040"
IMPACT_COLOUR = "#b8b8b8"
RECEIVER_COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7")
"""Of Okabe and Ito: distinguished by colour-blind readers and in grey."""
THIN, BROAD = 0.3, 0.6
"""Points: of lines that fill their frame, in a thicker one turns run together; and of the others (chosen by hand)."""
DASHED, DOTTED = (0.0, (3.0, 2.0)), (0.0, (1.0, 1.5))
"""As matplotlib takes lines and gaps."""
_MARGIN = 0.06
"""Of the range of curves, left free above and below (chosen by hand)."""
_SIZE = 6.5
"""Of words in a figure, in points; the style has the same."""
_LETTER_SHARE = 0.62
"""Width of a letter over the size of its font, on average (chosen by hand): for words beside each other."""
_PLACES, _DIGITS = re.compile(r' d="[^"]*"'), re.compile(r"(?<=\.\d\d)\d+")
"""Of paths in SVG: a hundredth of a point is not seen, and is written in half of the room."""
_STYLE = Path(__file__).with_name("page.mplstyle")
_FONTS = ("Microsoft YaHei", "Yu Gothic", "Malgun Gothic", "PingFang SC", "Noto Sans CJK SC", "Noto Sans CJK JP")
"""Of Windows and macOS, then free ones: for scripts that matplotlib's own font lacks."""
Span = tuple[float, float]


def page_style() -> AbstractContextManager[None]:
    """Return the context in which all figures are made and saved; what is set outside of it stays as it was.

    The file is read here: where `rc_context` reads one it imports a module that warns, and suppresses the warning
    by filters that belong to all threads, so that it came through beside a thread that put back its own.
    """
    style = mpl.rc_params_from_file(_STYLE, use_default_template=False)
    settings: dict[Any, Any] = {name: value for name, value in mpl.rcParamsDefault.items() if name != "backend"}
    there = set(get_font_names())
    family = ["DejaVu Sans", *(name for name in _FONTS if name in there)]
    return mpl.rc_context({**settings, **style, "font.family": family})


def new_figure(width_mm: float = TEXT_WIDTH_MM, height_mm: float = PAGE_HEIGHT_MM, **settings: Any) -> Figure:
    """Return an empty figure of this size; `settings` are those of matplotlib's `Figure`, such as its layout."""
    return Figure(figsize=(width_mm / MM_PER_INCH, height_mm / MM_PER_INCH), **settings)


def svg_of(figure: Figure) -> str:
    """Return a figure as SVG whose words are text in the fonts of the reader, and whose ground is the page's own."""
    text = io.StringIO()
    with mpl.rc_context({"svg.fonttype": "none"}):
        figure.savefig(text, format="svg", transparent=True, metadata={"Date": None, "Creator": None})
    return _PLACES.sub(lambda found: _DIGITS.sub("", found[0]), text.getvalue())


def scaled(unit: str, largest: float) -> tuple[float, str]:
    """Return the factor and the unit with the prefix that brings `largest` between 1 and 1000.

    Metres stay at mm from 1 mm to 10 m, as laboratories speak of them.
    """
    if unit == "m" and 1e-3 <= largest < 10.0:
        return 1e3, "mm"
    for number, prefix in enumerate(("", "m", "µ", "n", "p", "f", "a")):
        if largest * 10.0 ** (3 * number) >= 1.0:
            return 10.0 ** (3 * number), prefix + unit
    return 1.0, unit


def largest(curves: Iterable[Curve]) -> float:
    """Return the largest size of the known values of several curves."""
    return max((curve.largest for curve in curves), default=0.0)


def span_of(curves: Sequence[Curve], factor: float = 1.0) -> Span:
    """Return the range of the known values of curves times `factor`, and a margin; -1 to 1 where nothing is known."""
    known = np.concatenate([one.y[np.isfinite(one.y)] for one in curves] or [np.empty(0)])
    if known.size == 0:
        return -1.0, 1.0
    low, high = float(known.min()) * factor, float(known.max()) * factor
    room = _MARGIN * (high - low) or 0.5 * abs(high) or 1.0
    return low - room, high + room


def curve(axes: Axes, of: Curve, colour: str, width: float = BROAD, *, factor: float = 1.0, **looks: Any) -> bool:
    """Draw a curve times `factor`; False where nothing of it is known. `looks` are those of `Axes.plot`."""
    known = bool(np.isfinite(of.y).any())
    if known:
        axes.plot(of.x, of.y * factor, color=colour, linewidth=width, **looks)
    return known


def dots(axes: Axes, x: FloatArray, y: FloatArray, colour: str, size: float = 0.6) -> None:
    """Draw a dot of a size in points at each place: as one line, for as many markers would be as many elements."""
    # a line without length is not drawn
    ends = x + 1e-3 * float(np.ptp(axes.get_xlim()))
    across = np.stack([x, ends, np.full_like(x, np.nan)], axis=1).ravel()
    axes.plot(across, np.repeat(y, 3), color=colour, linewidth=size, solid_capstyle="round")


def key(axes: Axes, names: Sequence[tuple[str, str]]) -> None:
    """Write names in their colours above the right end of a frame, the last one outermost."""
    right = 0.0
    for name, colour in reversed(names):
        axes.annotate(
            name, (1.0, 1.0), (-right, 2.0), "axes fraction", "offset points", color=colour, ha="right", size=_SIZE
        )
        right += (len(name) + 1) * _LETTER_SHARE * _SIZE


def say(axes: Axes, text: str) -> None:
    """Write in the middle of a frame that there is nothing to draw."""
    axes.text(0.5, 0.5, text, transform=axes.transAxes, ha="center", va="center", color="#808080")


def without_numbers(axes: Axes) -> None:
    """Leave out ticks and numbers of the axis of x, which a frame below has too; ticks are what costs time."""
    axes.xaxis.set_major_locator(NullLocator())
    axes.xaxis.set_label_coords(0.5, 0.0)


_MAX_TICKS, _LOW_MM = 4, 30.0
"""Steps of an axis, of y half as many where a row is lower than this (chosen by hand)."""
_LEFT_MM, _RIGHT_MM, _TOP_MM, _BOTTOM_MM, _ACROSS_MM = 9.5, 2.0, 4.0, 7.5, 11.0
"""About the frames of a page: numbers of y, half of the last one of x, a title, numbers and name of x; between two."""


def frames(
    size_mm: tuple[float, float],
    rows: int = 1,
    columns: int = 1,
    *,
    fixed_mm: float | None = None,
    below_mm: float = 0.0,
    heights: Sequence[float] | None = None,
    widths: Sequence[float] | None = None,
) -> tuple[Figure, Any]:
    """Return a figure and its frames, an array of shape (rows, columns).

    Parameters
    ----------
    size_mm
        Width and height of the figure.
    rows, columns
        Of frames.
    fixed_mm
        Between two rows, with margins that are enough for numbers of four digits; None: matplotlib finds margins in
        which every number and name has its room, which takes it twice the time.
    below_mm
        What is left free under fixed frames.
    heights, widths
        Of rows and columns against each other.
    """
    figure = new_figure(*size_mm, layout=None if fixed_mm is not None else "constrained")
    ratios: dict[str, Any] = {"height_ratios": heights, "width_ratios": widths}
    if fixed_mm is not None:
        width, height = size_mm
        bottom = _BOTTOM_MM + below_mm
        inner = width - _LEFT_MM - _RIGHT_MM, height - _TOP_MM - bottom
        mean = (inner[0] - (columns - 1) * _ACROSS_MM) / columns, (inner[1] - (rows - 1) * fixed_mm) / rows
        ratios |= {"left": _LEFT_MM / width, "right": 1.0 - _RIGHT_MM / width, "wspace": _ACROSS_MM / mean[0]}
        ratios |= {"bottom": bottom / height, "top": 1.0 - _TOP_MM / height, "hspace": fixed_mm / mean[1]}
    made = figure.subplots(rows, columns, squeeze=False, gridspec_kw=ratios)
    for axes in made.flat:
        # half of the time of drawing goes with their number, and some with looking for a place for names of y
        if fixed_mm is not None:
            axes.yaxis.set_label_coords(0.0, 0.5)
        axes.locator_params("x", nbins=_MAX_TICKS + 1)
        axes.locator_params("y", nbins=_MAX_TICKS if size_mm[1] > rows * _LOW_MM else _MAX_TICKS // 2)
    return figure, made
