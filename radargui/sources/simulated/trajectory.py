"""What every trajectory of the simulated tracer offers: position at any time, impacts, duration."""

from typing import Protocol

import numpy as np

from radargui.model.arrays import FloatArray


class Trajectory(Protocol):
    """Motion of the sphere's centre, analytic in time; time 0 is the release.

    Attributes
    ----------
    duration_s
        From the release until the sphere stays where it is.
    impact_time_s
        Instants of the impacts on the floor, shape (n_impacts,).
    """

    duration_s: float
    impact_time_s: FloatArray

    def position_m(self, time_s: FloatArray) -> FloatArray:
        """Return the position, shape (3, n), at times (n,); before 0 the release, after the duration the last place."""


class Rest:
    """A sphere that never moves."""

    def __init__(self, place_m: FloatArray) -> None:
        self._place_m = place_m

    duration_s = 0.0
    impact_time_s: FloatArray = np.empty(0)

    def position_m(self, time_s: FloatArray) -> FloatArray:
        """Return the place, shape (3, n)."""
        return np.repeat(self._place_m[:, None], time_s.size, axis=1)


def along_plane(heading: FloatArray, normal: FloatArray) -> FloatArray:
    """Return the unit vector of a heading along a plane, shape (3,)."""
    along = heading - (heading @ normal) * normal
    return np.asarray(along / np.linalg.norm(along))


def azimuth_direction(azimuth_deg: float) -> FloatArray:
    """Return the horizontal unit vector of an azimuth, shape (3,)."""
    azimuth = np.radians(azimuth_deg)
    return np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
