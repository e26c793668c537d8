"""Knots of a motion: place, velocity and acceleration at both ends of every step, joined exactly."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import PPoly

from radargui.model.arrays import FloatArray
from radargui.sources.simulated.air import Ballistic, Triple

_Row = tuple[Triple, Triple, Triple, Triple, Triple, Triple]


class Knots:
    """Steps that follow one another; velocity and acceleration may jump between two of them."""

    def __init__(self) -> None:
        self._times: list[float] = [0.0]
        self._rows: list[_Row] = []

    def add(self, start: Ballistic, starting_m_s2: Triple, end: Ballistic, ending_m_s2: Triple) -> None:
        """Add a step with the accelerations at its start and end; one without length is left out."""
        if end.time_s > self._times[-1]:
            self._times.append(end.time_s)
            self._rows.append(
                (start.place_m, start.velocity_m_s, starting_m_s2, end.place_m, end.velocity_m_s, ending_m_s2)
            )

    def joined(self) -> PPoly:
        """Return the position as a function of time: times (n,) give (n, 3).

        Each step is the polynomial of fifth degree with the given place, velocity and acceleration at both ends
        (quintic Hermite interpolation), so that nothing is lost against the integration.
        """
        times = np.array(self._times)
        step = np.diff(times)[:, None]
        place, velocity, acceleration, end, end_velocity, end_acceleration = np.array(self._rows).transpose(1, 0, 2)
        bend = _bend(
            end - place - step * (velocity + 0.5 * step * acceleration),
            step * (end_velocity - velocity - step * acceleration),
            step**2 * (end_acceleration - acceleration),
        )
        higher = [part / step**power for part, power in zip(bend, (5, 4, 3), strict=True)]
        return PPoly(np.stack([*higher, 0.5 * acceleration, velocity, place]), times)


def _bend(place: FloatArray, velocity: FloatArray, acceleration: FloatArray) -> tuple[FloatArray, ...]:
    """Return c5, c4, c3 of c3 s^3 + c4 s^4 + c5 s^5 with these values and two derivatives at s = 1."""
    return (
        6.0 * place - 3.0 * velocity + 0.5 * acceleration,
        -15.0 * place + 7.0 * velocity - acceleration,
        10.0 * place - 4.0 * velocity + 0.5 * acceleration,
    )
