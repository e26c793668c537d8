"""The granular bed: free fall, then an even stop without rebound."""

from __future__ import annotations

import numpy as np

from radargui.model.arrays import FloatArray
from radargui.model.simulation import Simulation
from radargui.sources.simulated.floor import ContactPlane
from radargui.sources.simulated.glide import Glide


class Bed:
    """A sphere that falls onto a granular bed and comes to rest `bed_depth_m` below its surface.

    The deceleration along the normal is constant, v^2 / (2 depth); the speed along the surface falls to zero within
    the same time. There is no impact: the speed never jumps.
    """

    impact_time_s: FloatArray = np.empty(0)

    def __init__(self, simulation: Simulation, release_m: FloatArray, surface: ContactPlane) -> None:
        self._release_m = release_m
        self._normal = surface.normal
        self._gravity_m_s2 = simulation.gravity_m_s2 * float(surface.normal[2])
        self._touch_s = float(np.sqrt(2.0 * surface.height_m(release_m) / self._gravity_m_s2))
        self._speed_m_s = self._gravity_m_s2 * self._touch_s
        self._stop_s = 2.0 * simulation.bed_depth_m / self._speed_m_s
        self._glide = Glide(simulation, surface)

    @property
    def duration_s(self) -> float:
        """Time from the release until the sphere stays where it is."""
        return self._touch_s + self._stop_s

    def position_m(self, time_s: FloatArray) -> FloatArray:
        """Return the position, shape (3, n), at times (n,)."""
        time_s = np.maximum(time_s, 0.0)
        free = np.minimum(time_s, self._touch_s)
        braking = np.clip(time_s - self._touch_s, 0.0, self._stop_s)
        sunk = self._speed_m_s * (braking - 0.5 * braking**2 / self._stop_s)
        fallen = -0.5 * self._gravity_m_s2 * free**2 - sunk
        along = self._glide.travel_m(time_s, self._touch_s, self._stop_s)
        return np.asarray(self._release_m[:, None] + self._normal[:, None] * fallen + along)
