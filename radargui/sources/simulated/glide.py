"""The glide: motion along the floor while the sphere falls and bounces."""

from __future__ import annotations

import numpy as np

from radargui.model.arrays import FloatArray
from radargui.model.simulation import Simulation
from radargui.sources.simulated.floor import ContactPlane
from radargui.sources.simulated.trajectory import azimuth_direction

PUSH_S = 0.01


class Glide:
    """Motion along the floor: the push at the release, and gravity's share along a tilted floor.

    A magnet lets a sphere go on one side later than on the other and so pushes it sideways: the lateral speed grows
    evenly over the first 10 ms and stays. Impacts do not change it (a smooth sphere on a smooth floor).
    """

    def __init__(self, simulation: Simulation, floor: ContactPlane) -> None:
        normal = floor.normal
        self._push_m_s = push_velocity_m_s(simulation, floor)
        down = np.array([0.0, 0.0, -simulation.gravity_m_s2])
        along = down - (down @ normal) * normal
        self._gravity_m_s2 = np.where(np.abs(along) < 1e-12, 0.0, along)

    def velocity_m_s(self, time_s: float) -> FloatArray:
        """Return the velocity along the floor at a time after the release, shape (3,)."""
        return np.asarray(self._push_m_s * min(time_s / PUSH_S, 1.0) + self._gravity_m_s2 * time_s)

    def speed_m_s(self, time_s: float) -> float:
        """Return the speed along the floor at a time after the release."""
        return float(np.linalg.norm(self.velocity_m_s(time_s)))

    def travel_m(self, time_s: FloatArray, brake_s: float, stop_s: float) -> FloatArray:
        """Return the way along the floor, shape (3, n), at times (n,) after the release.

        From `brake_s` on the speed falls evenly to zero within `stop_s`.
        """
        if self.speed_m_s(brake_s) == 0.0:
            return np.zeros((3, time_s.size))
        free = np.minimum(time_s, brake_s)
        pushed = np.where(free < PUSH_S, 0.5 * free**2 / PUSH_S, free - 0.5 * PUSH_S)
        braking = np.clip(time_s - brake_s, 0.0, stop_s)
        rolled = braking - 0.5 * braking**2 / stop_s
        return np.asarray(
            self._push_m_s[:, None] * pushed
            + 0.5 * self._gravity_m_s2[:, None] * free**2
            + self.velocity_m_s(brake_s)[:, None] * rolled
        )


def push_velocity_m_s(simulation: Simulation, floor: ContactPlane) -> FloatArray:
    """Return the velocity that the push gives, along the floor, shape (3,)."""
    heading = azimuth_direction(simulation.lateral_azimuth_deg)
    heading = heading - (heading @ floor.normal) * floor.normal
    return np.asarray(simulation.lateral_speed_m_s * heading / np.linalg.norm(heading))
