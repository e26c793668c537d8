"""The circle: a tracer carried round in a plane, from rest to rest."""

from __future__ import annotations

import numpy as np

from radargui.model.arrays import FloatArray
from radargui.model.simulation import Simulation
from radargui.sources.simulated.trajectory import azimuth_direction


class Circle:
    """A circle that starts at the release.

    Its middle lies `circle_radius_m` away along the azimuth, `circle_tilt_deg` below the horizontal: 0 degrees is a
    horizontal circle, 90 a vertical one that starts at its top. The angular speed grows smoothly over half a period
    (or half the way, where that is shorter), and falls so at the end.
    """

    impact_time_s: FloatArray = np.empty(0)

    def __init__(self, simulation: Simulation, release_m: FloatArray) -> None:
        tilt = np.radians(simulation.circle_tilt_deg)
        heading = azimuth_direction(simulation.lateral_azimuth_deg)
        self._inward = np.cos(tilt) * heading - np.array([0.0, 0.0, np.sin(tilt)])
        self._across = np.array([-heading[1], heading[0], 0.0])
        self._radius_m = simulation.circle_radius_m
        self._middle_m = release_m + self._radius_m * self._inward
        self._rate_rad_s = 2.0 * np.pi / simulation.circle_period_s
        even_s = simulation.turns * simulation.circle_period_s
        self._ramp_s = min(0.5 * simulation.circle_period_s, even_s)
        self._duration_s = even_s + self._ramp_s

    @property
    def duration_s(self) -> float:
        """Time from the release until the tracer stays where it is."""
        return self._duration_s

    def angle_rad(self, time_s: FloatArray) -> FloatArray:
        """Return the angle turned since the release: the integral of a rate with smooth ends."""
        ramp, duration = self._ramp_s, self._duration_s
        starting = np.clip(time_s, 0.0, ramp)
        steady = np.clip(time_s - ramp, 0.0, duration - 2.0 * ramp)
        ending = ramp - np.clip(time_s - (duration - ramp), 0.0, ramp)
        turned = _ramped(starting / ramp) + 0.5 - _ramped(ending / ramp)
        return np.asarray(self._rate_rad_s * (ramp * turned + steady))

    def position_m(self, time_s: FloatArray) -> FloatArray:
        """Return the position, shape (3, n), at times (n,)."""
        angle = self.angle_rad(time_s)
        return np.asarray(
            self._middle_m[:, None]
            + self._radius_m * (self._across[:, None] * np.sin(angle) - self._inward[:, None] * np.cos(angle))
        )


def _ramped(share: FloatArray) -> FloatArray:
    """Return the integral from 0 of s - sin(2 pi s) / (2 pi), a rise from 0 to 1 without kink."""
    return np.asarray(0.5 * share**2 + (np.cos(2.0 * np.pi * share) - 1.0) / (4.0 * np.pi**2))
