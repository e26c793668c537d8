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
    to_transmitter = np.linalg.norm(position_m - antennas.transmitter_m[:, None], axis=0)
    to_receiver = np.linalg.norm(position_m[None] - antennas.receivers_m[:, :, None], axis=1)
    return np.asarray(to_transmitter + to_receiver)


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
    from_receiver = position_m[None] - antennas.receivers_m[:, :, None]
    unit_transmitter = from_transmitter / np.linalg.norm(from_transmitter, axis=0)
    unit_receiver = from_receiver / np.linalg.norm(from_receiver, axis=1, keepdims=True)
    return np.asarray(unit_transmitter[None] + unit_receiver)
