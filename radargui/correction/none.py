"""No correction: the voltages as they are, brought to about unit size."""

from __future__ import annotations

import numpy as np

from radargui.model.arrays import FloatArray
from radargui.model.segment import Segment


def correct_none(pair_v: FloatArray, segment: Segment) -> FloatArray:
    """Return I and Q divided by their root-mean-square radius in the motion, shape (2, n_samples)."""
    moving = pair_v[:, segment.first : segment.last]
    radius = float(np.sqrt((moving**2).sum(axis=0).mean()))
    return pair_v / max(radius, 1e-300)
