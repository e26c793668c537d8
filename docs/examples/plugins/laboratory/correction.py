"""A correction of one's own: the circle through the largest and smallest voltages of each channel."""

from __future__ import annotations

import numpy as np

from radargui.model.arrays import BoolArray, FloatArray
from radargui.model.errors import ProcessingError
from radargui.model.result import Segment


def largest_circle(pair_v: FloatArray, segment: Segment, valid: BoolArray) -> FloatArray:
    """Return I and Q less the middle of their range in the motion, over half of it: (2 v - max - min) / (max - min).

    Parameters
    ----------
    pair_v
        I and Q of one receiver in V, shape (2, n_samples).
    segment
        Which samples hold the motion.
    valid
        Which samples are sound, shape (n_samples,).

    Raises
    ------
    ProcessingError
        A channel is dead; the receiver is rejected with this reason.
    """
    moving = np.where(valid, pair_v, np.nan)[:, segment.first : segment.last]
    high, low = np.nanmax(moving, axis=1, keepdims=True), np.nanmin(moving, axis=1, keepdims=True)
    if (high <= low).any():
        raise ProcessingError("a channel does not move")
    corrected: FloatArray = (2.0 * pair_v - high - low) / (high - low)
    return corrected
