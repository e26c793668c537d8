"""Simulate a scene: a rest, a motion, a rest; on demand the tracer is carried back and begins again.

Circle and pendulum are here.
"""

from abc import ABC, abstractmethod
from typing import TypeAlias

import numpy as np
from scipy.special import ellipj, ellipk

from radargui.model.arrays import FloatArray
from radargui.model.setup import Setup
from radargui.model.simulation import Simulation
from radargui.sources.simulated.fall import Fall, azimuth_direction, contact_plane


class Arc(ABC):
    """Motion on a circle about its middle: middle + r (across sin angle + outward cos angle).

    Parameters
    ----------
    release_m
        Place at the release, shape (3,).
    radius_m
        r.
    across, outward
        Unit vectors, shape (3,).
    start_rad
        Angle at the release.

    Attributes
    ----------
    duration_s
        Time from the release until the tracer stays where it is.
    """

    impact_time_s: FloatArray = np.empty(0)
    duration_s: float

    def __init__(
        self, release_m: FloatArray, radius_m: float, across: FloatArray, outward: FloatArray, start_rad: float = 0.0
    ) -> None:
        self._radius_m, self._across, self._outward = radius_m, across[:, None], outward[:, None]
        self._middle_m = release_m[:, None] - self._from_middle(np.array([start_rad]))

    @abstractmethod
    def angle_rad(self, time_s: FloatArray) -> FloatArray:
        """Return the angle at times (n,) after the release."""

    def position_m(self, time_s: FloatArray) -> FloatArray:
        """Return the position, shape (3, n), at times (n,)."""
        return np.asarray(self._middle_m + self._from_middle(self.angle_rad(time_s)))

    def _from_middle(self, angle_rad: FloatArray) -> FloatArray:
        return np.asarray(self._radius_m * (self._across * np.sin(angle_rad) + self._outward * np.cos(angle_rad)))


class Pendulum(Arc):
    """A simple pendulum without loss that starts at rest at the release and is caught at a turning point.

    The period is 4 K(m) sqrt(l / g), m = sin^2(theta_0 / 2), the angle sin(theta / 2) = sqrt(m) cd(sqrt(g / l) t, m)
    (NIST Digital Library of Mathematical Functions, 22.19.2). The release is the outermost point along the azimuth.
    """

    def __init__(self, simulation: Simulation, release_m: FloatArray) -> None:
        start, length_m = np.radians(simulation.pendulum_amplitude_deg), simulation.pendulum_length_m
        heading, down = azimuth_direction(simulation.lateral_azimuth_deg), np.array([0.0, 0.0, -1.0])
        super().__init__(release_m, length_m, heading, down, start)
        self._parameter = float(np.sin(0.5 * start)) ** 2
        self._rate_1_s = float(np.sqrt(simulation.gravity_m_s2 / length_m))
        self.period_s = 4.0 * float(ellipk(self._parameter)) / self._rate_1_s
        # caught at a turning point, where it rests: no velocity steps
        self.duration_s = 0.5 * max(round(2.0 * simulation.turns), 1) * self.period_s

    def angle_rad(self, time_s: FloatArray) -> FloatArray:
        """Return the angle from the vertical at times (n,): sin(theta / 2) = sqrt(m) cd(u, m)."""
        _, cn, dn, _ = ellipj(self._rate_1_s * np.clip(time_s, 0.0, self.duration_s), self._parameter)
        return np.asarray(2.0 * np.arcsin(np.sqrt(self._parameter) * cn / dn))


class Circle(Arc):
    """A circle that starts at the release.

    Its middle lies `circle_radius_m` away along the azimuth, `circle_tilt_deg` below the horizontal: 0 degrees is a
    horizontal circle, 90 a vertical one that starts at its top. The angular speed grows smoothly over half a period
    (or half the way, where that is shorter), and falls so at the end.
    """

    def __init__(self, simulation: Simulation, release_m: FloatArray) -> None:
        tilt = np.radians(simulation.circle_tilt_deg)
        heading = azimuth_direction(simulation.lateral_azimuth_deg)
        outward = np.array([0.0, 0.0, np.sin(tilt)]) - np.cos(tilt) * heading
        super().__init__(release_m, simulation.circle_radius_m, np.array([-heading[1], heading[0], 0.0]), outward)
        self._rate_rad_s = 2.0 * np.pi / simulation.circle_period_s
        even_s = simulation.turns * simulation.circle_period_s
        # a step of the angular speed would be a step of the Doppler frequency, which no arm can make
        self._ramp_s = min(0.5 * simulation.circle_period_s, even_s)
        self.duration_s = even_s + self._ramp_s

    def angle_rad(self, time_s: FloatArray) -> FloatArray:
        """Return the angle turned since the release: the integral of a rate with smooth ends."""
        ramp, duration = self._ramp_s, self.duration_s
        starting = np.clip(time_s, 0.0, ramp)
        steady = np.clip(time_s - ramp, 0.0, duration - 2.0 * ramp)
        ending = ramp - np.clip(time_s - (duration - ramp), 0.0, ramp)
        turned = _ramped(starting / ramp) + 0.5 - _ramped(ending / ramp)
        return np.asarray(self._rate_rad_s * (ramp * turned + steady))


def _ramped(share: FloatArray) -> FloatArray:
    """Return the integral from 0 of s - sin(2 pi s) / (2 pi), a rise from 0 to 1 without kink."""
    return np.asarray(0.5 * share**2 + (np.cos(2.0 * np.pi * share) - 1.0) / (4.0 * np.pi**2))


class Rest:
    """A sphere that never moves."""

    def __init__(self, place_m: FloatArray) -> None:
        self._place_m = place_m

    duration_s = 0.0
    impact_time_s: FloatArray = np.empty(0)

    def position_m(self, time_s: FloatArray) -> FloatArray:
        """Return the place, shape (3, n)."""
        return np.repeat(self._place_m[:, None], time_s.size, axis=1)


Trajectory: TypeAlias = Fall | Circle | Pendulum | Rest
"""Motion of the sphere's centre, time 0 the release: `position_m` at any time, `impact_time_s`, `duration_s`."""
RETURN_S = 1.5
"""In which a hand brings the sphere back to its release. Chosen by hand."""


class Scene:
    """One run: at rest at the release for `rest_s`, the motion, at rest for `settle_s`.

    Parameters
    ----------
    setup
        Scene, release and floor.
    run
        Each run has its own kicks at the impacts.
    repeat
        After the run the sphere is carried back to the release within 1.5 s and the run begins again, for ever.

    Attributes
    ----------
    trajectory
        The motion after the release.
    duration_s
        Length of the scene; None where it repeats for ever.
    run_s, period_s
        Length of one run, and from one to the next where it repeats.

    Raises
    ------
    SetupError
        The scene is impossible.
    """

    def __init__(self, setup: Setup, *, run: int = 0, repeat: bool = False) -> None:
        simulation = setup.simulation
        self._repeat = repeat
        self._release_m = np.array(setup.tracer.release_position_m)
        self.trajectory = _trajectory(setup, self._release_m, run)
        self._rest_s = simulation.rest_s
        self.run_s = simulation.rest_s + self.trajectory.duration_s + simulation.settle_s
        self._end_m = self.trajectory.position_m(np.array([self.trajectory.duration_s]))[:, 0]
        self.period_s = self.run_s + RETURN_S
        self.duration_s = None if repeat else self.run_s

    def position_m(self, time_s: FloatArray) -> FloatArray:
        """Return the position, shape (3, n), at times (n,) from the start of the scene."""
        if not self._repeat:
            return self.trajectory.position_m(time_s - self._rest_s)
        # a hand brings it back smoothly, so that the trigger sees a motion and no jump
        phase_s = np.mod(time_s, self.period_s)
        position = self.trajectory.position_m(phase_s - self._rest_s)
        returning = phase_s > self.run_s
        way_m = minimum_jerk((phase_s[returning] - self.run_s) / RETURN_S) * (self._release_m - self._end_m)[:, None]
        position[:, returning] = self._end_m[:, None] + way_m
        return position

    def impacts_s(self, first_s: float, last_s: float) -> FloatArray:
        """Return the instants of the impacts in [first_s, last_s)."""
        impacts = self.trajectory.impact_time_s + self._rest_s
        if self._repeat:
            rounds = np.arange(max(int(first_s // self.period_s), 0), int(last_s // self.period_s) + 1)
            impacts = (rounds[:, None] * self.period_s + impacts).ravel()
        return np.asarray(impacts[(impacts >= first_s) & (impacts < last_s)])


def _trajectory(setup: Setup, release_m: FloatArray, run: int) -> Trajectory:
    simulation = setup.simulation
    match simulation.scene:
        case "drop" | "bed":
            return Fall(simulation, release_m, contact_plane(setup), run)
        case "circle":
            return Circle(simulation, release_m)
        case "pendulum":
            return Pendulum(simulation, release_m)
        case "rest":
            return Rest(release_m)


def minimum_jerk(share: FloatArray) -> FloatArray:
    """Return 10 s^3 - 15 s^4 + 6 s^5 (Flash & Hogan 1985): from 0 to 1, at rest at both ends."""
    return np.asarray(share**3 * (10.0 + share * (6.0 * share - 15.0)))
