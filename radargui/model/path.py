"""Path lengths: change of Tx - tracer - Rx against the rest before the motion."""

from dataclasses import dataclass

import numpy as np

from radargui.model.arrays import BoolArray, FloatArray, IntArray


@dataclass(frozen=True, slots=True)
class PathLengths:
    """Change of each receiver's path length.

    Attributes
    ----------
    time_s
        Shape (n_samples,).
    phase_rad
        Unwrapped, sign applied, 0 at rest, shape (n_receivers, n_samples); NaN where unknown.
    change_m
        wavelength * phase / (2 pi), shape (n_receivers, n_samples); NaN where unknown.
    u_m
        Standard uncertainty of `change_m`, same shape.
    valid
        Shape (n_receivers, n_samples).
    piece
        Number of the piece each sample belongs to, from 0, shape (n_samples,): it changes where a path was lost, and
        lengths of two pieces have no common zero. None: all is one piece.
    """

    time_s: FloatArray
    phase_rad: FloatArray
    change_m: FloatArray
    u_m: FloatArray
    valid: BoolArray
    piece: IntArray | None = None

    def restarts(self) -> IntArray:
        """Return the first sample of each piece but the first, shape (n_pieces - 1,)."""
        if self.piece is None:
            return np.empty(0, dtype=np.intp)
        # lengths of two pieces have no common zero: nothing may be differenced across one
        return np.flatnonzero(np.diff(self.piece)) + 1
