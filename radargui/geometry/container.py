"""Compute how the foam or acrylic walls of a container delay the rays that cross them."""

from __future__ import annotations

import numpy as np

from radargui.geometry.path_length import Antennas
from radargui.model.arrays import ComplexArray, FloatArray
from radargui.model.radar import Walls

_LEAST_COSINE = 0.1  # of a ray against a wall's normal: beyond 84 degrees it runs along the wall
_NEAREST_M = 1e-3  # of the rim from either end of a ray: nearer there is no far field of an edge


def through_walls(position_m: FloatArray, antennas: Antennas, walls: Walls, wavenumber_rad_m: float) -> ComplexArray:
    """Return what a container's walls multiply the direct paths with, shape (n_receivers, n_samples).

    Parameters
    ----------
    position_m
        Shape (3, n_samples).
    antennas
        A way that does not meet a wall, from above, has the factor one.
    walls, wavenumber_rad_m
        Of the container; K of the wave in air.
    """
    sent = wall_factor(position_m, antennas.transmitter_m, walls, wavenumber_rad_m)
    return np.array([sent * wall_factor(position_m, rx, walls, wavenumber_rad_m) for rx in antennas.receivers_m])


def wall_delay_m(
    position_m: FloatArray, antennas: Antennas, release_m: FloatArray, walls: Walls, wavenumber_rad_m: float
) -> FloatArray:
    """Return by how much walls lengthen the change of each path since the release, (n_receivers, n_samples)."""
    places = np.concatenate([release_m[:, None], position_m], axis=1)
    factor = through_walls(places, antennas, walls, wavenumber_rad_m)
    # a foam's is far below a wave; through acrylic the phase goes on from place to place
    return np.asarray(np.angle(factor[:, 1:] / factor[:, :1]) / wavenumber_rad_m)


def wall_factor(position_m: FloatArray, antenna_m: FloatArray, walls: Walls, wavenumber: float) -> ComplexArray:
    """Return the factor of the straight way between places (3, n) and an antenna (3,), shape (n,).

    Through a wall the way is longer by (n - 1) d / cos, to first order in n - 1. Near the rim the part F of the wave
    that goes through the wall is that of a half-plane (Born & Wolf, section 8.7.3): 1 + (exp(i K delta) - 1) F(v), v =
    height of the rim over the ray times sqrt(K / pi (1 / r + 1 / r')), F = 1/2 + (1 - i) (C(v) + i S(v)) / 2.
    """
    # where no container stands nobody waits for it
    from scipy.special import fresnel

    half = 0.5 * np.array(walls.inner_m)[:, None]
    way = antenna_m[:, None] - position_m
    length = np.linalg.norm(way, axis=0)
    # after which share of the way each pair of walls is met; never where it runs along them
    with np.errstate(divide="ignore"):
        met = np.where(way[:2] == 0.0, np.inf, (np.copysign(half, way[:2]) - position_m[:2]) / way[:2])
    met = np.where(met > 0.0, met, np.inf)
    wall, share = met.argmin(axis=0), met.min(axis=0)
    crosses = share < 1.0
    share = np.where(crosses, share, 0.5)
    cosine = np.abs(np.take_along_axis(way, wall[None], axis=0)[0]) / length
    above_m = walls.height_m - (position_m[2] + share * way[2])
    near, far = (np.maximum(part * length, _NEAREST_M) for part in (share, 1.0 - share))
    sine, cosine_integral = fresnel(above_m * np.sqrt(wavenumber / np.pi * (1.0 / near + 1.0 / far)))
    part = 0.5 + 0.5 * (1.0 - 1j) * (cosine_integral + 1j * sine)
    longer_m = (walls.refractive_index - 1.0) * walls.wall_m / np.maximum(cosine, _LEAST_COSINE)
    return np.where(crosses, 1.0 + np.expm1(1j * wavenumber * longer_m) * part, 1.0)
