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
        if known.all():
            _unwrap(row, threshold_rad)
        else:
            row[known] = _unwrap(row[known], threshold_rad)
    return out


def _unwrap(phase_rad: FloatArray, threshold_rad: float) -> FloatArray:
    """Unwrap phases (n,) in place: numpy's `unwrap` looks at every sample several times, wraps are few."""
    step = np.diff(phase_rad)
    wrap = np.flatnonzero(np.abs(step) > threshold_rad)
    turns = np.cumsum(np.rint(step[wrap] / (2.0 * np.pi)))
    phase_rad[1:] -= 2.0 * np.pi * np.repeat(np.append(0.0, turns), np.diff(wrap, prepend=0, append=step.size))
    return phase_rad
