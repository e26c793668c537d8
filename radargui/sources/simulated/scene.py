"""The scene: rest, motion, rest; where wanted brought back and begun again."""

from __future__ import annotations

import numpy as np

from radargui.model.arrays import FloatArray
from radargui.model.setup import Setup
from radargui.sources.simulated.air_fall import AirFall
from radargui.sources.simulated.bed import Bed
from radargui.sources.simulated.circle import Circle
from radargui.sources.simulated.drop import Drop
from radargui.sources.simulated.floor import contact_plane
from radargui.sources.simulated.pendulum import Pendulum
from radargui.sources.simulated.trajectory import Rest, Trajectory

RETURN_S = 1.5


class Scene:
    """One run: at rest at the release for `rest_s`, the motion, at rest for `settle_s`.

    Parameters
    ----------
    setup
        Scene, release and floor.
    repeat
        After the run the sphere is carried back to the release within 1.5 s and the run begins again, for ever.

    Raises
    ------
    SetupError
        The scene is impossible.
    """

    def __init__(self, setup: Setup, *, repeat: bool = False) -> None:
        simulation = setup.simulation
        self._repeat = repeat
        self._release_m = np.array(setup.tracer.release_position_m)
        self._trajectory = _trajectory(setup, self._release_m)
        self._rest_s = simulation.rest_s
        self._run_s = simulation.rest_s + self._trajectory.duration_s + simulation.settle_s
        self._end_m = self._trajectory.position_m(np.array([self._trajectory.duration_s]))[:, 0]
        self._period_s = self._run_s + RETURN_S

    @property
    def duration_s(self) -> float | None:
        """Length of the scene; None where it repeats for ever."""
        return None if self._repeat else self._run_s

    @property
    def trajectory(self) -> Trajectory:
        """The motion after the release."""
        return self._trajectory

    def position_m(self, time_s: FloatArray) -> FloatArray:
        """Return the position, shape (3, n), at times (n,) from the start of the scene."""
        if not self._repeat:
            return self._trajectory.position_m(time_s - self._rest_s)
        phase_s = np.mod(time_s, self._period_s)
        position = self._trajectory.position_m(phase_s - self._rest_s)
        returning = phase_s > self._run_s
        if returning.any():
            share = (phase_s[returning] - self._run_s) / RETURN_S
            position[:, returning] = self._end_m[:, None] + (self._release_m - self._end_m)[:, None] * minimum_jerk(
                share
            )
        return position

    def impacts_s(self, first_s: float, last_s: float) -> FloatArray:
        """Return the instants of the impacts in [first_s, last_s)."""
        impacts = self._trajectory.impact_time_s + self._rest_s
        if self._repeat:
            rounds = np.arange(max(int(first_s // self._period_s), 0), int(last_s // self._period_s) + 1)
            impacts = (rounds[:, None] * self._period_s + impacts).ravel()
        return np.asarray(impacts[(impacts >= first_s) & (impacts < last_s)])


def _trajectory(setup: Setup, release_m: FloatArray) -> Trajectory:
    simulation = setup.simulation
    match simulation.scene:
        case "drop" | "bed" if simulation.drag_per_m > 0.0:
            return AirFall(simulation, release_m, contact_plane(setup))
        case "drop":
            return Drop(simulation, release_m, contact_plane(setup))
        case "bed":
            return Bed(simulation, release_m, contact_plane(setup))
        case "circle":
            return Circle(simulation, release_m)
        case "pendulum":
            return Pendulum(simulation, release_m)
        case "rest":
            return Rest(release_m)


def minimum_jerk(share: FloatArray) -> FloatArray:
    """Return 10 s^3 - 15 s^4 + 6 s^5 (Flash & Hogan 1985): from 0 to 1, at rest at both ends."""
    return np.asarray(share**3 * (10.0 + share * (6.0 * share - 15.0)))
