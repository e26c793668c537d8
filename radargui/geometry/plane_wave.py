"""The far field: the matrix T of tilt and azimuth, and position from it."""

from __future__ import annotations

import numpy as np

from radargui.geometry.antennas import Antennas
from radargui.model.arrays import FloatArray


def t_matrix(antennas: Antennas) -> FloatArray:
    """Return T with rows [sin t cos a, sin t sin a, 1 + cos t] (Rech & Huang 2019, eq. 2).

    Returns
    -------
    FloatArray
        No unit, shape (n_receivers, 3).
    """
    to_receiver = antennas.receivers_m / np.linalg.norm(antennas.receivers_m, axis=1, keepdims=True)
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
    inverse = np.linalg.pinv(t_matrix(antennas))
    return np.asarray(release_position_m[:, None] - inverse @ change_m)
