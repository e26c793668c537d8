"""Path lengths: change of Tx - tracer - Rx against the rest before the motion."""

from __future__ import annotations

from dataclasses import dataclass

from radargui.model.arrays import BoolArray, FloatArray


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
    """

    time_s: FloatArray
    phase_rad: FloatArray
    change_m: FloatArray
    u_m: FloatArray
    valid: BoolArray
