"""The simulated floor: the plane that the sphere's centre cannot pass, and the container's bottom below it."""

from dataclasses import dataclass

import numpy as np

from radargui.model.arrays import FloatArray
from radargui.model.errors import SetupError
from radargui.model.setup import Setup

DEFAULT_DROP_M = 0.26
"""Where neither drop height nor floor is given: a fall through the field of view of about 30 cm."""
_LEAST_DROP_M = 1e-4
"""A release nearer to the floor is a slip in the setup, no fall."""
_LEAST_NORMAL_Z = 0.2
"""Cosine of 78 degrees: what is steeper is a wall, on which no sphere comes to rest."""


@dataclass(frozen=True, slots=True)
class ContactPlane:
    """The plane n.x = d where the sphere's centre is when it touches.

    Attributes
    ----------
    normal
        Unit vector away from the floor, shape (3,).
    distance_m
        d.
    """

    normal: FloatArray
    distance_m: float

    def height_m(self, place_m: FloatArray) -> float:
        """Return how far a place (3,) lies above the plane, along the normal."""
        return float(self.normal @ place_m) - self.distance_m


def contact_plane(setup: Setup) -> ContactPlane:
    """Return the floor of the simulated scene.

    It leans by `simulation.floor_tilt_deg` from what the setup says. It passes `simulation.drop_height_m` below the
    release; where that is left out, through `floor.height_m` on the z axis; where that is left out too, 0.26 m below
    the release.

    Raises
    ------
    SetupError
        The floor does not face up, or the release does not lie above it.
    """
    release = np.array(setup.tracer.release_position_m)
    tilt, normal = np.radians(setup.simulation.floor_tilt_deg), np.array(setup.floor.normal)
    if normal[2] < _LEAST_NORMAL_Z:
        raise SetupError(
            f"floor.normal = {[round(float(part), 3) for part in normal]}: the simulated sphere needs a floor that "
            "faces up",
            remedy="Point the normal away from the floor, for example [0, 0, 1].",
        )
    if tilt:
        aside = along_plane(azimuth_direction(setup.simulation.floor_tilt_azimuth_deg), normal)
        normal = np.cos(tilt) * normal + np.sin(tilt) * aside
    if setup.simulation.drop_height_m is not None:
        foot = release - np.array([0.0, 0.0, setup.simulation.drop_height_m])
    elif setup.floor.height_m is not None:
        foot = np.array([0.0, 0.0, setup.floor.height_m])
    else:
        foot = release - np.array([0.0, 0.0, DEFAULT_DROP_M])
    plane = ContactPlane(normal, float(normal @ foot))
    if plane.height_m(release) < _LEAST_DROP_M:
        raise SetupError(
            f"The release of the simulated sphere at z = {release[2]:g} m is not above the floor at z = {foot[2]:g} m",
            remedy="Raise tracer.release_position_m, lower floor.height_m or set simulation.drop_height_m.",
        )
    return plane


def along_plane(heading: FloatArray, normal: FloatArray) -> FloatArray:
    """Return the unit vector of a heading along a plane, shape (3,)."""
    along = heading - (heading @ normal) * normal
    return np.asarray(along / np.linalg.norm(along))


def azimuth_direction(azimuth_deg: float) -> FloatArray:
    """Return the horizontal unit vector of an azimuth, shape (3,)."""
    azimuth = np.radians(azimuth_deg)
    return np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
