"""Compute the speed along a track for display: slopes of short parabolas that cross no impact and no gap."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from radargui.model.arrays import FloatArray, median
from radargui.motion.smoothing import savitzky_golay

WINDOW_S = 0.02
"""Of a parabola: in free flight it is exact for any length, and noise of 0.1 mm at 2 kS/s leaves 2 cm/s (by hand)."""
_FEWEST = 5  # points of a parabola, which has three unknowns: two are left against noise (chosen by hand)


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
    step = float(median(np.diff(time_s)))
    known = np.asarray(np.isfinite(position_m).all(axis=0))
    # times of a file are not quite even: a gap is more than a step and a half
    apart = np.flatnonzero((np.diff(known) != 0) | (np.diff(time_s) > 1.5 * step)) + 1
    edges = sorted({0, *apart.tolist(), *np.searchsorted(time_s, breaks_s).tolist(), time_s.size})
    for first, last in pairwise(edges):
        # between impacts near each other a shorter parabola, for none may reach across
        length = min(last - first, max(_FEWEST, round(WINDOW_S / step)))
        if known[first] and length >= _FEWEST:
            slopes = savitzky_golay(position_m[:, first:last], 2 * ((length - 1) // 2) + 1, derivative=1)
            speed[first:last] = np.linalg.norm(slopes, axis=0) / step
    return speed
