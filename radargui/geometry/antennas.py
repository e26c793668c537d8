"""Antennas: where transmitter and receivers stand."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from radargui.model.arrays import FloatArray
from radargui.model.setup import Setup


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
    tilt = np.radians([receiver.tilt_deg for receiver in setup.receiver])
    azimuth = np.radians([receiver.azimuth_deg for receiver in setup.receiver])
    distance = np.array([receiver.distance_m for receiver in setup.receiver])
    direction = np.stack([np.sin(tilt) * np.cos(azimuth), np.sin(tilt) * np.sin(azimuth), np.cos(tilt)], axis=1)
    return Antennas(np.array(setup.transmitter.place_m), distance[:, None] * direction)
