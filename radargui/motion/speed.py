"""Speed along a track, for the eye: slopes of short parabolas that never reach across an impact or a gap."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from radargui.model.arrays import FloatArray

WINDOW_S = 0.02
"""Of a parabola: in free flight it is exact for any length, and noise of 0.1 mm at 2 kS/s leaves 2 cm/s (by hand)."""
_FEWEST = 5


def speed_along(time_s: FloatArray, position_m: FloatArray, breaks_s: Sequence[float] = ()) -> FloatArray:
    """Return abs(v) along a track by local parabolas (Savitzky & Golay, Anal. Chem. 36, 1627, 1964).

    For pictures: no coefficient rests on it, impacts have their own speeds.

    Parameters
    ----------
    time_s
        Evenly spaced but for gaps, shape (n,).
    position_m
        Shape (3, n); NaN where unknown.
    breaks_s
        Instants that no parabola reaches across: impacts.

    Returns
    -------
    FloatArray
        In m/s, shape (n,); NaN where the position is unknown or fewer than five points lie together.
    """
    speed = np.full(time_s.size, np.nan)
    if time_s.size < _FEWEST:
        return speed
    step = float(np.median(np.diff(time_s)))
    known = np.asarray(np.isfinite(position_m).all(axis=0))
    apart = np.flatnonzero((np.diff(known) != 0) | (np.diff(time_s) > 1.5 * step)) + 1
    edges = sorted({0, *apart.tolist(), *np.searchsorted(time_s, breaks_s).tolist(), time_s.size})
    for first, last in pairwise(edges):
        length = min(last - first, max(_FEWEST, round(WINDOW_S / step)))
        if known[first] and length >= _FEWEST:
            slopes = _slopes(position_m[:, first:last], (length - 1) // 2)
            speed[first:last] = np.linalg.norm(slopes, axis=0) / step
    return speed


def _slopes(y: FloatArray, half: int) -> FloatArray:
    """Return the slope a step of parabolas through 2 half + 1 points, shape (3, n); at the ends of the last one."""
    k = np.arange(-half, half + 1)
    size, middle = y.shape[1], slice(half, y.shape[1] - half)
    # the slope in the middle of a parabola is that of the straight line
    slope = np.empty(y.shape)
    slope[:, middle] = [np.correlate(row, k / (k @ k), "valid") for row in y]
    for place, part, ends in (
        (slice(0, half), y[:, : k.size], k[:half]),
        (slice(size - half, size), y[:, -k.size :], k[half + 1 :]),
    ):
        _, linear, square = np.polynomial.polynomial.polyfit(k, part.T, 2)
        slope[:, place] = linear[:, None] + 2.0 * square[:, None] * ends
    return slope
