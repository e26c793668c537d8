"""The static ellipse: one offset, gain ratio and quadrature error for the whole motion (Heydemann 1981).

Method 2, ellipse.
"""

from __future__ import annotations

import numpy as np

from radargui.conditioning.ellipse import Ellipse, fit_ellipse, no_ellipse
from radargui.model.arrays import BoolArray, FloatArray
from radargui.model.result import Segment

LEAST_ARC_RAD = np.pi


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
