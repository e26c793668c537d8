"""Draw figures/phase_centre.svg: to which point of an antenna its distance is measured.

python docs/make_antenna_drawing.py
"""

from __future__ import annotations

from pathlib import Path

from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Arc, Polygon

PICTURE = Path(__file__).resolve().parent / "figures" / "phase_centre.svg"
APERTURE, BEHIND, HALF = 7.0, 1.3, 0.55
"""Distance of the aperture, of the phase centre behind it and half the aperture's width, in units of 10 cm."""


def draw() -> Figure:
    """Return the picture: a horn on its side, the centre of the field of view to the left of it."""
    figure = Figure(figsize=(8.0, 2.9))
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0), xlim=(-0.9, 9.9), ylim=(-2.1, 1.8))
    axes.axis("off")
    centre, apex = APERTURE + BEHIND, APERTURE + 1.9
    axes.add_patch(
        Polygon([(APERTURE, HALF), (APERTURE, -HALF), (apex, -0.12), (apex, 0.12)], fill=False, ec="#404040", lw=1.5)
    )
    axes.add_patch(
        Polygon([(apex, 0.12), (apex, -0.12), (apex + 0.6, -0.12), (apex + 0.6, 0.12)], fc="#c0c0c0", ec="#404040")
    )
    for radius in (2.0, 3.5, 5.0, 6.5):
        axes.add_patch(Arc((centre, 0.0), 2 * radius, 2 * radius, theta1=170.0, theta2=190.0, color="#6090c0", lw=1.0))
    axes.plot([0.0, centre], [0.0, 0.0], color="#909090", lw=0.8, ls=(0, (6, 4)))
    axes.plot([0.0], [0.0], "+", color="#202020", ms=12)
    axes.plot([centre], [0.0], "o", color="#c04020", ms=6)
    _label(axes, 0.0, 0.35, "centre of the\nfield of view")
    _label(axes, centre + 0.1, 0.75, "phase centre: where\nthe waves come from")
    _label(axes, APERTURE - 0.1, 0.75, "aperture")
    _measure(axes, 0.0, APERTURE, -0.9, "distance_m, to the middle of the aperture")
    _measure(axes, APERTURE, centre, -0.9, "phase_centre_m")
    _measure(axes, 0.0, centre, -1.6, "the distance that counts; without phase_centre_m distance_m is this one")
    return figure


def _label(axes: Axes, x: float, y: float, words: str) -> None:
    axes.text(x, y, words, ha="center", va="bottom", fontsize=9)


def _measure(axes: Axes, first: float, last: float, y: float, words: str) -> None:
    """Draw a length between two places along the axis, what it is called beneath."""
    axes.annotate("", (first, y), (last, y), arrowprops={"arrowstyle": "<|-|>", "color": "#404040", "lw": 0.9})
    for end in (first, last):
        axes.plot([end, end], [y - 0.1, -0.15], color="#b0b0b0", lw=0.6)
    axes.text(0.5 * (first + last), y - 0.12, words, ha="center", va="top", fontsize=9)


if __name__ == "__main__":
    # the same bytes from the same picture
    with rc_context({"svg.hashsalt": "radargui", "svg.fonttype": "none"}):
        draw().savefig(PICTURE, metadata={"Date": None})
