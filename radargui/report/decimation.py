"""Decimate curves to what paper shows: the lowest and the highest point of each column."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from radargui.model.arrays import FloatArray, IntArray, extremes

COLUMNS = 500
"""One minimum and maximum each third of a millimetre across an A4 page."""
COMPACT = 150
"""The same across half a page."""


@dataclass(frozen=True, slots=True)
class Curve:
    """A polyline; NaN breaks it.

    Attributes
    ----------
    x, y
        Shape (n_points,).
    """

    x: FloatArray
    y: FloatArray

    @property
    def largest(self) -> float:
        """Largest size of a known y; 0 where none is known."""
        known = np.abs(self.y[np.isfinite(self.y)])
        return float(known.max(initial=0.0))


EMPTY = Curve(np.empty(0), np.empty(0))
"""Of no points: what stands where nothing is known."""


def envelope(x: FloatArray, y: FloatArray, breaks: Sequence[int] = (), columns: int = COLUMNS) -> Curve:
    """Keep the lowest and the highest point of each of `columns` equal shares of the samples, in their order.

    Parameters
    ----------
    x, y
        Shape (n_samples,); y may be NaN.
    breaks
        Indices before which samples were lost: the curve is broken there.
    columns
        Shares over the whole length.

    Returns
    -------
    Curve
        At most about 2 `columns` points; the curve itself where it is shorter than that.
    """
    size = max(1, -(-len(y) // columns))
    inside = sorted({place for place in breaks if 0 < place < len(y)})
    pieces = pairwise([0, *inside, len(y)])
    keep = np.concatenate([extremes(y[first:last], size) + first for first, last in pieces])
    at = np.searchsorted(keep, inside)
    return Curve(np.insert(x[keep], at, x[np.array(inside, np.intp)]), np.insert(y[keep], at, np.nan))


def every(count: int, points: int) -> IntArray:
    """Return about `points` indices spread evenly over `count` samples, ends included."""
    return np.unique(np.linspace(0, count - 1, min(count, points)).round().astype(np.intp))
