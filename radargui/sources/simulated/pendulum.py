"""The pendulum: released from rest, the exact solution for any amplitude."""

from __future__ import annotations

import numpy as np
from scipy.special import ellipk, ellipkm1

from radargui.model.arrays import FloatArray
from radargui.model.simulation import Simulation
from radargui.sources.simulated.trajectory import azimuth_direction

_SMALLEST = 1e-18


class Pendulum:
    """A simple pendulum without loss that starts at rest at the release and is caught at a turning point.

    The period is 4 K(m) sqrt(l / g), m = sin^2(theta_0 / 2). The angle sin(theta / 2) = sqrt(m) cd(u, m) (NIST
    Digital Library of Mathematical Functions, 22.19.2) is evaluated by its Fourier series. The release is the
    outermost point along the azimuth.

    Attributes
    ----------
    duration_s
        Time from the release until the sphere is caught.
    """

    impact_time_s: FloatArray = np.empty(0)

    def __init__(self, simulation: Simulation, release_m: FloatArray) -> None:
        start = np.radians(simulation.pendulum_amplitude_deg)
        parameter = float(np.sin(0.5 * start)) ** 2
        self._heading = azimuth_direction(simulation.lateral_azimuth_deg)
        self._length_m = simulation.pendulum_length_m
        self._pivot_m = release_m - self._from_pivot(np.array([start]))[:, 0]
        self.period_s = 4.0 * float(ellipk(parameter)) * float(np.sqrt(self._length_m / simulation.gravity_m_s2))
        self._series = _angle_series(parameter)
        self.duration_s = 0.5 * max(round(2.0 * simulation.turns), 1) * self.period_s

    def angle_rad(self, time_s: FloatArray) -> FloatArray:
        """Return the angle from the vertical at times (n,): sum c_k cos((2 k + 1) 2 pi t / period)."""
        cosine = np.cos((2.0 * np.pi / self.period_s) * np.clip(time_s, 0.0, self.duration_s))
        double = 4.0 * cosine**2 - 2.0
        before, now = cosine, cosine
        angle = self._series[0] * cosine
        for coefficient in self._series[1:]:
            before, now = now, double * now - before
            angle += coefficient * now
        return np.asarray(angle)

    def position_m(self, time_s: FloatArray) -> FloatArray:
        """Return the position, shape (3, n), at times (n,)."""
        return np.asarray(self._pivot_m[:, None] + self._from_pivot(self.angle_rad(time_s)))

    def _from_pivot(self, angle_rad: FloatArray) -> FloatArray:
        down = np.array([0.0, 0.0, -1.0])
        return np.asarray(
            self._length_m * (self._heading[:, None] * np.sin(angle_rad) + down[:, None] * np.cos(angle_rad))
        )


def _angle_series(parameter: float) -> list[float]:
    """Return c_k of theta = sum c_k cos((2 k + 1) w t): c_k = 8 (-1)^k q^(n/2) / (n (1 + q^n)), n = 2 k + 1.

    q = exp(-pi K(1 - m) / K(m)) is the nome. The series is the integral of that of cn (NIST Digital Library of
    Mathematical Functions, 22.11.2), to which the angular velocity is proportional, begun a quarter period earlier.
    """
    nome = float(np.exp(-np.pi * ellipkm1(parameter) / ellipk(parameter)))
    series: list[float] = []
    while not series or abs(series[-1]) > _SMALLEST:
        order = 2 * len(series) + 1
        share = nome ** (0.5 * order) / (order * (1.0 + nome**order))
        series.append(8.0 * (-1) ** len(series) * share)
    return series
