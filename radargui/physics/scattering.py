"""Compute what lengthens the direct path: the phase that the sphere scatters with, and container walls.

Compute how the foam or acrylic walls of a container delay the rays that cross them.
"""

from __future__ import annotations

import numpy as np

from radargui.model.arrays import ComplexArray, FloatArray
from radargui.model.assumed import SUPPOSED_POLARIZATIONS_DEG, SUPPOSED_TURNS_DEG
from radargui.model.radar import Walls
from radargui.model.scattering import (
    received_direction,
    scattered_field,
    strongest_polarization_deg,
    tracer_sphere,
    transmitted_direction,
    transverse_axes,
)
from radargui.model.setup import Setup
from radargui.physics.path_length import Antennas, place_antennas

_MIN_COSINE = 0.1  # of a ray against a wall's normal: beyond 84 degrees it runs along the wall
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
    longer_m = (walls.refractive_index - 1.0) * walls.wall_m / np.maximum(cosine, _MIN_COSINE)
    return np.where(crosses, 1.0 + np.expm1(1j * wavenumber * longer_m) * part, 1.0)


HALF_WIDTH_M, NEAREST = 0.3, 0.6
"""Half of the cube of the table, but at most this share of the nearest antenna's distance from the centre."""
POINTS = 21
"""Along each edge: for 3 to 16 mm spheres 0.7 m away cubic splines between them are right to 0.2 um (tested)."""


def scattering_delay_m(position_m: FloatArray, setup: Setup) -> FloatArray:
    """Return arg(f(p) / f(release)) / K, by which the measured change of a direct path exceeds the true one.

    Parameters
    ----------
    position_m
        Shape (3, n_samples).
    setup
        With `transmitter.polarization_deg`; 0 is taken where it is not given.

    Returns
    -------
    FloatArray
        Metres, shape (n_receivers, n_samples).
    """
    antennas = place_antennas(setup)
    # first the release, where the change of every path is zero
    places = np.concatenate([np.array(setup.tracer.release_position_m)[:, None], position_m], axis=1)
    sphere = tracer_sphere(setup.tracer, setup.radar)
    sent = transmitted_direction(setup.transmitter.polarization_deg or 0.0)
    out = np.empty((antennas.n_receivers, position_m.shape[1]))
    for row, rx, own in zip(out, antennas.receivers_m, setup.received_fields(), strict=True):
        got = received_direction(own.angle_deg, own.horizontal, own.vertical)
        field = got @ scattered_field(sphere, places, antennas.transmitter_m, sent, rx)
        row[:] = setup.radar.wavelength_m / (2.0 * np.pi) * np.angle(field[1:] / field[0])
    return out


def supposed_delays_m(position_m: FloatArray, setup: Setup) -> FloatArray:
    """Return `scattering_delay_m` for the polarisations that are supposed where a setup does not tell them.

    The scattered field is linear in the transmitted one, so two directions of that give all others.

    Parameters
    ----------
    position_m
        Shape (3, n_samples).
    setup
        Antennas and sphere.

    Returns
    -------
    FloatArray
        Metres, shape (n_angles n_turns, n_receivers, n_samples), the turns running faster.
    """
    antennas = place_antennas(setup)
    release = np.array(setup.tracer.release_position_m)[:, None]
    # first the centre, for which a receiver is turned to the strongest signal where nobody says how
    places = np.concatenate([np.zeros((3, 1)), release, position_m], axis=1)
    both = np.stack([transmitted_direction(angle) for angle in (0.0, 90.0)])
    sphere = tracer_sphere(setup.tracer, setup.radar)
    out = []
    for rx, receiver in zip(antennas.receivers_m, setup.receiver, strict=True):
        fields = scattered_field(sphere, places, antennas.transmitter_m, both, rx)
        horizontal, vertical = transverse_axes(rx / np.linalg.norm(rx), receiver.azimuth_deg)
        weights = []
        for angle in SUPPOSED_POLARIZATIONS_DEG:
            sent = transmitted_direction(angle)[:2]
            best = strongest_polarization_deg(sent @ fields[:, :, 0], horizontal, vertical)
            got = [received_direction(best + turn, horizontal, vertical) for turn in SUPPOSED_TURNS_DEG]
            weights += [np.outer(sent, one).ravel() for one in got]
        signal = np.array(weights) @ fields.reshape(6, -1)
        out.append(np.angle(signal[:, 2:] / signal[:, 1:2]))
    return setup.radar.wavelength_m / (2.0 * np.pi) * np.stack(out, axis=1)


class SphereDelay:
    """`scattering_delay_m` looked up.

    The Mie sums cost some hundred array operations, too many for each block of a live track. They are computed once on
    a cube around the centre; outside it the values of its faces hold.

    Parameters
    ----------
    setup
        With `transmitter.polarization_deg`.
    """

    def __init__(self, setup: Setup) -> None:
        antennas = place_antennas(setup)
        nearest_m = min(float(np.linalg.norm(place)) for place in (antennas.transmitter_m, *antennas.receivers_m))
        self._half_m = min(HALF_WIDTH_M, NEAREST * nearest_m)
        from scipy.ndimage import spline_filter

        axis = np.linspace(-self._half_m, self._half_m, POINTS)
        grid = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"))
        delay_m = scattering_delay_m(grid.reshape(3, -1), setup)
        # filtered once: every look-up is then a sum over 64 values
        self._tables = [spline_filter(own.reshape(grid.shape[1:]), order=3, mode="nearest") for own in delay_m]

    def at(self, position_m: FloatArray) -> FloatArray:
        """Return the excess of the path length in metres, shape (n_receivers, n), at places (3, n); NaN for NaN."""
        from scipy.ndimage import map_coordinates

        node = (position_m + self._half_m) * ((POINTS - 1) / (2.0 * self._half_m))
        known = np.isfinite(node).all(axis=0)
        out = np.full((len(self._tables), position_m.shape[1]), np.nan)
        for row, table in zip(out, self._tables, strict=True):
            row[known] = map_coordinates(table, node[:, known], order=3, mode="nearest", prefilter=False)
        return out


class PathDelay:
    """The excess of the change of a path, as its phase shows it, over the true one.

    It is the phase that the sphere scatters with, where the setup states the polarisation, and the delay by container
    walls.

    Parameters
    ----------
    setup
        Of which `is_delayed` is true.
    """

    def __init__(self, setup: Setup) -> None:
        self._setup, self._antennas = setup, place_antennas(setup)
        self._sphere = None if setup.transmitter.polarization_deg is None else SphereDelay(setup)

    def at(self, position_m: FloatArray) -> FloatArray:
        """Return the excess of the path length in metres, shape (n_receivers, n), at places (3, n); NaN for NaN."""
        setup, walls = self._setup, self._setup.container.walls
        out = np.zeros((setup.n_receivers, position_m.shape[1]))
        if self._sphere is not None:
            out += self._sphere.at(position_m)
        if walls is not None:
            release, wavenumber = np.array(setup.tracer.release_position_m), 2.0 * np.pi / setup.radar.wavelength_m
            out += wall_delay_m(position_m, self._antennas, release, walls, wavenumber)
        return out


def path_delay(setup: Setup) -> PathDelay | None:
    """Return what adds to the paths of a setup; None where nothing does: of a point, and without walls."""
    return PathDelay(setup) if is_delayed(setup) else None


def is_delayed(setup: Setup) -> bool:
    """Return whether anything adds to the phase of a path."""
    return setup.transmitter.polarization_deg is not None or setup.container.walls is not None
