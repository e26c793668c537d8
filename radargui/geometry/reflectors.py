"""Plane reflectors: an antenna seen in a mirror (image theory)."""

from __future__ import annotations

import numpy as np

from radargui.model.arrays import FloatArray


def mirror(point_m: FloatArray, normal: FloatArray, distance_m: float) -> FloatArray:
    """Return a' = a - 2 (n.a - d) n, the image of points in the plane n.x = d.

    Parameters
    ----------
    point_m
        Shape (..., 3).
    normal
        Unit vector, shape (3,).
    distance_m
        d of the plane.
    """
    height = np.asarray(point_m) @ normal - distance_m
    return np.asarray(point_m - 2.0 * height[..., None] * normal)
