"""Phase by arctangent, unwrapped where it steps by more than half a turn."""

from __future__ import annotations

import numpy as np

from radargui.model.arrays import FloatArray


def wrapped_phase(i: FloatArray, q: FloatArray) -> FloatArray:
    """Return arctan(Q / I) over the four quadrants, in rad (Rech & Huang 2019, eq. 1)."""
    return np.arctan2(q, i)


def unwrap(phase_rad: FloatArray) -> FloatArray:
    """Add multiples of 2 pi wherever phases, shape (n_receivers, n_samples), step by more than half a turn.

    A larger step between neighbours is a wrap, not motion. NaN are passed over.
    """
    out = phase_rad.copy()
    for row in out:
        # from before a hole to behind it the shorter way is taken; what else it may be `join_pieces` decides
        known = np.isfinite(row)
        if known.all():
            _unwrap(row)
        else:
            row[known] = _unwrap(row[known])
    return out


def _unwrap(phase_rad: FloatArray) -> FloatArray:
    """Unwrap phases (n,) in place: numpy's `unwrap` looks at every sample several times, wraps are few."""
    step = np.diff(phase_rad)
    wrap = np.flatnonzero(np.abs(step) > np.pi)
    turns = np.cumsum(np.rint(step[wrap] / (2.0 * np.pi)))
    phase_rad[1:] -= 2.0 * np.pi * np.repeat(np.append(0.0, turns), np.diff(wrap, prepend=0, append=step.size))
    return phase_rad
