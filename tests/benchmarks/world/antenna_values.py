"""An antenna in the setup file's terms, and how much of the strongest signal its polarisation gets."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from benchmarks.world.antenna import receiver, transmitter
from benchmarks.world.room import Room
from benchmarks.world.sphere import Sphere


@dataclass(frozen=True)
class AntennaValues:
    """Where an antenna is and how its field points; the transmitter has tilt 0."""

    tilt_deg: float
    azimuth_deg: float
    distance_m: float
    polarization_deg: float


def signal_share(sender: AntennaValues, one: AntennaValues, sphere: Sphere) -> float:
    """Return a receiver's signal from the centre over that of the best polarisation there.

    The signal is a cos p + b sin p: its largest size squared is (|a|^2 + |b|^2 + |a^2 + b^2|) / 2.
    """
    source = transmitter(sender.distance_m, sender.polarization_deg, 0.0)
    a, b = (
        Room((source, receiver(one.tilt_deg, one.azimuth_deg, one.distance_m, angle, 0.0)), sphere).received(
            0, np.zeros((3, 1))
        )[0]
        for angle in (0.0, 90.0)
    )
    angle = np.radians(one.polarization_deg)
    largest = np.sqrt((abs(a) ** 2 + abs(b) ** 2 + abs(a**2 + b**2)) / 2.0)
    return float(abs(a * np.cos(angle) + b * np.sin(angle)) / largest)
