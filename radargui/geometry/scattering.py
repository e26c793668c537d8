"""Compute what lengthens the direct path: the phase that the sphere scatters with, and container walls."""

from __future__ import annotations

import numpy as np

from radargui.geometry.container import wall_delay_m
from radargui.geometry.path_length import place_antennas
from radargui.model.arrays import FloatArray
from radargui.model.assumed import SUPPOSED_POLARIZATIONS_DEG, SUPPOSED_TURNS_DEG
from radargui.model.scattering import (
    received_direction,
    scattered_field,
    strongest_polarization_deg,
    tracer_sphere,
    transmitted_direction,
    transverse_axes,
)
from radargui.model.setup import Setup

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
