"""A polarised antenna: where it is, where it points, the direction of its field, its lobe."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from benchmarks.world.horn import Horn
from numpy.typing import NDArray

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True)
class Antenna:
    """A dipole-like field inside a cosine lobe on a floor of side lobes.

    Attributes
    ----------
    position_m, axis, polarization
        Shape (3,); the axis points to where the lobe is strongest.
    lobe
        The field goes with the cosine of the angle from the axis to this power.
    side_lobe
        The field far from the axis over that on it.
    horn
        Whose wave it is instead of the lobe's, the position being its best centre of phase; None: a spherical wave.
    """

    position_m: Array
    axis: Array
    polarization: Array
    lobe: float
    side_lobe: float = 0.0
    horn: Horn | None = None

    def strength(self, direction: Array) -> Array:
        """Return the lobe along unit vectors (3, n), shape (n,)."""
        cosine = np.clip(self.axis @ direction, 0.0, None)
        main = cosine**self.lobe
        if self.horn is not None:
            main = np.abs(self.horn.factor(cosine, np.full(cosine.size, self.horn.distance_m)))
        return np.hypot(main, self.side_lobe)

    def field(self, direction: Array, range_m: Array | None = None) -> Complex:
        """Return the field sent along unit vectors (3, n), without the range: the polarisation across the direction.

        At distances (n,) that of a horn has the phase of its curved front too.
        """
        across = self.polarization[:, None] - direction * (self.polarization @ direction)
        strength = self.strength(direction).astype(complex)
        if self.horn is not None and range_m is not None:
            cosine = np.clip(self.axis @ direction, 0.0, None)
            near = self.horn.factor(cosine, range_m)
            strength *= near / np.abs(self.horn.factor(cosine, np.full(cosine.size, self.horn.distance_m)))
        return strength * across


def transmitter(distance_m: float, polarization_deg: float, lobe: float) -> Antenna:
    """Return the transmitter on the z axis; its field points from the x axis towards the y axis by the angle."""
    angle = np.radians(polarization_deg)
    place = np.array([0.0, 0.0, distance_m])
    return Antenna(place, np.array([0.0, 0.0, -1.0]), np.array([np.cos(angle), np.sin(angle), 0.0]), lobe)


def receiver(tilt_deg: float, azimuth_deg: float, distance_m: float, polarization_deg: float, lobe: float) -> Antenna:
    """Return a receiver that points to the origin; its field is cos(p) h + sin(p) v, h horizontal, v = u x h."""
    tilt, azimuth, angle = np.radians([tilt_deg, azimuth_deg, polarization_deg])
    outward = np.array([np.sin(tilt) * np.cos(azimuth), np.sin(tilt) * np.sin(azimuth), np.cos(tilt)])
    horizontal = np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
    upward = np.cross(outward, horizontal)
    field = np.cos(angle) * horizontal + np.sin(angle) * upward
    return Antenna(distance_m * outward, -outward, field, lobe)
