"""How figures look on white paper: sizes, colours, axis prefixes."""

from __future__ import annotations

from contextlib import AbstractContextManager
from functools import lru_cache
from pathlib import Path

import matplotlib as mpl
from matplotlib.font_manager import get_font_names

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
