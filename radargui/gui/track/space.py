"""The box that track views show: where release, floor and antennas are, in millimetres."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from radargui.geometry.antennas import place_antennas
from radargui.model.arrays import FloatArray
from radargui.model.setup import Setup

MM = 1000.0
_HALF_FIELD_MM = 150.0
_MARGIN_MM = 20.0


@dataclass(frozen=True, slots=True)
class Space:
    """The field of view as it is drawn.

    Attributes
    ----------
    low_mm, high_mm
        Corners, shape (3,).
    release_mm
        Centre of the sphere at rest, shape (3,).
    floor_mm
        z of the centre where it touches.
    diameter_mm
        Of the sphere.
    antennas
        Name and direction (unit vector, shape (3,)) of each antenna, the transmitter first.
    """

    low_mm: FloatArray
    high_mm: FloatArray
    release_mm: FloatArray
    floor_mm: float
    diameter_mm: float
    antennas: tuple[tuple[str, FloatArray], ...]

    @property
    def size_mm(self) -> FloatArray:
        """Edges of the box, shape (3,)."""
        return np.asarray(self.high_mm - self.low_mm)


def space_of(setup: Setup) -> Space:
    """Return the box around the field of view (about 30 cm wide), release and floor."""
    release = np.array(setup.tracer.release_position_m) * MM
    low, high = np.full(3, -_HALF_FIELD_MM), np.full(3, _HALF_FIELD_MM)
    floor = setup.floor.height_m * MM if setup.floor.height_m is not None else float(low[2])
    low[2] = min(floor, release[2] - _MARGIN_MM)
    high[2] = release[2]
    margin = np.array([0.0, 0.0, _MARGIN_MM])
    low = np.minimum(low, release) - margin
    high = np.maximum(high, release) + margin
    placed = place_antennas(setup)
    names = ["Tx", *(f"Rx {number + 1}" for number in range(placed.n_receivers))]
    places = np.vstack([placed.transmitter_m, placed.receivers_m])
    directions = places / np.linalg.norm(places, axis=1, keepdims=True)
    return Space(
        low_mm=low,
        high_mm=high,
        release_mm=release,
        floor_mm=floor,
        diameter_mm=setup.tracer.diameter_m * MM,
        antennas=tuple(zip(names, directions, strict=True)),
    )
