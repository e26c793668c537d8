"""Describe a drop as a chain of free flights with few unknowns and exact derivatives."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from radargui.model.arrays import FloatArray, IntArray
from radargui.motion.free_flight import fall_below_apex, speed_below_apex


@dataclass(frozen=True, slots=True)
class FlightLayout:
    """Where each unknown of some flights stands.

    Order: onset; start x, y, z; g; drag k; its v1; velocity x, y, z at the start of each flight; times of the impacts
    between.
    """

    n_flights: int

    @property
    def onset(self) -> int:
        """Place of the time at which the first flight begins."""
        return 0

    @property
    def start(self) -> slice:
        """Places of the position before the first flight."""
        return slice(1, 4)

    @property
    def gravity(self) -> int:
        """Place of g."""
        return 4

    @property
    def drag(self) -> int:
        """Place of the drag k."""
        return 5

    @property
    def slow(self) -> int:
        """Place of the speed v1 at which the linear part of the drag equals the quadratic one."""
        return 6

    def velocity(self, flight: int) -> slice:
        """Return the places of the velocity at the start of a flight."""
        return slice(7 + 3 * flight, 10 + 3 * flight)

    @property
    def impacts(self) -> slice:
        """Places of the times between flights."""
        return slice(7 + 3 * self.n_flights, self.size)

    @property
    def size(self) -> int:
        """How many unknowns there are."""
        return 6 + 4 * self.n_flights


@dataclass(frozen=True, slots=True)
class Flights:
    """A body that rests, flies, and flies again after each impact, under gravity and drag k (|v| + v1) v.

    Each flight begins where the one before ends. Heights are the series of `fall_below_apex`; sideways, drag counts to
    first order along a steep path.

    Attributes
    ----------
    onset_s
        Start of the first flight; before it the body rests.
    start_m
        Where it rests, shape (3,).
    g_m_s2, drag_1_m, slow_m_s
        g, k and v1, common to all flights.
    velocity_m_s
        At the start of each flight, shape (n_flights, 3).
    impact_s
        Times between flights, shape (n_flights - 1,).
    """

    onset_s: float
    start_m: FloatArray
    g_m_s2: float
    drag_1_m: float
    slow_m_s: float
    velocity_m_s: FloatArray
    impact_s: FloatArray

    @classmethod
    def of(cls, unknowns: FloatArray) -> Flights:
        """Return the flights of unknowns (layout.size,)."""
        layout = FlightLayout((unknowns.size - 6) // 4)
        onset, g, k, slow = (float(unknowns[n]) for n in (layout.onset, layout.gravity, layout.drag, layout.slow))
        velocity = unknowns[7 : layout.impacts.start].reshape(-1, 3)
        return cls(onset, unknowns[layout.start], g, k, slow, velocity, unknowns[layout.impacts])

    @property
    def layout(self) -> FlightLayout:
        """Where the unknowns stand."""
        return FlightLayout(len(self.velocity_m_s))

    @property
    def unknowns(self) -> FloatArray:
        """The unknowns, shape (layout.size,)."""
        head = [self.onset_s, *self.start_m, self.g_m_s2, self.drag_1_m, self.slow_m_s]
        return np.concatenate([head, self.velocity_m_s.ravel(), self.impact_s])

    def _course(self, rise_m_s: FloatArray | float, time_s: FloatArray) -> _Course:
        return _Course(rise_m_s, self.g_m_s2, self.drag_1_m, self.slow_m_s, time_s)

    @property
    def begin_s(self) -> FloatArray:
        """When each flight begins, shape (n_flights,)."""
        return np.append(self.onset_s, self.impact_s)

    def number_at(self, time_s: FloatArray) -> IntArray:
        """Return which flight a time (...) belongs to; -1 at rest."""
        return np.asarray(np.searchsorted(self.begin_s, time_s, side="right") - 1)

    def position_m(self, time_s: FloatArray) -> FloatArray:
        """Return the places (3, n) at times (n,); the last flight goes on for ever."""
        return self.position_and_slopes(time_s, with_slopes=False)[0]

    def velocity_at(self, time_s: FloatArray) -> FloatArray:
        """Return the velocities (3, n) at times (n,), 0 at rest; at an impact that after it."""
        number = self.number_at(time_s)
        flight = np.maximum(number, 0)
        start, velocity = self.begin_s[flight], self.velocity_m_s[flight].T
        after = self._course(velocity[2], time_s - start)
        there = np.stack([*(velocity[:2] * after.share), after.speed_m_s])
        return np.where(number < 0, 0.0, there)

    def velocity_before_m_s(self) -> FloatArray:
        """Return the velocities with which the impacts are reached, shape (n_flights - 1, 3)."""
        velocity = self.velocity_m_s[:-1].T
        end = self._course(velocity[2], np.diff(self.begin_s))
        return np.stack([*(velocity[:2] * end.share), end.speed_m_s], axis=1)

    def position_and_slopes(self, time_s: FloatArray, *, with_slopes: bool = True) -> tuple[FloatArray, FloatArray]:
        """Return the places (3, n) at times (n,), and their derivatives by the unknowns, (layout.size, 3, n).

        Derivatives are exact but for those of what drag does sideways by the vertical velocity, g and k beyond the
        first order. Without slopes their array has no rows.
        """
        layout, n_flights = self.layout, self.layout.n_flights
        number, begin = self.number_at(time_s), self.begin_s
        position = np.repeat(self.start_m[:, None], time_s.size, axis=1)
        slopes = np.zeros((layout.size if with_slopes else 0, 3, time_s.size))
        start, by_start = self.start_m, np.zeros((layout.size, 3))
        by_start[layout.start] = np.eye(3)
        if with_slopes:
            slopes[layout.start] = np.eye(3)[:, :, None]
        for flight in range(n_flights):
            inside = np.flatnonzero(number == flight)
            # the end of a flight is where the next one starts: one more time of it
            end = begin[flight + 1] if flight + 1 < n_flights else begin[flight]
            time = np.append(time_s[inside], end) - begin[flight]
            velocity, place = self.velocity_m_s[flight], layout.velocity(flight)
            course = self._course(velocity[2], time)
            path = np.stack([velocity[0] * course.drift_s, velocity[1] * course.drift_s, course.rise_m])
            position[:, inside] = start[:, None] + path[:, :-1]
            if with_slopes:
                own = np.zeros((layout.size, 3, time.size))
                own[place.start, 0] = own[place.start + 1, 1] = course.drift_s
                shared = (place.start + 2, layout.gravity, layout.drag, layout.slow)
                for row, (drift, rise) in zip(shared, course.slopes(), strict=True):
                    own[row, :2], own[row, 2] = velocity[:2, None] * drift, rise
                speed = np.stack([*(velocity[:2, None] * course.share), course.speed_m_s])
                own[_begins(layout, flight)] -= speed
                slopes[:, :, inside] = by_start[:, :, None] + own[:, :, :-1]
                by_start = by_start + own[:, :, -1]
                if flight + 1 < n_flights:
                    by_start[layout.impacts.start + flight] += speed[:, -1]
            start = start + path[:, -1]
        return position, slopes

    def velocity_before_slopes(self) -> FloatArray:
        """Return the derivatives of `velocity_before_m_s` by the unknowns, (n_flights - 1, 3, layout.size)."""
        layout = self.layout
        _, slopes = self.velocity_and_slopes(self.impact_s, np.arange(layout.n_flights - 1))
        out = np.moveaxis(slopes, -1, 0).transpose(0, 2, 1).copy()
        for flight in range(layout.n_flights - 1):
            # a flight that ends later is as one that began earlier
            out[flight, :, layout.impacts.start + flight] -= out[flight, :, _begins(layout, flight)]
        return out

    def velocity_and_slopes(self, time_s: FloatArray, number: IntArray | None = None) -> tuple[FloatArray, FloatArray]:
        """Return the velocities (3, n) at times (n,), and their derivatives by the unknowns, (layout.size, 3, n).

        In the flights of these numbers, shape (n,), else in those that the times belong to; 0 at rest.
        """
        layout, number = self.layout, self.number_at(time_s) if number is None else number
        out, slopes = np.zeros((3, time_s.size)), np.zeros((layout.size, 3, time_s.size))
        for flight in range(layout.n_flights):
            inside = np.flatnonzero(number == flight)
            velocity, place = self.velocity_m_s[flight], layout.velocity(flight)
            course = self._course(velocity[2], time_s[inside] - self.begin_s[flight])
            out[:, inside] = np.stack([*(velocity[:2, None] * course.share), course.speed_m_s])
            slopes[place.start, 0, inside] = slopes[place.start + 1, 1, inside] = course.share
            shared = (place.start + 2, layout.gravity, layout.drag, layout.slow)
            for by, axes in ((course.speed_slopes(), (2,)), (course.share_slopes(), (0, 1))):
                *values, by_time = by
                for axis in axes:
                    factor = 1.0 if axis == 2 else velocity[axis]
                    for unknown, value in zip(shared, values, strict=True):
                        slopes[unknown, axis, inside] += factor * value
                    slopes[_begins(layout, flight), axis, inside] -= factor * by_time
        return out, slopes

    def acceleration(self, velocity_m_s: FloatArray) -> FloatArray:
        """Return the acceleration (3, n) of a body that flies with velocities (3, n)."""
        drag = self.drag_1_m * (np.linalg.norm(velocity_m_s, axis=0) + self.slow_m_s)
        return np.asarray(-drag * velocity_m_s - np.array([0.0, 0.0, self.g_m_s2])[:, None])

    def acceleration_slopes(self, velocity_m_s: FloatArray, by_unknowns: FloatArray) -> FloatArray:
        """Return the derivatives of `acceleration` by the unknowns, by those of the velocities, (layout.size, 3, n)."""
        layout, speed = self.layout, np.linalg.norm(velocity_m_s, axis=0)
        faster = (by_unknowns * velocity_m_s).sum(axis=1, keepdims=True) / np.maximum(speed, 1e-12)
        out = -self.drag_1_m * ((speed + self.slow_m_s) * by_unknowns + faster * velocity_m_s)
        out[layout.gravity, 2] -= 1.0
        out[layout.drag] -= (speed + self.slow_m_s) * velocity_m_s
        out[layout.slow] -= self.drag_1_m * velocity_m_s
        return np.asarray(out)


def _begins(layout: FlightLayout, flight: int) -> int:
    """Return the place of the time at which a flight begins."""
    return layout.onset if flight == 0 else layout.impacts.start + flight - 1


class _Course:
    """One flight seen from its start: how far it rises, what time counts sideways, at times after it.

    From the apex the body is D0 = -(v/g) (1 - y/3 - c/2 + y^2/5 + y c/2 + c^2/3 - y^3/7) away at the start,
    y = s k v^2 / g, c = k v1 v / g, s the sign of v: the inverse of `speed_below_apex`,
    dt/du = 1 / (g + s k (u + v1) u).
    """

    def __init__(
        self, rise_m_s: FloatArray | float, g_m_s2: float, drag_1_m: float, slow_m_s: float, time_s: FloatArray
    ) -> None:
        v = self._v = np.asarray(rise_m_s)
        g, k = self._g, self._k = g_m_s2, drag_1_m
        self._slow, self._t = slow_m_s, time_s
        y, c = np.sign(v) * k * v**2 / g, k * slow_m_s * v / g
        self._shape = 1.0 + y * (-1.0 / 3.0 + y * (1.0 / 5.0 - y / 7.0)) + c * (-0.5 + 0.5 * y + c / 3.0)
        self._by_y = -1.0 / 3.0 + y * (2.0 / 5.0 - y * 3.0 / 7.0) + 0.5 * c
        self._by_c = -0.5 + 0.5 * y + c * 2.0 / 3.0
        self._first = -v / g * self._shape
        self._y, self._c, self._d = y, c, time_s + self._first

    @property
    def rise_m(self) -> FloatArray:
        """Height above the start."""
        first, d = (fall_below_apex(one, self._g, self._k, self._slow) for one in (self._first, self._d))
        return np.asarray(first - d)

    @property
    def speed_m_s(self) -> FloatArray:
        """Upward velocity."""
        return speed_below_apex(self._d, self._g, self._k, self._slow)

    @property
    def _path_m(self) -> FloatArray:
        """Path travelled up and down, without drag, and v1 t."""
        path = 0.5 * self._g * (self._d * np.abs(self._d) - self._first * np.abs(self._first))
        return np.asarray(path + self._slow * self._t)

    @property
    def share(self) -> FloatArray:
        """Sideways velocity over that at the start."""
        return np.asarray(1.0 - self._k * self._path_m)

    @property
    def drift_s(self) -> FloatArray:
        """Time that counts sideways: t - k times the integral of the path travelled and v1 t."""
        return np.asarray(self._t - self._k * (self._lost + 0.5 * self._slow * self._t**2))

    @property
    def _lost(self) -> FloatArray:
        cubes = (np.abs(self._d) ** 3 - np.abs(self._first) ** 3) / 6.0
        return np.asarray(self._g * (cubes - 0.5 * self._first * np.abs(self._first) * self._t))

    def _first_slopes(self) -> tuple[FloatArray, ...]:
        """Return the derivatives of D0 by v, g, k and v1."""
        v, g, k = self._v, self._g, self._k
        along_y, along_c = self._y * self._by_y, self._c * self._by_c
        # y grows as the square of v, c as v itself; both fall with g
        by_v = -(self._shape + 2.0 * along_y + along_c) / g
        by_g = v / g**2 * (self._shape + along_y + along_c)
        by_k = -v / g * (self._by_y * np.sign(v) * v**2 + self._by_c * self._slow * v) / g
        return by_v, by_g, by_k, -v / g * self._by_c * k * v / g

    def slopes(self) -> tuple[tuple[FloatArray, FloatArray], ...]:
        """Return the derivatives of (`drift_s`, `rise_m`) by the velocity upwards, g, k and v1."""
        g, k, d, first, t = self._g, self._k, self._d, self._first, self._t
        # a start that is later by dD0 is dD0 (v(D) - v(D0)) higher at the same time after it
        by_first = self.speed_m_s - speed_below_apex(first, g, k, self._slow)
        lost_by_first = 0.5 * g * (d * np.abs(d) - first * np.abs(first)) - g * np.abs(first) * t
        linear = 0.5 * t**2
        drifts = (0.0 * t, -k * self._lost / g, -(self._lost + self._slow * linear), -k * linear)
        rises = [at_first - at_d for at_first, at_d in zip(self._fall_slopes(first), self._fall_slopes(d), strict=True)]
        return tuple(
            (np.broadcast_to(drift - k * lost_by_first * by, d.shape), np.broadcast_to(rise + by_first * by, d.shape))
            for by, drift, rise in zip(self._first_slopes(), drifts, (0.0 * t, *rises), strict=True)
        )

    def _fall_slopes(self, after_apex_s: FloatArray) -> tuple[FloatArray, ...]:
        """Return the derivatives of `fall_below_apex` by g, k and v1."""
        g, k, d2 = self._g, self._k, after_apex_s**2
        x, y, brakes = self._terms(after_apex_s)
        by_x = 1.0 / 12.0 + x * (2.0 / 45.0 + x * (51.0 / 2520.0)) + y / 15.0
        by_y = 1.0 / 6.0 + x / 15.0 + y / 12.0
        fall = fall_below_apex(after_apex_s, g, k, self._slow)
        return fall / g + d2 * x * by_x, g * d2 * (by_x * brakes[0] + by_y * brakes[1]), g * d2 * by_y * brakes[2]

    def _terms(self, after_apex_s: FloatArray) -> tuple[FloatArray, FloatArray, tuple[FloatArray, ...]]:
        """Return x and y of the series, and the derivatives of x by k, of y by k and by v1."""
        side = np.where(after_apex_s < 0.0, 1.0, -1.0)
        square, linear = side * self._g * after_apex_s**2, side * np.abs(after_apex_s)
        return self._k * square, self._k * self._slow * linear, (square, self._slow * linear, self._k * linear)

    def speed_slopes(self) -> tuple[FloatArray, ...]:
        """Return the derivatives of `speed_m_s` by the velocity upwards, g, k, v1 and time."""
        g, d = self._g, self._d
        x, y, brakes = self._terms(d)
        by_x = 1.0 / 3.0 + x * (4.0 / 15.0 + x * (17.0 / 105.0)) + y / 3.0
        by_y = 0.5 + x / 3.0 + y / 3.0
        inner = -self.speed_m_s / g
        by_d = -g * np.where(d == 0.0, 1.0, inner / np.where(d == 0.0, 1.0, d)) - g * (2.0 * x * by_x + y * by_y)
        direct = (
            0.0 * d,
            -inner - d * x * by_x,
            -g * d * (by_x * brakes[0] + by_y * brakes[1]),
            -g * d * by_y * brakes[2],
        )
        return *(own + by_d * by for own, by in zip(direct, self._first_slopes(), strict=True)), by_d

    def share_slopes(self) -> tuple[FloatArray, ...]:
        """Return the derivatives of `share` by the velocity upwards, g, k, v1 and time."""
        g, k, d, first = self._g, self._k, self._d, self._first
        by_first = -k * g * (np.abs(d) - np.abs(first))
        fallen = self._path_m - self._slow * self._t
        direct = (0.0 * d, -k * fallen / g, -self._path_m, -k * self._t)
        moved = (own + by_first * by for own, by in zip(direct, self._first_slopes(), strict=True))
        return *moved, -k * (g * np.abs(d) + self._slow)
