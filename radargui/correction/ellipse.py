"""Correct a receiver by one ellipse: constant offset, gain ratio and quadrature error (Heydemann 1981)."""

from __future__ import annotations

import numpy as np

from radargui.conditioning.ellipse import Ellipse, fit_ellipse, no_ellipse
from radargui.model.arrays import BoolArray, FloatArray, order_statistics
from radargui.model.result import Segment

LEAST_ARC_RAD = np.pi
ARC_TURNS = 1.2
"""Turns of the circle at which the phase is off twice as far as its roundness says.

A conic through an arc takes a change of the echo's strength for another centre, and stays round. Of 207 receivers in
slow motions of the laboratory error over u was 7 below 0.7 turns, 3.5 below 0.9, 2.5 to 1.4, 1.4 to 2, 1.1 beyond:
1 + (1.2 / turns)^3 (decision 49).
"""


def correct_ellipse(
    pair_v: FloatArray, segment: Segment, usable: BoolArray | None = None
) -> tuple[FloatArray, Ellipse]:
    """Correct one receiver by the ellipse through the samples of its motion.

    Parameters
    ----------
    pair_v
        I and Q in volts, finite, shape (2, n_samples).
    segment
        The segment with motion.
    usable
        Samples that count, shape (n_samples,); None: all.

    Returns
    -------
    tuple
        I and Q in amplitudes, shape (2, n_samples), and the ellipse.

    Raises
    ------
    ProcessingError
        The motion turns the phase by less than half a fringe, or there is no signal.
    """
    moving = pair_v[:, segment.first : segment.last]
    if usable is not None and usable[segment.first : segment.last].any():
        # clipped crests would flatten the conic
        moving = moving[:, usable[segment.first : segment.last]]
    ellipse = fit_ellipse(moving)
    corrected = ellipse.apply(pair_v)
    # a conic fits every short arc: what it says of the rest of the circle is chance
    arc = np.unwrap(np.arctan2(corrected[1], corrected[0])[segment.first : segment.last])
    if np.ptp(arc) < LEAST_ARC_RAD:
        raise no_ellipse()
    return corrected, ellipse


def arc_over_roundness(phase_rad: FloatArray) -> float:
    """Return how many times as far off as its roundness says the phase of an arc (n,) may be."""
    known = phase_rad[np.isfinite(phase_rad)]
    if known.size == 0:
        return 1.0
    first, last = order_statistics(known, 0.005, 0.995)
    return float(1.0 + (2.0 * np.pi * ARC_TURNS / max(last - first, LEAST_ARC_RAD)) ** 3)
