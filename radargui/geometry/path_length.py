"""Place antennas and their images; compute path lengths, their gradient and the plane-wave solution."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from radargui.model.arrays import FloatArray
from radargui.model.setup import Setup

LEAST_RECEIVERS = 3
"""Path lengths that a position in space needs."""
LARGE_CONDITION = 20.0
"""An error of path length then grows twenty times in the position: 0.1 mm become 2 mm, as much as is measured."""


@dataclass(frozen=True, slots=True)
class Antennas:
    """Places of the antennas in the frame of the field of view.

    Attributes
    ----------
    transmitter_m
        Shape (3,).
    receivers_m
        Shape (n_receivers, 3).
    """

    transmitter_m: FloatArray
    receivers_m: FloatArray

    @property
    def n_receivers(self) -> int:
        """Number of receivers."""
        return int(self.receivers_m.shape[0])


def place_antennas(setup: Setup) -> Antennas:
    """Return the antennas of a setup.

    Receiver i stands at distance (sin tilt cos azimuth, sin tilt sin azimuth, cos tilt), the transmitter on +z
    (Rech & Huang 2019, fig. 1) or where `position_m` says.
    """
    return antennas_at(receiver_values(setup), np.array(setup.transmitter.place_m))


def receiver_values(setup: Setup) -> FloatArray:
    """Return tilt and azimuth (degrees) and distance (m) of each receiver's phase centre, shape (3, n_receivers)."""
    return np.array([(one.tilt_deg, one.azimuth_deg, one.reach_m) for one in setup.receiver]).T


def antennas_at(receivers: FloatArray, transmitter_m: FloatArray) -> Antennas:
    """Return the antennas by tilt, azimuth and distance of each receiver, (3, n_receivers), see `place_antennas`."""
    tilt, azimuth = np.radians(receivers[:2])
    # tilt from the z axis, azimuth from x towards y
    direction = np.stack([np.sin(tilt) * np.cos(azimuth), np.sin(tilt) * np.sin(azimuth), np.cos(tilt)], axis=1)
    return Antennas(transmitter_m, receivers[2][:, None] * direction)


def path_lengths(position_m: FloatArray, antennas: Antennas) -> FloatArray:
    """Return L_i = |p - tx| + |p - rx_i| (Ott, Herminghaus & Huang 2017, eq. 1).

    Parameters
    ----------
    position_m
        Shape (3, n_samples).
    antennas
        n_receivers of them.

    Returns
    -------
    FloatArray
        Metres, shape (n_receivers, n_samples).
    """
    to_transmitter = distance(position_m - antennas.transmitter_m[:, None])
    return np.stack([to_transmitter + distance(position_m - own[:, None]) for own in antennas.receivers_m])


def path_gradient(position_m: FloatArray, antennas: Antennas) -> FloatArray:
    """Return dL_i/dp: the sum of the unit vectors from the antennas to the tracer.

    Parameters
    ----------
    position_m
        Shape (3, n_samples).
    antennas
        n_receivers of them.

    Returns
    -------
    FloatArray
        No unit, shape (n_receivers, 3, n_samples).
    """
    # the way there is common to all receivers: once
    unit_transmitter = position_m - antennas.transmitter_m[:, None]
    unit_transmitter /= distance(unit_transmitter)
    out = np.empty((antennas.n_receivers, *position_m.shape))
    for row, own in zip(out, antennas.receivers_m, strict=True):
        np.subtract(position_m, own[:, None], out=row)
        row /= distance(row)
        row += unit_transmitter
    return out


def range_factor(position_m: FloatArray, antennas: Antennas, release_m: FloatArray) -> FloatArray:
    """Return 1 / (r_tx r_rx) over its value at release: how the amplitude falls with the ways there and back.

    Radar equation of a small sphere: the field falls as the inverse of both distances (Balanis, Antenna Theory).

    Parameters
    ----------
    position_m
        Shape (3, n_samples).
    antennas
        n_receivers of them.
    release_m
        Where the factor is one, shape (3,).

    Returns
    -------
    FloatArray
        No unit, shape (n_receivers, n_samples).
    """

    def product(place: FloatArray) -> FloatArray:
        to_receiver = np.linalg.norm(place[None] - antennas.receivers_m[:, :, None], axis=1)
        return np.asarray(to_receiver * np.linalg.norm(place - antennas.transmitter_m[:, None], axis=0))

    return np.asarray(product(release_m[:, None]) / product(position_m))


def distance(away_m: FloatArray) -> FloatArray:
    """Return the lengths of vectors (3, n), shape (n,)."""
    x, y, z = away_m
    return np.asarray(np.sqrt(x * x + y * y + z * z))


def t_matrix(antennas: Antennas) -> FloatArray:
    """Return T with rows [sin t cos a, sin t sin a, 1 + cos t] (Rech & Huang 2019, eq. 2).

    Returns
    -------
    FloatArray
        No unit, shape (n_receivers, 3).
    """
    to_receiver = antennas.receivers_m / np.linalg.norm(antennas.receivers_m, axis=1, keepdims=True)
    # for a transmitter on the axis (0, 0, 1), which gives the 1 + cos t
    to_transmitter = antennas.transmitter_m / np.linalg.norm(antennas.transmitter_m)
    return np.asarray(to_receiver + to_transmitter)


def condition_number(antennas: Antennas) -> float:
    """Return the condition number of T: how much an error of L can grow in the position."""
    return float(np.linalg.cond(t_matrix(antennas)))


def locate_plane(change_m: FloatArray, antennas: Antennas, release_position_m: FloatArray) -> FloatArray:
    """Return p = p_release - T^-1 dL (Rech & Huang 2019, eq. 3); least squares with more than three receivers.

    Parameters
    ----------
    change_m
        Change of path length from the rest, shape (n_receivers, n_samples); NaN gives NaN.
    antennas
        At least three receivers.
    release_position_m
        Place at rest, shape (3,).

    Returns
    -------
    FloatArray
        Metres, shape (3, n_samples).
    """
    # T^-1 for three receivers, least squares for four
    inverse = np.linalg.pinv(t_matrix(antennas))
    return np.asarray(release_position_m[:, None] - inverse @ change_m)


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
