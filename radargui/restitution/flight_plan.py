"""Which parts of a motion are free flights, and their common fit."""

from __future__ import annotations

import numpy as np

from radargui.correction.joint.breaks import break_speeds
from radargui.correction.joint.flight_information import motion_information
from radargui.correction.joint.minimise import Solution
from radargui.correction.joint.motion_spline import MotionSpline
from radargui.model.arrays import BoolArray, FloatArray
from radargui.restitution.flight_fit import FlightFit, FlightPlan, fit_flights

_AFTER_ONSET_S = 0.010
_LARGEST = 2500
_STANDARD_GRAVITY, _NEAR_GRAVITY = 9.81, 0.5
_GOOD_MISFIT, _SLACK = 1.5, 20.0


def fit_free_flights(solution: Solution, normal: FloatArray, onset_s: float) -> FlightFit | None:
    """Fit the longest run of flights from the release on that obeys the law of free flight.

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
        None without two neighbouring flights, or where the record is too long for a dense fit.
    """
    spline = solution.at.spline
    if 3 * spline.size > _LARGEST:
        return None
    impacts = break_speeds(solution, normal).are_impacts()
    n_flights = 1 + int(np.argmin(np.append(impacts, False)))
    if n_flights == spline.break_s.size + 1 and not _falls_freely(solution, n_flights - 1):
        n_flights -= 1
    first = int(np.searchsorted(spline.knots(), onset_s + _AFTER_ONSET_S))
    if first >= spline.spans[0]:
        return None
    best: FlightFit | None = None
    while n_flights >= 2:
        plan = FlightPlan(tuple(range(n_flights)), first)
        fit = fit_flights(motion_information(solution, _lifted(spline, plan)), plan)
        if best is None or fit.misfit[0] / fit.misfit[1] < best.misfit[0] / best.misfit[1]:
            best = fit
        if fit.misfit[0] < _GOOD_MISFIT * fit.misfit[1] + _SLACK:
            break
        n_flights -= 1
    return best


def _falls_freely(solution: Solution, segment: int) -> bool:
    """Return whether a segment's acceleration is that of gravity within 5 %."""
    edge = solution.at.spline.edge_s
    length = edge[segment + 1] - edge[segment]
    time = np.linspace(edge[segment] + 0.1 * length, edge[segment + 1] - 0.1 * length, 15)
    height = solution.at.spline.design(time) @ solution.state.coefficients[:, 2]
    return bool(abs(2.0 * np.polyfit(time - time[0], height, 2)[0] + _STANDARD_GRAVITY) < _NEAR_GRAVITY)


def _lifted(spline: MotionSpline, plan: FlightPlan) -> BoolArray:
    starts = np.concatenate([[0], np.cumsum(spline.spans)])
    out = np.zeros(starts[-1], dtype=np.bool_)
    for number, segment in enumerate(plan.segments):
        out[starts[segment] + (plan.first_coefficient if number == 0 else 0) : starts[segment + 1]] = True
    return out
