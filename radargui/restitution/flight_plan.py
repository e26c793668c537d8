"""Which parts of a motion are free flights, and their common fit."""

from __future__ import annotations

import numpy as np

from radargui.correction.joint.breaks import break_speeds
from radargui.correction.joint.minimise import Solution
from radargui.correction.joint.motion_spline import MotionSpline
from radargui.model.arrays import FloatArray
from radargui.restitution.flight_fit import FlightFit, fit_flights
from radargui.restitution.flight_unknowns import FlightPlan

_AFTER_ONSET_S = 0.010
_LARGEST = 800
_STANDARD_GRAVITY, _NEAR_GRAVITY, _ABOUT_GRAVITY = 9.81, 0.5, 2.5
_GOOD_MISFIT, _SLACK = 1.5, 20.0
_SHORTEST_FALL_S, _BEFORE_CONTACT_S = 0.050, 0.010


def fit_free_flights(solution: Solution, normal: FloatArray, onset_s: float) -> FlightFit | None:
    """Fit the longest run of flights from the release on that obeys the law of free flight.

    Where no two neighbours do, the first fall alone, up to where it ends or something stops it. A misfit that stays
    widens the covariance.

    Parameters
    ----------
    solution
        Converged joint solution.
    normal
        Floor's normal, shape (3,).
    onset_s
        End of the rest; the release's first 10 ms are left out.

    Returns
    -------
    FlightFit or None
        None without free flight.
    """
    spline = solution.at.spline
    impacts = break_speeds(solution, normal).are_impacts()
    n_flights = 1 + int(np.argmin(np.append(impacts, False)))
    if n_flights == spline.break_s.size + 1 and _off_gravity(solution, n_flights - 1) > _NEAR_GRAVITY:
        n_flights -= 1
    first = int(np.searchsorted(spline.knots(), onset_s + _AFTER_ONSET_S))
    if first >= spline.spans[0]:
        return None
    best: FlightFit | None = None
    for count in range(_likely(solution, min(n_flights, _affordable(spline))), 1, -1):
        plan = FlightPlan(count, first)
        fit = fit_flights(plan.information(solution), plan)
        if best is None or fit.reduced_misfit < best.reduced_misfit:
            best = fit
        if _is_good(fit):
            break
    if best is None:
        best = _fit_first_fall(solution, first)
    return best if best is None or _is_good(best) else best.widened()


def _is_good(fit: FlightFit) -> bool:
    return fit.misfit[0] < _GOOD_MISFIT * fit.misfit[1] + _SLACK


def _fit_first_fall(solution: Solution, first: int) -> FlightFit | None:
    """Fit the first fall alone; None where the motion does not fall like a free body for 50 ms.

    A sphere that meets grains has no break in its velocity, and a spline with 10 ms knots feels the contact before it
    comes: the end goes back until the misfit is good, and 10 ms further.
    """
    spline = solution.at.spline
    _, middle, length = spline.jerk()
    end = middle + length / 2.0
    inside = np.arange(first, spline.spans[0])
    step = length[inside] / 4.0
    height = [spline.design(middle[inside] + k * step) @ solution.state.coefficients[:, 2] for k in (-1.0, 0.0, 1.0)]
    falls = np.abs((height[0] - 2.0 * height[1] + height[2]) / step**2 + _STANDARD_GRAVITY) < _ABOUT_GRAVITY
    count = int(np.argmin(np.append(falls, False)))
    begin_s = end[first] - length[first]
    ends = [last for last in range(first + count, first, -1) if end[last - 1] - begin_s > _SHORTEST_FALL_S]

    def fit_until(last: int) -> FlightFit:
        plan = FlightPlan(1, first, last)
        return fit_flights(plan.information(solution), plan)

    best: FlightFit | None = None
    for last in ends:
        fit = fit_until(last)
        if best is None or fit.reduced_misfit < best.reduced_misfit:
            best = fit
        if _is_good(fit):
            before = [other for other in ends if end[other - 1] <= end[last - 1] - _BEFORE_CONTACT_S]
            return fit_until(before[0]) if before else fit
    return best


def _affordable(spline: MotionSpline) -> int:
    """Return how many flights a dense fit can take."""
    sizes = np.cumsum(np.array(spline.spans) + 2)
    return max(1, int(np.searchsorted(sizes, _LARGEST, side="right")))


def _likely(solution: Solution, n_flights: int) -> int:
    """Return how many flights come before one that does not fall at all: the sphere lay, or was carried back."""
    long = np.diff(solution.at.spline.edge_s) > _SHORTEST_FALL_S
    held = (n for n in range(2, n_flights) if long[n] and _off_gravity(solution, n) > _ABOUT_GRAVITY)
    return next(held, n_flights)


def _off_gravity(solution: Solution, segment: int) -> float:
    """Return by how much a segment's acceleration differs from that of gravity, m/s^2."""
    edge = solution.at.spline.edge_s
    length = edge[segment + 1] - edge[segment]
    time = np.linspace(edge[segment] + 0.1 * length, edge[segment + 1] - 0.1 * length, 15)
    height = solution.at.spline.design(time) @ solution.state.coefficients[:, 2]
    return float(abs(2.0 * np.polyfit(time - time[0], height, 2)[0] + _STANDARD_GRAVITY))
