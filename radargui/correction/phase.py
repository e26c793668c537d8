"""Phase by arctangent, unwrapped by a threshold."""

from __future__ import annotations

import numpy as np

from radargui.model.arrays import FloatArray


def wrapped_phase(i: FloatArray, q: FloatArray) -> FloatArray:
    """Return arctan(Q / I) over the four quadrants, in rad (Rech & Huang 2019, eq. 1)."""
    return np.arctan2(q, i)


def unwrap(phase_rad: FloatArray, threshold_rad: float = np.pi) -> FloatArray:
    """Add multiples of 2 pi wherever the phase steps by more than the threshold; NaN are passed over.

    Parameters
    ----------
    phase_rad
        Wrapped, shape (n_receivers, n_samples).
    threshold_rad
        A larger step between neighbours is a wrap, not motion.
    """
    out = phase_rad.copy()
    for row in out:
        known = np.isfinite(row)
        row[known] = np.unwrap(row[known], discont=threshold_rad)
    return out
