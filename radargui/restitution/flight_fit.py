"""All flights of a run fitted together: common gravity and drag, neighbours meeting at the impacts."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import BSpline

from radargui.correction.joint.flight_information import MotionInformation, motion_information
from radargui.correction.joint.minimise import Solution
from radargui.correction.joint.motion_spline import MotionSpline
from radargui.model.arrays import FloatArray
from radargui.restitution.flight_law import drift_time, fall_below_apex, speed_below_apex

_STANDARD_GRAVITY = 9.80665
_DRAG_SD_1_M = 0.04
_STEPS = 20


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
class FlightFit:
    """The fitted flights.

    Attributes
    ----------
    g_m_s2, drag_1_m
        Common gravity and drag.
    impact_s, before_m_s, after_m_s
        At the impacts between flights: time, velocities (3,) just before and just after; shapes (n,), (n, 3), (n, 3).
    covariance
        Of (g, k, then per impact: time, before xyz, after xyz).
    misfit
        Chi-square of the flights against the free motion, and its degrees of freedom.
    apex_s
        Times of the apexes, one a flight.
    first_end_s
        End of the first flight.
    spline, response
        The free motion, and the derivative of what `covariance` is of with respect to its first coefficients (x, y, z
        interleaved).
    """

    g_m_s2: float
    drag_1_m: float
    impact_s: FloatArray
    before_m_s: FloatArray
    after_m_s: FloatArray
    covariance: FloatArray
    misfit: tuple[float, int]
    apex_s: FloatArray
    first_end_s: float
    spline: MotionSpline
    response: FloatArray

    @property
    def reduced_misfit(self) -> float:
        """Chi-square of the flights over its degrees of freedom."""
        return self.misfit[0] / self.misfit[1]

    def widened(self) -> FlightFit:
        """Return the fit with its covariance widened by the reduced misfit, where that is above one."""
        return replace(self, covariance=self.covariance * max(1.0, self.reduced_misfit))

    def u_change(self) -> FloatArray:
        """Return the uncertainty of a horizontal component of the velocity's change at each impact, (n_impacts,)."""
        rows = np.zeros((2 * self.impact_s.size, self.covariance.shape[0]))
        for row in range(rows.shape[0]):
            place = 2 + 7 * (row // 2) + row % 2
            rows[row, place + 1], rows[row, place + 4] = -1.0, 1.0
        variance = np.einsum("ij,jk,ik->i", rows, self.covariance, rows)
        return np.asarray(np.sqrt(variance.reshape(-1, 2).mean(axis=1)))

    def u_g(self) -> float:
        """Return the standard uncertainty of g from noise and fit."""
        return float(np.sqrt(self.covariance[0, 0]))


class _Parameters:
    """The unknowns and their order.

    g, k, first flight (apex time, apex height, x, y, vx, vy), further flights (apex time, vx, vy), times of all breaks,
    coefficients left free.
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

    def split(self, q: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return law unknowns, break times, free coefficients (n_free, 3)."""
        stop = self.n_law + self.n_breaks
        return q[: self.n_law], q[self.n_law : stop], q[stop:].reshape(-1, 3)

    def edges(self, breaks: FloatArray) -> FloatArray:
        edge = self.information.spline.edge_s
        return np.concatenate([edge[:1], breaks, edge[1 + self.n_breaks :]])

    def law(self, q: FloatArray) -> tuple[FloatArray, list[FloatArray], FloatArray]:
        """Return the spline's coefficients under the law, and velocities (before, after) at impacts between flights."""
        law, breaks, free = self.split(q)
        g, k, apex, top, x, y, vx, vy = law[:8]
        edge, size = self.edges(breaks), self.information.size
        coefficients = np.empty((size + 1, 3))
        coefficients[1 + self.free] = free
        speeds: list[FloatArray] = []
        apexes: list[float] = []
        place, ground = np.array([x, y]), 0.0
        along = np.array([vx, vy])
        for number in range(self.plan.n_flights):
            first, last = edge[number], edge[number + 1]
            if number > 0:
                apex, vx, vy = law[8 + 3 * (number - 1) : 11 + 3 * (number - 1)]
                top = ground + float(fall_below_apex(np.array([first - apex]), g, k)[0])
                along = np.array([vx, vy])
                start_speed = np.array([vx, vy, speed_below_apex(first - apex, g, k)])
                speeds[-1] = np.concatenate([speeds[-1], start_speed])
            where, solve = self.collocation[number]
            time = first + (last - first) * where
            height = top - fall_below_apex(time - apex, g, k)
            moved = drift_time(time - first, height, k)
            points = np.stack([place[0] + along[0] * moved, place[1] + along[1] * moved, height], axis=1)
            own = solve @ points - self.information.release_m
            skip = self.plan.first_span if number == 0 else 0
            begin, end = self.starts[number] + skip, min(self.starts[number] + own.shape[0], size + 1)
            coefficients[begin:end] = own[skip : skip + end - begin]
            place, ground = points[-1, :2], float(points[-1, 2])
            slowing = np.exp(-k * np.abs(np.diff(height)).sum())
            speeds.append(np.array([*(along * slowing), speed_below_apex(last - apex, g, k)]))
            apexes.append(apex)
        return coefficients[1:], speeds[:-1], np.array(apexes)

    def x(self, q: FloatArray) -> FloatArray:
        """Return coefficients and breaks as the information's x."""
        return np.concatenate([self.law(q)[0].ravel(), self.split(q)[1]])

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


def fit_flights(information: MotionInformation, plan: FlightPlan) -> FlightFit:
    """Fit gravity, drag, flights and impact times by generalised least squares on the motion's information.

    Neighbouring flights meet at their impact by construction, so that the impact's time follows from both. The drag
    has the prior N(0, 0.04^2) 1/m (a 10 mm sphere of steel has 0.005, of light plastic 0.05).

    Parameters
    ----------
    information
        From `motion_information` with the smoothness prior lifted from the flights' spans.
    plan
        Which segments are flights.
    """
    parameters = _Parameters(information, plan)
    q = parameters.start()
    prior = np.zeros(q.size)
    prior[1] = _DRAG_SD_1_M**-2.0
    cost, damping = _cost(parameters, q, prior), 0.0
    for _ in range(_STEPS):
        jacobian = _jacobian(parameters, q)
        offset = parameters.x(q) - information.x0
        normal = jacobian.T @ information.matrix @ jacobian + np.diag(prior)
        slope = jacobian.T @ (information.matrix @ offset + information.slope) + prior * q
        trial = q - _solve(normal + damping * np.diag(np.diag(normal)), slope)
        trial_cost = _cost(parameters, trial, prior) if _sensible(parameters, trial) else np.inf
        if trial_cost < cost:
            gained, q, cost = cost - trial_cost, trial, trial_cost
            damping /= 10.0
            if gained < 1e-3:
                break
        else:
            damping = max(10.0 * damping, 1e-6)
    jacobian = _jacobian(parameters, q)
    normal = jacobian.T @ information.matrix @ jacobian + np.diag(prior)
    return _result(parameters, q, normal)


def _cost(parameters: _Parameters, q: FloatArray, prior: FloatArray) -> float:
    offset = parameters.x(q) - parameters.information.x0
    matrix, slope = parameters.information.matrix, parameters.information.slope
    return float(0.5 * offset @ (matrix @ offset) + slope @ offset + 0.5 * (prior * q) @ q)


def _sensible(parameters: _Parameters, q: FloatArray) -> bool:
    rising = (np.diff(parameters.edges(parameters.split(q)[1])) > 1e-3).all()
    return bool(rising and 5.0 < q[0] < 15.0 and abs(q[1]) < 2.0)


def _result(parameters: _Parameters, q: FloatArray, normal: FloatArray) -> FlightFit:
    information = parameters.information
    outputs = _outputs(parameters, q)
    rows = np.zeros((outputs.size, q.size))
    for column in range(parameters.n_law + parameters.n_breaks):
        step = _step_of(column)
        moved = q.copy()
        moved[column] += step
        back = q.copy()
        back[column] -= step
        rows[:, column] = (_outputs(parameters, moved) - _outputs(parameters, back)) / (2.0 * step)
    inverse = _solve(normal, rows.T)
    covariance = rows @ inverse
    offset = parameters.x(q) - information.x0
    free = -_solve(information.matrix, information.slope, 1e-10)
    chi = float((offset - free) @ information.matrix @ (offset - free))
    per = outputs[2:].reshape(-1, 7)
    return FlightFit(
        float(q[0]),
        float(q[1]),
        per[:, 0],
        per[:, 1:4],
        per[:, 4:7],
        covariance,
        (chi, information.x0.size - q.size),
        parameters.law(q)[2],
        float(per[0, 0]) if per.size else parameters.last(0),
        information.spline,
        _response(parameters, q, inverse)[:, : 3 * information.size],
    )


def _response(parameters: _Parameters, q: FloatArray, inverse: FloatArray) -> FloatArray:
    return np.asarray(inverse.T @ _jacobian(parameters, q).T @ parameters.information.matrix)


def _outputs(parameters: _Parameters, q: FloatArray) -> FloatArray:
    speeds = parameters.law(q)[1]
    breaks = parameters.split(q)[1]
    out = [q[:2]]
    for number, pair in enumerate(speeds):
        out += [breaks[number : number + 1], pair]
    return np.concatenate(out)


def _jacobian(parameters: _Parameters, q: FloatArray) -> FloatArray:
    """Return dx/dq: central differences for the law and the breaks, ones for the free coefficients."""
    base = parameters.x(q)
    out = np.zeros((base.size, q.size))
    for column in range(parameters.n_law + parameters.n_breaks):
        step = _step_of(column)
        moved, back = q.copy(), q.copy()
        moved[column] += step
        back[column] -= step
        out[:, column] = (parameters.x(moved) - parameters.x(back)) / (2.0 * step)
    stop = parameters.n_law + parameters.n_breaks
    rows = (3 * parameters.free[:, None] + np.arange(3)).ravel()
    out[rows, stop + np.arange(rows.size)] = 1.0
    return out


def _step_of(column: int) -> float:
    return 1e-3 if column < 2 else 1e-5


def _solve(matrix: FloatArray, right: FloatArray, cut: float = 1e-15) -> FloatArray:
    """Solve a symmetric system whose unknowns have very different sizes."""
    scale = 1.0 / np.sqrt(np.maximum(np.diag(matrix), 1e-300))
    scaled = matrix * scale[:, None] * scale[None]
    tail = (slice(None),) + (None,) * (right.ndim - 1)
    return np.asarray(scale[tail] * np.linalg.lstsq(scaled, scale[tail] * right, rcond=cut)[0])


def _segment_starts(spans: tuple[int, ...]) -> FloatArray:
    """Return the index of each segment's first coefficient, the one left out at the start counted."""
    return np.concatenate([[0], np.cumsum(np.array(spans) + 2)])


def _collocation(fractions: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return Greville points in [0, 1] and the matrix from values there to the segment's coefficients."""
    knots = np.concatenate([np.zeros(3), fractions, np.ones(3)])
    greville = np.array([knots[j + 1 : j + 4].mean() for j in range(knots.size - 4)])
    greville = np.clip(greville, 0.0, 1.0)
    return greville, np.linalg.inv(BSpline.design_matrix(greville, knots, 3).toarray())
