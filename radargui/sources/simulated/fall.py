"""Simulate the fall of a sphere onto a plane: the plane, the flight, the bounces and the stop."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.integrate import OdeSolution, solve_ivp
from scipy.interpolate import PPoly

from radargui.model.arrays import FloatArray
from radargui.model.errors import SetupError, worded
from radargui.model.setup import Setup
from radargui.model.simulation import Simulation
from radargui.sources.simulated.noise import Draw, generator

DEFAULT_DROP_M = 0.26
"""Where neither drop height nor floor is given: a fall through the field of view of about 30 cm."""
_LEAST_DROP_M = 1e-4
"""A release nearer to the floor is a slip in the setup, no fall."""
_LEAST_NORMAL_Z = 0.2
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
    if normal[2] < _LEAST_NORMAL_Z:
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
    if plane.height_m(release) < _LEAST_DROP_M:
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
