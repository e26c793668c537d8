"""Where the words of a figure stand: none leaves it, and none lies on another."""

from __future__ import annotations

from itertools import combinations

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.transforms import Bbox

DPI = 200.0


def boxes_of(figure: Figure) -> list[tuple[Bbox, str]]:
    """Return where matplotlib writes each text, in pixels from the lower left corner, and the text."""
    figure.set_dpi(DPI)
    renderer = FigureCanvasAgg(figure).get_renderer()
    found = []

    def note(
        _gc: object, x: float, y: float, text: str, font: FontProperties, *_more: object, **_named: object
    ) -> None:
        wide, high, below = renderer.get_text_width_height_descent(text, font, False)
        if text.strip():
            found.append((Bbox.from_bounds(x, figure.bbox.height - y - below, wide, high), text))

    renderer.draw_text = note
    figure.draw(renderer)
    return found


def faults_of(figure: Figure) -> list[tuple[str, ...]]:
    """Return words that leave a figure, and pairs that lie on each other by more than a third of a point."""
    boxes, slack = boxes_of(figure), DPI / 216.0
    width, height = figure.bbox.width, figure.bbox.height
    outside = [
        (text,)
        for box, text in boxes
        if min(box.x0, box.y0) < -slack or box.x1 > width + slack or box.y1 > height + slack
    ]
    pairs = [(one, other, Bbox.intersection(a, b)) for (a, one), (b, other) in combinations(boxes, 2)]
    return outside + [(one, other) for one, other, both in pairs if both and min(both.width, both.height) > slack]
