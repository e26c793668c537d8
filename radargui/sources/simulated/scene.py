"""Simulate a scene: a rest, a motion, a rest; on demand the tracer is carried back and begins again.

Circle and pendulum are here. Simulate the fall of a sphere onto a plane: the plane, the flight, the bounces and the
stop.
"""

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from scipy.integrate import OdeSolution, solve_ivp
from scipy.interpolate import PPoly
from scipy.special import ellipj, ellipk

from radargui.model.arrays import FloatArray
from radargui.model.errors import SetupError, worded
from radargui.model.setup import Setup
from radargui.model.simulation import Simulation
from radargui.sources.simulated.noise import Draw, generator

DEFAULT_DROP_M = 0.26
"""Where neither drop height nor floor is given: a fall through the field of view of about 30 cm."""
_MIN_DROP_M = 1e-4
"""A release nearer to the floor is a slip in the setup, no fall."""
_MIN_NORMAL_Z = 0.2
"""Cosine of 78 degrees: what is steeper is a wall, on which no sphere comes to rest."""


@dataclass(frozen=True, slots=True)
class Plane:
    """A plane n.x = d.

    Attributes
    ----------
    normal
        Unit vector n towards the sphere, shape (3,).
    distance_m
        d.
    """

    normal: FloatArray
    distance_m: float

    def height_m(self, place_m: FloatArray) -> FloatArray:
        """Return how far places (3, ...) lie before the plane, along the normal, shape (...)."""
        return np.tensordot(self.normal, place_m, axes=1) - self.distance_m


def contact_plane(setup: Setup) -> Plane:
    """Return the plane where the sphere's centre is when it touches the floor of the simulated scene.

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
    if normal[2] < _MIN_NORMAL_Z:
        raise worded(SetupError, "no_floor", normal=[round(float(part), 3) for part in normal])
    if tilt:
        aside = along_plane(azimuth_direction(setup.simulation.floor_tilt_azimuth_deg), normal)
        normal = np.cos(tilt) * normal + np.sin(tilt) * aside
    if setup.simulation.drop_height_m is not None:
        foot = release - np.array([0.0, 0.0, setup.simulation.drop_height_m])
    elif setup.floor.height_m is not None:
        foot = np.array([0.0, 0.0, setup.floor.height_m])
    else:
        foot = release - np.array([0.0, 0.0, DEFAULT_DROP_M])
    plane = Plane(normal, float(normal @ foot))
    if plane.height_m(release) < _MIN_DROP_M:
        raise worded(SetupError, "release_below_floor", release_m=release[2], floor_m=foot[2])
    return plane


def along_plane(heading: FloatArray, normal: FloatArray) -> FloatArray:
    """Return the unit vector of a heading along a plane, shape (3,)."""
    along = heading - (heading @ normal) * normal
    return np.asarray(along / np.linalg.norm(along))


def azimuth_direction(azimuth_deg: float) -> FloatArray:
    """Return the horizontal unit vector of an azimuth, shape (3,)."""
    azimuth = np.radians(azimuth_deg)
    return np.array([np.cos(azimuth), np.sin(azimuth), 0.0])


_REST_SPEED_M_S = 0.02
"""A rebound as slow as this would rise 20 um: the sphere stays down instead."""
_LONGEST_S = 600.0
"""All bounces together; a scene that would take longer is refused. Chosen by hand."""
_ROLL_OUT_S = 0.25
"""In which what is left of the sideways speed ends after the last impact. Chosen by hand."""
_PUSH_S = 0.01
"""In which the sideways speed is given at the release, so that no velocity steps. Chosen by hand."""
_RELATIVE, _ABSOLUTE = 1e-13, 1e-15
"""Errors of a step, in m and m/s: over a run far below 1 nm and 1 ns (tested against closed forms)."""


class Fall:
    """A sphere let go at rest, with the acceleration g - k (|v| + v1) v, `drag_per_m` and `drag_slow_m_s`.

    The flights are integrated (Dormand and Prince, eighth order) up to the very impacts; an impact turns the speed
    along the floor's normal round, e times as fast (`Simulation.restitution_at`), and leaves the rest of the velocity
    (a smooth sphere on a smooth
    floor) but for a random kick along the floor (`kick_m_s`: spin, a rough floor). A rebound slower than 0.02 m/s does
    not lift off any more: the sphere rolls out evenly within 0.25 s. With e = 0 it is a dead stop.

    In a bed it comes to rest `bed_depth_m` below the surface without an impact: the deceleration along the normal is
    constant, v^2 / (2 depth), the speed along the surface falls to zero within the same time. Only rolling out and
    sinking into a bed, an even stop, know no drag.

    A magnet lets a sphere go on one side later than on the other and so pushes it sideways: beside gravity and drag
    an even push along the floor acts for the first 10 ms.

    Attributes
    ----------
    impact_time_s
        Instants of the impacts, shape (n_impacts,); none in a bed.
    duration_s
        Time from the release until the sphere stays where it is.

    Raises
    ------
    SetupError
        The sphere would bounce for more than ten minutes.
    """

    def __init__(self, simulation: Simulation, release_m: FloatArray, surface: Plane, run: int = 0) -> None:
        bed = simulation.scene == "bed"
        upward = float(surface.normal[2])
        if not bed:
            _check_it_ends(simulation, float(surface.height_m(release_m)), upward)
        gravity = np.array([0.0, 0.0, -simulation.gravity_m_s2])
        heading = azimuth_direction(simulation.lateral_azimuth_deg)
        pushed = gravity + simulation.lateral_speed_m_s * along_plane(heading, surface.normal) / _PUSH_S

        away = np.concatenate([surface.normal, np.zeros(3)])

        def height(_: float, state: FloatArray) -> float:
            return float(away @ state) - surface.distance_m

        # only from above: a rebound starts on the plane itself and would touch it again at once
        height.terminal, height.direction = True, -1.0  # type: ignore[attr-defined]
        times, pieces = [0.0], []
        impacts: list[float] = []
        # anew for each run: bounces scatter from drop to drop, the release does not
        kicks = generator(simulation.seed, Draw.KICK, run)
        restitutions = generator(simulation.seed, Draw.RESTITUTION, run)
        time_s, state = 0.0, np.concatenate([release_m, np.zeros(3)])
        first_step_s: float | None = None
        while True:
            end_s, force = (_PUSH_S, pushed) if time_s < _PUSH_S else (time_s + _LONGEST_S, gravity)
            flown = solve_ivp(
                _rate(force, simulation.drag_per_m, simulation.drag_slow_m_s),
                (time_s, end_s),
                state,
                "DOP853",
                events=height,
                dense_output=True,
                first_step=None if first_step_s is None else min(first_step_s, end_s - time_s),
                rtol=_RELATIVE,
                atol=_ABSOLUTE,
            )
            times.extend(flown.sol.ts[1:])
            pieces.extend(flown.sol.interpolants)
            time_s, state = float(flown.t[-1]), flown.y[:, -1]
            # the push has ended above the floor: on with gravity alone
            if flown.status == 0:
                continue
            velocity = state[3:]
            # towards the floor, positive
            speed = -float(surface.normal @ velocity)
            if bed:
                self._last_m_s, self._stop_s = velocity, 2.0 * simulation.bed_depth_m / speed
                break
            impacts.append(time_s)
            rebound = simulation.restitution_at(speed, restitutions.standard_normal()) * speed
            # along the floor only: a kick along the normal would be another restitution
            if simulation.kick_m_s and rebound >= _REST_SPEED_M_S:
                kick = simulation.kick_m_s * kicks.standard_normal(3)
                velocity = velocity + kick - (kick @ surface.normal) * surface.normal
            # without this the flights would become shorter for ever
            if rebound < _REST_SPEED_M_S:
                self._last_m_s, self._stop_s = velocity + speed * surface.normal, _ROLL_OUT_S
                break
            state = np.concatenate([state[:3], velocity + (speed + rebound) * surface.normal])
            # The first step must end above the floor, or the touch would not be seen: in vacuum this is half of the
            # flight, in air less than two thirds, for below its terminal velocity the sphere flies longer than pi / 2
            # times this.
            first_step_s = rebound / (simulation.gravity_m_s2 * upward)
        self._flown = _polynomials(OdeSolution(times, pieces))
        self._ends_m = release_m[:, None], state[:3, None]
        self._touch_s = time_s
        self.impact_time_s: FloatArray = np.array(impacts)
        self.duration_s = self._touch_s + (self._stop_s if self._last_m_s.any() else 0.0)

    def position_m(self, time_s: FloatArray) -> FloatArray:
        """Return the position, shape (3, n), at times (n,)."""
        position = np.where(time_s < self._touch_s, *self._ends_m)
        flying = (time_s > 0.0) & (time_s < self._touch_s)
        if flying.any():
            position[:, flying] = self._flown(time_s[flying]).T
        # an even stop within T: v t - v t^2 / (2 T)
        stopping = np.clip(time_s - self._touch_s, 0.0, self._stop_s)
        return np.asarray(position + self._last_m_s[:, None] * (stopping - 0.5 * stopping**2 / self._stop_s))


_DEGREE = 7
"""Of the polynomial between two steps of the integration."""


def _polynomials(flown: OdeSolution) -> PPoly:
    """Return the positions of a solution as the piecewise polynomial that they are: its own call is a loop of steps."""
    steps_s = np.diff(flown.ts)
    nodes = 0.5 - 0.5 * np.cos(np.linspace(0.0, np.pi, _DEGREE + 1))
    # from inside each step: at an impact the next one begins
    inside = np.clip(nodes, 1e-9, 1.0 - 1e-9)
    places_m = flown((flown.ts[:-1] + inside[:, None] * steps_s).T.ravel())[:3].reshape(3, steps_s.size, -1)
    powers = np.arange(_DEGREE, -1, -1)
    scaled = np.linalg.solve(inside[:, None] ** powers, np.moveaxis(places_m, 2, 0).reshape(_DEGREE + 1, -1))
    scaled = scaled.reshape(_DEGREE + 1, 3, steps_s.size)
    return PPoly(np.moveaxis(scaled / steps_s ** powers[:, None, None], 1, 2), flown.ts)


def _rate(force_m_s2: FloatArray, drag_per_m: float, slow_m_s: float) -> Callable[[float, FloatArray], FloatArray]:
    """Return d/dt (x, v) = (v, f - k (|v| + v1) v); f is gravity and push."""
    shift, push = np.eye(6, k=3), np.concatenate([np.zeros(3), force_m_s2])

    def rate(_: float, state: FloatArray) -> FloatArray:
        change: FloatArray = shift @ state + push
        change[3:] -= drag_per_m * (math.hypot(*state[3:]) + slow_m_s) * state[3:]
        return change

    return rate


def _check_it_ends(simulation: Simulation, height_m: float, upward: float) -> None:
    """Check that a fall of this height, along a normal with this share of the vertical, comes to rest in time.

    Raises
    ------
    SetupError
        The sphere would bounce for more than ten minutes.
    """
    # small bounces last longest
    e = max(simulation.restitution, simulation.restitution_at(_REST_SPEED_M_S))
    # flights last 2 t e, 2 t e^2, ...: with the first fall t (1 + e) / (1 - e) in all, drag apart
    first_s = float(np.sqrt(2.0 * height_m / (simulation.gravity_m_s2 * upward)))
    if first_s * (1.0 + e) / (1.0 - e) > _LONGEST_S:
        raise worded(SetupError, "bounces_too_long", e=e, longest_s=_LONGEST_S)


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
