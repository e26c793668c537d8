"""What the scattering of a metal sphere adds to the direct path length: the phase of its scattered field."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import map_coordinates, spline_filter

from radargui.geometry.antennas import place_antennas
from radargui.model.arrays import FloatArray
from radargui.model.polarization import received_direction, transmitted_direction
from radargui.model.scattering import conducting_sphere, scattered_field
from radargui.model.setup import Setup

HALF_WIDTH_M, NEAREST = 0.3, 0.6
"""Half of the cube of the table, but at most this share of the nearest antenna's distance from the centre."""
POINTS = 21
"""Along each edge: for 3 to 16 mm spheres 0.7 m away cubic splines between them are right to 0.2 um (tested)."""


def scattering_delay_m(position_m: FloatArray, setup: Setup) -> FloatArray:
    """Return arg(f(p) / f(release)) / K: what the measured change of a direct path exceeds the true one by.

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
    places = np.concatenate([np.array(setup.tracer.release_position_m)[:, None], position_m], axis=1)
    sphere = conducting_sphere(0.5 * setup.tracer.diameter_m, setup.radar.wavelength_m)
    sent = transmitted_direction(setup.transmitter.polarization_deg or 0.0)
    out = np.empty((antennas.n_receivers, position_m.shape[1]))
    for row, rx, own in zip(out, antennas.receivers_m, setup.received_fields(), strict=True):
        got = received_direction(own.angle_deg, own.horizontal, own.vertical)
        field = got @ scattered_field(sphere, places, antennas.transmitter_m, sent, rx)
        row[:] = setup.radar.wavelength_m / (2.0 * np.pi) * np.angle(field[1:] / field[0])
    return out


class SphereDelay:
    """`scattering_delay_m` looked up.

    The Mie sums cost some hundred array operations for any number of places, too many for each block of a live track:
    they are made once on a cube round the centre. Outside it its faces' values hold.

    Parameters
    ----------
    setup
        With `transmitter.polarization_deg`.
    """

    def __init__(self, setup: Setup) -> None:
        antennas = place_antennas(setup)
        nearest_m = min(float(np.linalg.norm(place)) for place in (antennas.transmitter_m, *antennas.receivers_m))
        self._half_m = min(HALF_WIDTH_M, NEAREST * nearest_m)
        axis = np.linspace(-self._half_m, self._half_m, POINTS)
        grid = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"))
        delay_m = scattering_delay_m(grid.reshape(3, -1), setup)
        self._tables = [spline_filter(own.reshape(grid.shape[1:]), order=3, mode="nearest") for own in delay_m]

    def at(self, position_m: FloatArray) -> FloatArray:
        """Return the excess of the path length in metres, shape (n_receivers, n), at places (3, n); NaN for NaN."""
        node = (position_m + self._half_m) * ((POINTS - 1) / (2.0 * self._half_m))
        known = np.isfinite(node).all(axis=0)
        out = np.full((len(self._tables), position_m.shape[1]), np.nan)
        for row, table in zip(out, self._tables, strict=True):
            row[known] = map_coordinates(table, node[:, known], order=3, mode="nearest", prefilter=False)
        return out


def sphere_delay(setup: Setup) -> SphereDelay | None:
    """Return the delay of a setup's sphere; None where the polarisation is not given: it counts as a point."""
    return None if setup.transmitter.polarization_deg is None else SphereDelay(setup)
