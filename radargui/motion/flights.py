"""A drop as a chain of free flights: where the body is, by few unknowns, with exact derivatives (method 5, Flights)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from radargui.model.arrays import FloatArray, IntArray
from radargui.motion.free_flight import fall_below_apex, speed_below_apex


@dataclass(frozen=True, slots=True)
class FlightLayout:
    """Where each unknown of some flights stands.

    Order: onset; start x, y, z; g; drag; velocity x, y, z at the start of each flight; times of the impacts between.
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

    def velocity(self, flight: int) -> slice:
        """Return the places of the velocity at the start of a flight."""
        return slice(6 + 3 * flight, 9 + 3 * flight)

    @property
    def impacts(self) -> slice:
        """Places of the times between flights."""
        return slice(6 + 3 * self.n_flights, self.size)

    @property
    def size(self) -> int:
        """How many unknowns there are."""
        return 5 + 4 * self.n_flights


@dataclass(frozen=True, slots=True)
class Flights:
    """A body that rests, flies, and flies again after each impact, under gravity and drag k |v| v.

    Each flight begins where the one before ends. Heights are the series of `fall_below_apex`; sideways, drag counts to
    first order along a steep path, dv/ds = -k v, s the path travelled up and down.

    Attributes
    ----------
    onset_s
        Start of the first flight; before it the body rests.
    start_m
        Where it rests, shape (3,).
    g_m_s2, drag_1_m
        g and k, common to all flights.
    velocity_m_s
        At the start of each flight, shape (n_flights, 3).
    impact_s
        Times between flights, shape (n_flights - 1,).
    """

    onset_s: float
    start_m: FloatArray
    g_m_s2: float
    drag_1_m: float
    velocity_m_s: FloatArray
    impact_s: FloatArray

    @classmethod
    def of(cls, unknowns: FloatArray) -> Flights:
        """Return the flights of unknowns (layout.size,)."""
        layout = FlightLayout((unknowns.size - 5) // 4)
        onset, g, k = (float(unknowns[n]) for n in (layout.onset, layout.gravity, layout.drag))
        velocity = unknowns[6 : layout.impacts.start].reshape(-1, 3)
        return cls(onset, unknowns[layout.start], g, k, velocity, unknowns[layout.impacts])

    @property
    def layout(self) -> FlightLayout:
        """Where the unknowns stand."""
        return FlightLayout(len(self.velocity_m_s))

    @property
    def unknowns(self) -> FloatArray:
        """The unknowns, shape (layout.size,)."""
        head = [self.onset_s, *self.start_m, self.g_m_s2, self.drag_1_m]
        return np.concatenate([head, self.velocity_m_s.ravel(), self.impact_s])

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
        after = _Course(velocity[2], self.g_m_s2, self.drag_1_m, time_s - start)
        there = np.stack([*(velocity[:2] * after.share), after.speed_m_s])
        return np.where(number < 0, 0.0, there)

    def velocity_before_m_s(self) -> FloatArray:
        """Return the velocities with which the impacts are reached, shape (n_flights - 1, 3)."""
        velocity = self.velocity_m_s[:-1].T
        end = _Course(velocity[2], self.g_m_s2, self.drag_1_m, np.diff(self.begin_s))
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
            course = _Course(velocity[2], self.g_m_s2, self.drag_1_m, time)
            path = np.stack([velocity[0] * course.drift_s, velocity[1] * course.drift_s, course.rise_m])
            position[:, inside] = start[:, None] + path[:, :-1]
            if with_slopes:
                own = np.zeros((layout.size, 3, time.size))
                own[place.start, 0] = own[place.start + 1, 1] = course.drift_s
                for row, (drift, rise) in zip(
                    (place.start + 2, layout.gravity, layout.drag), course.slopes(), strict=True
                ):
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
        out = np.zeros((layout.n_flights - 1, 3, layout.size))
        for flight, rows in enumerate(out):
            velocity, place = self.velocity_m_s[flight], layout.velocity(flight)
            lasts_s = np.diff(self.begin_s)[flight : flight + 1]
            course = _Course(velocity[2], self.g_m_s2, self.drag_1_m, lasts_s)
            rows[0, place.start] = rows[1, place.start + 1] = course.share[0]
            begin, end = _begins(layout, flight), layout.impacts.start + flight
            for by, side in ((course.speed_slopes(), False), (course.share_slopes(), True)):
                values = [float(one[0]) for one in by]
                for axis in (0, 1) if side else (2,):
                    factor = velocity[axis] if side else 1.0
                    for number, value in zip((place.start + 2, layout.gravity, layout.drag), values[:3], strict=True):
                        rows[axis, number] += factor * value
                    rows[axis, end] += factor * values[3]
                    rows[axis, begin] -= factor * values[3]
        return out


def _begins(layout: FlightLayout, flight: int) -> int:
    """Return the place of the time at which a flight begins."""
    return layout.onset if flight == 0 else layout.impacts.start + flight - 1


class _Course:
    """One flight seen from its start: how far it rises, what time counts sideways, at times after it.

    From the apex the body is D0 = -(v/g) (1 - s y/3 + y^2/5 - s y^3/7) away at the start, y = k v^2 / g, s the sign
    of v: the inverse of `speed_below_apex` (tangent rising, hyperbolic tangent falling).
    """

    def __init__(self, rise_m_s: FloatArray | float, g_m_s2: float, drag_1_m: float, time_s: FloatArray) -> None:
        self._v, self._g, self._k, self._t = np.asarray(rise_m_s), g_m_s2, drag_1_m, time_s
        y = np.sign(self._v) * drag_1_m * self._v**2 / g_m_s2
        self._first = -self._v / g_m_s2 * (1.0 + y * (-1.0 / 3.0 + y * (1.0 / 5.0 - y / 7.0)))
        # d (v f(y)) with y ~ v^2 k / g: f + 2 y f', and so on; f + 2 y f' is 1 / (1 + y)
        self._inverse_slope = 1.0 - y + y * y - y**3
        self._by_y = -1.0 / 3.0 + y * (2.0 / 5.0 - y * 3.0 / 7.0)
        self._y, self._d = y, time_s + self._first

    @property
    def rise_m(self) -> FloatArray:
        """Height above the start."""
        return np.asarray(fall_below_apex(self._first, self._g, self._k) - fall_below_apex(self._d, self._g, self._k))

    @property
    def speed_m_s(self) -> FloatArray:
        """Upward velocity."""
        return speed_below_apex(self._d, self._g, self._k)

    @property
    def _path_m(self) -> FloatArray:
        """Path travelled up and down, without drag."""
        return np.asarray(0.5 * self._g * (self._d * np.abs(self._d) - self._first * np.abs(self._first)))

    @property
    def share(self) -> FloatArray:
        """Sideways velocity over that at the start."""
        return np.asarray(1.0 - self._k * self._path_m)

    @property
    def drift_s(self) -> FloatArray:
        """Time that counts sideways: t - k times the integral of the path travelled."""
        return np.asarray(self._t - self._k * self._lost)

    @property
    def _lost(self) -> FloatArray:
        cubes = (np.abs(self._d) ** 3 - np.abs(self._first) ** 3) / 6.0
        return np.asarray(self._g * (cubes - 0.5 * self._first * np.abs(self._first) * self._t))

    def _first_slopes(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the derivatives of D0 by v, g and k."""
        v, g, y = self._v, self._g, self._y
        f = -self._first * g / np.where(v == 0.0, 1.0, v)
        by_v = -self._inverse_slope / g
        by_g = v / g**2 * (np.where(v == 0.0, 1.0, f) + y * self._by_y)
        by_k = -v / g * self._by_y * np.sign(v) * v**2 / g
        return by_v, by_g, by_k

    def slopes(self) -> tuple[tuple[FloatArray, FloatArray], ...]:
        """Return the derivatives of (`drift_s`, `rise_m`) by the velocity upwards, g and k."""
        k, d, first = self._k, self._d, self._first
        speed, at_first = self.speed_m_s, speed_below_apex(first, self._g, k)
        # a start that is later by dD0 is dD0 (v(D) - v(D0)) higher at the same time after it
        by_first, out = speed - at_first, []
        lost_by_first = 0.5 * self._g * (d * np.abs(d) - first * np.abs(first)) - self._g * np.abs(first) * self._t
        none = np.zeros_like(d)
        direct = (
            (none, none),
            (self._lost / self._g, _by_g(first, self._g, k) - _by_g(d, self._g, k)),
            (none, _by_k(first, self._g, k) - _by_k(d, self._g, k)),
        )
        for by, (lost, rise) in zip(self._first_slopes(), direct, strict=True):
            out.append((-k * (lost + lost_by_first * by), rise + by_first * by))
        drift, rise = out[2]
        out[2] = (drift - self._lost, rise)
        return tuple((np.broadcast_to(a, d.shape), np.broadcast_to(b, d.shape)) for a, b in out)

    def speed_slopes(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Return the derivatives of `speed_m_s` by the velocity upwards, g, k and time."""
        g, k, d = self._g, self._k, self._d
        s = np.where(d < 0.0, 1.0, -1.0)
        x = s * g * k * d * d
        inner = 1.0 + x * (1.0 / 3.0 + x * (2.0 / 15.0 + x * (17.0 / 315.0)))
        by_x = 1.0 / 3.0 + x * (4.0 / 15.0 + x * (17.0 / 105.0))
        by_d = -g * (inner + 2.0 * x * by_x)
        by_v, by_g, by_k = (by_d * one for one in self._first_slopes())
        return by_v, by_g - d * (inner + x * by_x), by_k - g * d * by_x * s * g * d * d, by_d

    def share_slopes(self) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Return the derivatives of `share` by the velocity upwards, g, k and time."""
        g, k, d, first = self._g, self._k, self._d, self._first
        by_first = -k * g * (np.abs(d) - np.abs(first))
        by_v, by_g, by_k = (by_first * one for one in self._first_slopes())
        return by_v, by_g - k * self._path_m / g, by_k - self._path_m, -k * g * np.abs(d)


def _by_g(after_apex_s: FloatArray, g: float, k: float) -> FloatArray:
    """Return the derivative of `fall_below_apex` by g."""
    d2 = after_apex_s**2
    x = np.where(after_apex_s < 0.0, 1.0, -1.0) * g * k * d2
    return np.asarray(d2 * (0.5 + x * (2.0 / 12.0 + x * (3.0 / 45.0 + x * (68.0 / 2520.0)))))


def _by_k(after_apex_s: FloatArray, g: float, k: float) -> FloatArray:
    """Return the derivative of `fall_below_apex` by k."""
    d2, s = after_apex_s**2, np.where(after_apex_s < 0.0, 1.0, -1.0)
    x = s * g * k * d2
    return np.asarray(g * d2 * (s * g * d2) * (1.0 / 12.0 + x * (2.0 / 45.0 + x * (51.0 / 2520.0))))
