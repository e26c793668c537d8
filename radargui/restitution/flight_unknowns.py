"""The unknowns of a run of free flights, and the motion that follows from them (method 5, Flights)."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from radargui.estimation.posterior.flight_information import MotionInformation
from radargui.estimation.posterior.motion_posterior import MotionPosterior
from radargui.model.arrays import FloatArray, IntArray
from radargui.motion.free_flight import drift_time, fall_below_apex, speed_below_apex
from radargui.restitution.settings import FLIGHTS


@dataclass(frozen=True, slots=True)
class FlightPlan:
    """Which parts of the motion obey the equation of free flight: the first segments between breaks.

    Attributes
    ----------
    n_flights
        How many.
    first_coefficient
        In the first of them, the coefficient (and with it the span) from which on the flight describes the motion: a
        release before it is left to the spline.
    last_span
        Of a fall alone, the span before which it ends; None: flights last until their segments end.
    """

    n_flights: int
    first_coefficient: int
    last_span: int | None = None

    def information(self, posterior: MotionPosterior) -> MotionInformation:
        """Return what the samples say about the flights, the smoothness prior lifted where they take its place."""
        segments = posterior.free.segments[: self.n_flights]
        if self.last_span is None:
            stop, last = segments[-1].stop_coefficient - 1, sum(segment.n_spans for segment in segments)
        else:
            stop, last = self.last_span + 2, self.last_span
        n_breaks = min(self.n_flights, len(posterior.free.segments) - 1)
        return posterior.information(stop, n_breaks, slice(self.first_coefficient, last))


@dataclass(frozen=True, slots=True)
class UnknownLayout:
    """Where each unknown stands.

    Order: g, k; of the first flight apex time, apex height, x and y where it starts, vx, vy; of each further flight
    apex time, vx, vy; times of all breaks; coefficients left free, x, y, z by turns. A flight depends on those before
    it through the place where it starts alone.
    """

    n_flights: int
    n_breaks: int
    n_free: int

    gravity: ClassVar[int] = 0
    drag: ClassVar[int] = 1
    apex_height: ClassVar[int] = 3
    start_place: ClassVar[slice] = slice(4, 6)

    def apex_time(self, flight: int) -> int:
        """Return where the time of a flight's apex stands."""
        return 5 + 3 * flight if flight else 2

    def velocity(self, flight: int) -> slice:
        """Return where vx and vy at the start of a flight stand."""
        # a later flight starts where the one before ended: it has no place of its own
        first = self.apex_time(flight) + 1 if flight else self.start_place.stop
        return slice(first, first + 2)

    @property
    def breaks(self) -> slice:
        """Where the times of the breaks stand."""
        first = self.velocity(self.n_flights - 1).stop
        return slice(first, first + self.n_breaks)

    @property
    def free(self) -> slice:
        """Where the coefficients left free stand."""
        return slice(self.breaks.stop, self.breaks.stop + 3 * self.n_free)

    @property
    def size(self) -> int:
        """How many unknowns there are."""
        return int(self.free.stop)

    def of_flight(self, flight: int) -> IntArray:
        """Return where (g, k, apex time, vx, vy, start, end) of a flight stand, (7,); -1 where it is fixed."""
        velocity = self.velocity(flight)
        start = self.breaks.start + flight - 1 if flight else -1
        end = self.breaks.start + flight if flight < self.n_breaks else -1
        return np.array(
            [self.gravity, self.drag, self.apex_time(flight), velocity.start, velocity.start + 1, start, end]
        )


def impact_rows(results: FloatArray) -> FloatArray:
    """Return time, velocity before and velocity after of each impact between flights, shape (n_impacts, 7, ...).

    A view of results: g, k, then these, shape (2 + 7 n_impacts, ...).
    """
    return results[2:].reshape(-1, 7, *results.shape[1:])


def _fly(own: FloatArray, share: FloatArray, slow_m_s: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the flights of (g, k, apex time, vx, vy, start, end), shape (7, ...), seen from where they start.

    Their paths at shares of their time (n,), the start first, the end last, shape (..., n, 3), and the velocities at
    start and end, shape (..., 3).
    """
    # method 5, Flights: below the apex by a series in g k D^2, sideways by the path travelled
    g, k, apex, vx, vy, first, last = own[..., None]
    time = first + (last - first) * share
    # relative to the start, which drops the apex's own height from all flights but the first
    height = fall_below_apex(first - apex, g, k, slow_m_s) - fall_below_apex(time - apex, g, k, slow_m_s)
    moved = drift_time(time - first, height, k, slow_m_s)
    # sideways speed dies with the path, that of a steep flight being |dz|, and with the time
    path = np.abs(np.diff(height)).sum(axis=-1, keepdims=True)
    slowing = np.exp(-k * (path + slow_m_s * (last - first)))
    return (
        np.stack([vx * moved, vy * moved, height], axis=-1),
        np.concatenate([vx, vy, speed_below_apex(first - apex, g, k, slow_m_s)], axis=-1),
        np.concatenate([vx * slowing, vy * slowing, speed_below_apex(last - apex, g, k, slow_m_s)], axis=-1),
    )


@dataclass(frozen=True, slots=True)
class FlightMotion:
    """What follows from the unknowns, or its derivatives with respect to them (one column each).

    Attributes
    ----------
    x
        The information's x: coefficients and breaks.
    results
        As `impact_rows` has them.
    """

    x: FloatArray
    results: FloatArray


class FlightUnknowns:
    """The unknowns of some flights, and what follows from them.

    Parameters
    ----------
    information
        Of the plan.
    plan
        Which segments are flights.
    """

    def __init__(self, information: MotionInformation, plan: FlightPlan) -> None:
        self.information, self.plan, self.drag = information, plan, information.free.drag
        self.segments = information.free.segments[: plan.n_flights]
        self.collocation = [segment.collocation() for segment in self.segments]
        # coefficient 0 is no unknown: the motion starts at the release position
        # the spline before the flight's first coefficient stays as free as the samples leave it
        self.free = np.arange(1, plan.first_coefficient)
        self.layout = UnknownLayout(plan.n_flights, information.n_breaks, self.free.size)

    def edges(self, q: FloatArray) -> FloatArray:
        """Return start, breaks, end in s for unknowns q, (layout.size,)."""
        edge = self.information.free.edge_s
        return np.concatenate([edge[:1], q[self.layout.breaks], edge[1 + self.layout.n_breaks :]])

    def apexes(self, q: FloatArray) -> FloatArray:
        """Return the times of the apexes, one a flight."""
        return np.array([q[self.layout.apex_time(number)] for number in range(self.plan.n_flights)])

    def motion(self, q: FloatArray) -> FlightMotion:
        """Return the motion and the impacts for unknowns q, (layout.size,): x (n,), results (2 + 7 n_impacts,)."""
        layout, out = self.layout, np.empty(7 * self.plan.n_flights - 5)
        coefficients = np.empty((self.information.size + 1, 3))
        coefficients[self.free] = q[layout.free].reshape(-1, 3)
        impacts, out[:2] = impact_rows(out), q[:2]
        impacts[:, 0] = q[layout.breaks][: len(impacts)]
        start = self._first_start(q)
        for number, (share, solve) in enumerate(self.collocation):
            path, start_m_s, end_m_s = _fly(self._own(q, number), share, self.drag.slow_m_s)
            rows, part = self._rows(number)
            # collocation: the spline that goes through the flight at as many points as it has coefficients
            coefficients[rows] = (solve @ (path + start) - self.information.free.release_m)[part]
            # neighbours meet at the impact by construction, so that its time follows from both
            start = start + path[-1]
            if number > 0:
                impacts[number - 1, 4:] = start_m_s
            if number < len(impacts):
                impacts[number, 1:4] = end_m_s
        return FlightMotion(np.concatenate([coefficients[1:].ravel(), q[layout.breaks]]), out)

    def slopes(self, q: FloatArray) -> FlightMotion:
        """Return the derivatives of `motion` by q, (..., layout.size): central differences within a flight, or ones."""
        layout = self.layout
        coefficients = np.zeros((self.information.size + 1, 3, layout.size))
        coefficients[self.free, :, layout.free] = np.eye(3 * self.free.size).reshape(-1, 3, 3 * self.free.size)
        out = np.eye(7 * self.plan.n_flights - 5, layout.size)
        out[2:] = 0.0
        impacts = impact_rows(out)
        impacts[:, 0, layout.breaks][:, : len(impacts)] = np.eye(len(impacts))
        start = self._first_start_slopes(q)
        # central differences: a flight is smooth in all of them, and its series has no simple slopes
        step = np.array([FLIGHTS.parameter_step] * 2 + [FLIGHTS.time_step] * 5)
        for number, (share, solve) in enumerate(self.collocation):
            places = layout.of_flight(number)
            shifts = np.stack([np.diag(step), -np.diag(step)], axis=1)
            known = places >= 0
            path, after, before = (
                ((value[0] - value[1]) / (2.0 * step.reshape(-1, *(1,) * (value.ndim - 2))))[known]
                for value in _fly(self._own(q, number)[:, None, None] + shifts, share, self.drag.slow_m_s)
            )
            rows, part = self._rows(number)
            coefficients[rows] = start
            coefficients[rows, :, places[known]] += np.moveaxis(solve @ path, 0, 2)[part]
            start[:, places[known]] += path[:, -1].T
            if number > 0:
                impacts[number - 1][4:, places[known]] = after.T
            if number < len(impacts):
                impacts[number][1:4, places[known]] = before.T
        # breaks are unknowns and information at once: their slopes are ones
        by_breaks = np.eye(layout.size)[layout.breaks]
        return FlightMotion(np.concatenate([coefficients[1:].reshape(-1, layout.size), by_breaks]), out)

    @property
    def first_s(self) -> float:
        """When the first flight describes the motion."""
        return float(self.segments[0].knot_s[self.plan.first_coefficient])

    def last_s(self, number: int) -> float:
        """Return when a flight ends in the free motion."""
        segment, stop = self.segments[number], self.plan.last_span
        return segment.end_s if stop is None else float(segment.knot_s[stop])

    def start(self) -> FloatArray:
        """Return the unknowns as the free motion has them, shape (layout.size,)."""
        info, layout, g = self.information, self.layout, self.information.free.gravity_m_s2
        q = np.zeros(layout.size)
        q[layout.gravity], q[layout.drag] = g, self.drag.k_1_m
        q[layout.breaks] = info.x0[3 * info.size :]
        q[layout.free] = info.x0[: 3 * self.free.size]
        for number, segment in enumerate(self.segments):
            first, last = segment.begin_s, self.last_s(number)
            # the first flight begins with the release, which does not fall yet, or with a hand that throws
            early = max(first + 0.3 * (last - first), self.first_s) if number == 0 else first
            time = np.linspace(early, last, 40)[1:-1]
            p = info.free.position_m(time)
            _, slope, level = np.polyfit(time - early, p[2] + 0.5 * g * (time - early) ** 2, 2)
            (vx, x), (vy, y) = (np.polyfit(time - first, p[axis], 1) for axis in (0, 1))
            q[layout.apex_time(number)] = early + slope / g
            q[layout.velocity(number)] = vx, vy
            if number == 0:
                q[layout.apex_height], q[layout.start_place] = level + 0.5 * slope**2 / g, (x, y)
        return q

    def _own(self, q: FloatArray, number: int) -> FloatArray:
        """Return what `_fly` takes of one flight."""
        return np.concatenate([q[self.layout.of_flight(number)[:5]], self.edges(q)[number : number + 2]])

    def _first_start(self, q: FloatArray) -> FloatArray:
        layout = self.layout
        since_apex_s = self.edges(q)[0] - q[layout.apex_time(0)]
        fall = fall_below_apex(since_apex_s, q[layout.gravity], q[layout.drag], self.drag.slow_m_s)
        return np.array([*q[layout.start_place], q[layout.apex_height] - fall])

    def _first_start_slopes(self, q: FloatArray) -> FloatArray:
        out = np.zeros((3, q.size))
        for column in range(self.layout.start_place.stop):
            size = FLIGHTS.parameter_step if column <= self.layout.drag else FLIGHTS.time_step
            moved = np.where(np.arange(q.size) == column, size, 0.0)
            out[:, column] = (self._first_start(q + moved) - self._first_start(q - moved)) / (2.0 * size)
        return out

    def _rows(self, number: int) -> tuple[slice, slice]:
        """Return the coefficients that a flight gives, and which of its own they are."""
        skip = self.plan.first_coefficient if number == 0 else 0
        begin = self.segments[number].first_coefficient
        stop = min(self.segments[number].stop_coefficient, self.information.size + 1)
        return slice(begin + skip, stop), slice(skip, stop - begin)
