"""Path lengths Tx - tracer - Rx, their directions and what they allow to observe."""

from __future__ import annotations

import numpy as np

from radargui.geometry.antennas import Antennas
from radargui.model.arrays import FloatArray


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
    to_transmitter = _distance(position_m - antennas.transmitter_m[:, None])
    return np.stack([to_transmitter + _distance(position_m - own[:, None]) for own in antennas.receivers_m])


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
    from_transmitter = position_m - antennas.transmitter_m[:, None]
    unit_transmitter = from_transmitter / _distance(from_transmitter)
    from_receivers = [position_m - own[:, None] for own in antennas.receivers_m]
    return np.stack([unit_transmitter + away / _distance(away) for away in from_receivers])


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


def _distance(away_m: FloatArray) -> FloatArray:
    x, y, z = away_m
    return np.asarray(np.sqrt(x * x + y * y + z * z))
