"""The unknowns of a run of free flights, and the motion that follows from them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import BSpline

from radargui.correction.joint.flight_information import MotionInformation, motion_information
from radargui.correction.joint.minimise import Solution
from radargui.correction.joint.motion_spline import MotionSpline
from radargui.model.arrays import FloatArray, IntArray
from radargui.restitution.flight_law import drift_time, fall_below_apex, speed_below_apex

_STANDARD_GRAVITY = 9.80665
_STEP, _STEP_OF_LAW = 1e-5, 1e-3


@dataclass(frozen=True, slots=True)
class FlightPlan:
    """Which parts of the motion obey the equation of free flight.

    Flights are the first segments between edges.

    Attributes
    ----------
    n_flights
        How many.
    first_span
        In the first of them, the span from which on the motion is free: a release before it is left to the spline.
    last_span
        Of a fall alone, the span before which it ends; None: flights last until their segments end.
    """

    n_flights: int
    first_span: int
    last_span: int | None = None

    def size(self, spline: MotionSpline) -> int:
        """Return how many of the spline's first coefficients the flights touch."""
        stop = int(_segment_starts(spline.spans)[self.n_flights])
        return stop if self.last_span is None else self.last_span + 2

    def lifted(self, spline: MotionSpline) -> slice:
        """Return the spans that the law of flight describes."""
        return slice(self.first_span, sum(spline.spans[: self.n_flights]) if self.last_span is None else self.last_span)

    def information(self, solution: Solution) -> MotionInformation:
        """Return what the samples say about the flights."""
        spline = solution.at.spline
        n_breaks = min(self.n_flights, spline.break_s.size)
        return motion_information(solution, self.size(spline), n_breaks, self.lifted(spline))


@dataclass(frozen=True, slots=True)
class _Flight:
    """A flight seen from where it starts.

    Attributes
    ----------
    path_m
        At the flight's points in time, the start first, the end last, shape (..., n, 3).
    start_m_s, end_m_s
        Velocities, shape (..., 3).
    """

    path_m: FloatArray
    start_m_s: FloatArray
    end_m_s: FloatArray


def _fly(own: FloatArray, share: FloatArray) -> _Flight:
    """Return the flights of (g, k, apex time, vx, vy, start, end), shape (7, ...), at shares of their time, (n,)."""
    g, k, apex, vx, vy, first, last = own[..., None]
    time = first + (last - first) * share
    height = fall_below_apex(first - apex, g, k) - fall_below_apex(time - apex, g, k)
    moved = drift_time(time - first, height, k)
    slowing = np.exp(-k * np.abs(np.diff(height)).sum(axis=-1, keepdims=True))
    return _Flight(
        np.stack([vx * moved, vy * moved, height], axis=-1),
        np.concatenate([vx, vy, speed_below_apex(first - apex, g, k)], axis=-1),
        np.concatenate([vx * slowing, vy * slowing, speed_below_apex(last - apex, g, k)], axis=-1),
    )


@dataclass(frozen=True, slots=True)
class FlightMotion:
    """What follows from the unknowns.

    Attributes
    ----------
    x
        The information's x: coefficients and breaks.
    outputs
        g, k, then per impact between flights: time, velocity before xyz, after xyz.
    """

    x: FloatArray
    outputs: FloatArray


class FlightUnknowns:
    """The unknowns and their order.

    g, k, first flight (apex time, apex height, x, y, vx, vy), further flights (apex time, vx, vy), times of all breaks,
    coefficients left free. A flight depends on those before it through the place where it starts alone.
    """

    def __init__(self, information: MotionInformation, plan: FlightPlan) -> None:
        self.information, self.plan = information, plan
        spline = information.spline
        self.n_breaks = information.n_breaks
        self.starts = _segment_starts(spline.spans)
        self.collocation = [_collocation(share) for share in spline.fractions[: plan.n_flights]]
        # The coefficient before the first is left out: the motion starts at the release position.
        self.free = np.arange(plan.first_span - 1)
        self.n_law = 8 + 3 * (plan.n_flights - 1)

    def breaks(self, q: FloatArray) -> FloatArray:
        """Return the times of the breaks."""
        return q[self.n_law : self.n_law + self.n_breaks]

    def edges(self, q: FloatArray) -> FloatArray:
        """Return start, breaks, end."""
        edge = self.information.spline.edge_s
        return np.concatenate([edge[:1], self.breaks(q), edge[1 + self.n_breaks :]])

    def apexes(self, q: FloatArray) -> FloatArray:
        """Return the times of the apexes, one a flight."""
        return np.concatenate([q[2:3], q[8 : self.n_law : 3]])

    def motion(self, q: FloatArray) -> FlightMotion:
        """Return the motion and the impacts."""
        coefficients = np.empty((self.information.size + 1, 3))
        coefficients[1 + self.free] = q[self.n_law + self.n_breaks :].reshape(-1, 3)
        start, outputs, before = self._first_start(q), [q[:2]], np.zeros(0)
        for number, (share, solve) in enumerate(self.collocation):
            flight = _fly(self._own(q, number)[0], share)
            rows, part = self._rows(number)
            coefficients[rows] = (solve @ (flight.path_m + start) - self.information.release_m)[part]
            start = start + flight.path_m[-1]
            if number > 0:
                outputs += [self.breaks(q)[number - 1 : number], before, flight.start_m_s]
            before = flight.end_m_s
        return FlightMotion(np.concatenate([coefficients[1:].ravel(), self.breaks(q)]), np.concatenate(outputs))

    def slopes(self, q: FloatArray) -> FlightMotion:
        """Return the derivatives of motion and impacts: central differences within a flight, ones between them."""
        size = self.information.size
        coefficients = np.zeros((size + 1, 3, q.size))
        stop = self.n_law + self.n_breaks
        coefficients[1 + self.free, :, stop:] = np.eye(q.size - stop).reshape(-1, 3, q.size - stop)
        outputs = np.zeros((2 + 7 * (self.plan.n_flights - 1), q.size))
        outputs[:2, :2] = np.eye(2)
        start = self._first_start_slopes(q)
        for number, (share, solve) in enumerate(self.collocation):
            own, places = self._own(q, number)
            step = np.array([_STEP_OF_LAW] * 2 + [_STEP] * 5)
            moved = _fly(own[:, None, None] + np.stack([np.diag(step), -np.diag(step)], axis=1), share)
            known = places >= 0
            path, after, before = (
                ((value[0] - value[1]) / (2.0 * step.reshape(-1, *(1,) * (value.ndim - 2))))[known]
                for value in (moved.path_m, moved.start_m_s, moved.end_m_s)
            )
            rows, part = self._rows(number)
            coefficients[rows] = start
            coefficients[rows, :, places[known]] += np.moveaxis(solve @ path, 0, 2)[part]
            start[:, places[known]] += path[:, -1].T
            if number > 0:
                row = 2 + 7 * (number - 1)
                outputs[row, self.n_law + number - 1] = 1.0
                outputs[row + 4 : row + 7, places[known]] = after.T
            if number < self.plan.n_flights - 1:
                row = 2 + 7 * number
                outputs[row + 1 : row + 4, places[known]] = before.T
        by_breaks = np.eye(q.size)[self.n_law : stop]
        return FlightMotion(np.concatenate([coefficients[1:].reshape(-1, q.size), by_breaks]), outputs)

    def _own(self, q: FloatArray, number: int) -> tuple[FloatArray, IntArray]:
        """Return what `_fly` takes of one flight, and where it stands in q, -1 where it is fixed."""
        edge, law = self.edges(q), 5 + 3 * number
        places = np.array([0, 1, law, law + 1, law + 2]) if number else np.array([0, 1, 2, 6, 7])
        first = self.n_law + number - 1 if number else -1
        last = self.n_law + number if number < self.n_breaks else -1
        return np.concatenate([q[places], edge[number : number + 2]]), np.append(places, [first, last])

    def _first_start(self, q: FloatArray) -> FloatArray:
        g, k, apex, top, x, y = q[:6]
        return np.array([x, y, top - fall_below_apex(self.edges(q)[0] - apex, g, k)])

    def _first_start_slopes(self, q: FloatArray) -> FloatArray:
        out = np.zeros((3, q.size))
        for column, step in enumerate([_STEP_OF_LAW] * 2 + [_STEP] * 4):
            moved = np.where(np.arange(q.size) == column, step, 0.0)
            out[:, column] = (self._first_start(q + moved) - self._first_start(q - moved)) / (2.0 * step)
        return out

    def _rows(self, number: int) -> tuple[slice, slice]:
        """Return the coefficients that a flight gives, and which of its own they are."""
        skip = self.plan.first_span if number == 0 else 0
        begin = int(self.starts[number])
        stop = min(begin + self.collocation[number][0].size, self.information.size + 1)
        return slice(begin + skip, stop), slice(skip, stop - begin)

    def last(self, number: int) -> float:
        """Return when a flight ends in the free motion."""
        edge, stop = self.information.spline.edge_s, self.plan.last_span
        if stop is None:
            return float(edge[number + 1])
        return float(edge[0] + (edge[1] - edge[0]) * self.information.spline.fractions[0][stop])

    def start(self) -> FloatArray:
        """Read the unknowns off the free motion."""
        info = self.information
        coefficients = info.x0[: 3 * info.size].reshape(-1, 3)
        edge, law = info.spline.edge_s, [_STANDARD_GRAVITY, 0.0]
        for number in range(self.plan.n_flights):
            first, last = edge[number], self.last(number)
            early = first + (0.3 * (last - first) if number == 0 else 0.0)
            time = np.linspace(early, last, 40)[1:-1]
            p = info.spline.design(time)[:, : info.size] @ coefficients + info.release_m
            bend, slope, level = np.polyfit(time - early, p[:, 2] + 0.5 * _STANDARD_GRAVITY * (time - early) ** 2, 2)
            del bend
            apex = early + slope / _STANDARD_GRAVITY
            (vx, x), (vy, y) = (np.polyfit(time - first, p[:, axis], 1) for axis in (0, 1))
            law += [apex, level + 0.5 * slope**2 / _STANDARD_GRAVITY, x, y, vx, vy] if number == 0 else [apex, vx, vy]
        return np.concatenate([law, info.x0[3 * info.size :], coefficients[self.free].ravel()])


def _segment_starts(spans: tuple[int, ...]) -> FloatArray:
    """Return the index of each segment's first coefficient, the one left out at the start counted."""
    return np.concatenate([[0], np.cumsum(np.array(spans) + 2)])


def _collocation(fractions: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return Greville points in [0, 1] and the matrix from values there to the segment's coefficients."""
    knots = np.concatenate([np.zeros(3), fractions, np.ones(3)])
    greville = np.array([knots[j + 1 : j + 4].mean() for j in range(knots.size - 4)])
    greville = np.clip(greville, 0.0, 1.0)
    return greville, np.linalg.inv(BSpline.design_matrix(greville, knots, 3).toarray())
