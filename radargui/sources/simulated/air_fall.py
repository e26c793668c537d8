"""The fall through air: drop or bed, slowed by quadratic drag in all directions."""

from __future__ import annotations

import numpy as np

from radargui.model.arrays import FloatArray
from radargui.model.simulation import Simulation
from radargui.sources.simulated.air import Air, Ballistic, Triple, step_for
from radargui.sources.simulated.drop import REST_SPEED_M_S, ROLL_OUT_S, check_it_ends
from radargui.sources.simulated.floor import ContactPlane
from radargui.sources.simulated.glide import PUSH_S, push_velocity_m_s
from radargui.sources.simulated.knots import Knots

_HARDLY_S = 1e-9
_NEWTON_STEPS = 6


class AirFall:
    """What `Drop` and `Bed` do, with the acceleration g - k |v| v and k = `drag_per_m`.

    The flights are integrated in steps that end exactly at the impacts; an impact turns the speed along the floor's
    normal round, e times as fast, and leaves the rest of the velocity. Only rolling out and sinking into a bed, an
    even stop, know no drag. The sideways push of the first 10 ms acts beside gravity and drag.

    Raises
    ------
    SetupError
        The sphere would bounce for more than ten minutes.
    """

    def __init__(self, simulation: Simulation, release_m: FloatArray, surface: ContactPlane) -> None:
        bed = simulation.scene == "bed"
        if not bed:
            check_it_ends(simulation, surface.height_m(release_m), float(surface.normal[2]))
        self._surface = surface
        self._air = Air(simulation.drag_per_m)
        self._step_s = step_for(simulation.gravity_m_s2)
        self._gravity: Triple = (0.0, 0.0, -simulation.gravity_m_s2)
        push = push_velocity_m_s(simulation, surface) / PUSH_S
        self._pushed: Triple = (float(push[0]), float(push[1]), float(push[2]) - simulation.gravity_m_s2)
        self._knots = Knots()
        impacts: list[float] = []
        state = Ballistic(0.0, _triple(release_m), (0.0, 0.0, 0.0))
        while True:
            state = self._flown(state)
            velocity = np.array(state.velocity_m_s)
            speed = -float(surface.normal @ velocity)
            if bed:
                self._last_m_s, self._stop_s = velocity, 2.0 * simulation.bed_depth_m / speed
                break
            impacts.append(state.time_s)
            rebound = simulation.restitution * speed
            if rebound < REST_SPEED_M_S:
                self._last_m_s, self._stop_s = velocity + speed * surface.normal, ROLL_OUT_S
                break
            state = Ballistic(state.time_s, state.place_m, _triple(velocity + (speed + rebound) * surface.normal))
        self._impact_s = np.array(impacts)
        self._touch_s = state.time_s
        self._path = self._knots.joined()

    @property
    def impact_time_s(self) -> FloatArray:
        """Instants of the impacts, shape (n_impacts,); none in a bed."""
        return self._impact_s

    @property
    def duration_s(self) -> float:
        """Time from the release until the sphere stays where it is."""
        return self._touch_s + (self._stop_s if self._last_m_s.any() else 0.0)

    def position_m(self, time_s: FloatArray) -> FloatArray:
        """Return the position, shape (3, n), at times (n,)."""
        flown = np.ascontiguousarray(self._path(np.clip(time_s, 0.0, self._touch_s)).T)
        stopping = np.clip(time_s - self._touch_s, 0.0, self._stop_s)
        return np.asarray(flown + self._last_m_s[:, None] * (stopping - 0.5 * stopping**2 / self._stop_s))

    def _flown(self, state: Ballistic) -> Ballistic:
        """Return the state at the next touch of the surface."""
        while True:
            pushing = state.time_s < PUSH_S
            force = self._pushed if pushing else self._gravity
            step = self._step_s
            if pushing and state.time_s + step > PUSH_S - _HARDLY_S:
                step = PUSH_S - state.time_s
            after = self._air.advanced(state, force, step)
            height, speed = self._above(after)
            touches = height <= 0.0 and speed < 0.0
            if touches:
                after = self._touch(state, force, step)
            self._knots.add(
                state,
                self._air.acceleration_m_s2(state.velocity_m_s, force),
                after,
                self._air.acceleration_m_s2(after.velocity_m_s, force),
            )
            if touches:
                return after
            state = after

    def _touch(self, state: Ballistic, force: Triple, step_s: float) -> Ballistic:
        """Return the state at the touch within a step: Newton's method on the length of the step."""
        for _ in range(_NEWTON_STEPS):
            height, speed = self._above(self._air.advanced(state, force, step_s))
            step_s -= height / speed
        return self._air.advanced(state, force, step_s)

    def _above(self, state: Ballistic) -> tuple[float, float]:
        """Return height above the surface and speed away from it, along its normal."""
        normal, distance = self._surface.normal, self._surface.distance_m
        place, velocity = state.place_m, state.velocity_m_s
        return (
            float(normal[0] * place[0] + normal[1] * place[1] + normal[2] * place[2] - distance),
            float(normal[0] * velocity[0] + normal[1] * velocity[1] + normal[2] * velocity[2]),
        )


def _triple(vector: FloatArray) -> Triple:
    return float(vector[0]), float(vector[1]), float(vector[2])
