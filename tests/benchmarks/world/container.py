"""A container of foam: its walls stand in the rays to the receivers and delay them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import fresnel

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True)
class Container:
    """Upright walls around the origin, along x and y, open above.

    Attributes
    ----------
    inner_m
        Inner lengths along x and y.
    wall_m, index
        Thickness and refractive index of the walls.
    rim_z_m
        Height of their upper edge.
    """

    inner_m: tuple[float, float]
    wall_m: float
    index: float
    rim_z_m: float

    def delay(self, antenna_m: Array, position_m: Array, wavenumber_rad_m: float) -> Complex:
        """Return the factor of the straight way between positions (3, n) and an antenna (3,), shape (n,).

        Through a wall the way is longer by (n - 1) d / cos; near the upper edge the part F of the wave that goes
        through it is that of a half-plane (Born & Wolf, section 8.7.3): 1 + (exp(i K delta) - 1) F(v), v the height
        of the edge over the ray times sqrt(2 (1 / r + 1 / r') / wavelength). Refraction is of second order in n - 1.
        """
        way = antenna_m[:, None] - position_m
        length = np.linalg.norm(way, axis=0)
        half = 0.5 * np.array(self.inner_m)[:, None]
        # which share of the way each pair of walls is reached at
        reached = (np.copysign(half, way[:2]) - position_m[:2]) / np.where(way[:2] == 0.0, np.inf, way[:2])
        wall = np.argmin(np.where(reached > 0.0, reached, np.inf), axis=0)
        share = np.clip(np.take_along_axis(reached, wall[None], axis=0)[0], 1e-6, 1.0)
        cosine = np.abs(np.take_along_axis(way, wall[None], axis=0)[0]) / length
        above = self.rim_z_m - (position_m[2] + share * way[2])
        free = share >= 1.0 - 1e-9  # the antenna is within
        curved = 1.0 / (share * length) + 1.0 / np.maximum((1.0 - share) * length, 1e-3)
        sine, cosine_integral = fresnel(above * np.sqrt(wavenumber_rad_m / np.pi * curved))
        through = 0.5 + 0.5 * (1.0 - 1j) * (cosine_integral + 1j * sine)
        longer = (self.index - 1.0) * self.wall_m / np.maximum(cosine, 0.1)
        return np.where(free, 1.0, 1.0 + np.expm1(1j * wavenumber_rad_m * longer) * through)
