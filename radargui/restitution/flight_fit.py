"""All flights of a run fitted together: common gravity and drag, neighbours meeting at the impacts."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from radargui.correction.joint.flight_information import MotionInformation
from radargui.correction.joint.motion_spline import MotionSpline
from radargui.model.arrays import FloatArray
from radargui.restitution.flight_unknowns import FlightPlan, FlightUnknowns

_DRAG_SD_1_M = 0.04
_STEPS = 20


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
    unknowns = FlightUnknowns(information, plan)
    q = unknowns.start()
    prior = np.zeros(q.size)
    prior[1] = _DRAG_SD_1_M**-2.0
    cost, damping = _cost(unknowns, q, prior), 0.0
    normal, slope = _normal_equations(unknowns, q, prior)
    for _ in range(_STEPS):
        trial = q - _solve(normal + damping * np.diag(np.diag(normal)), slope)
        trial_cost = _cost(unknowns, trial, prior) if _sensible(unknowns, trial) else np.inf
        if trial_cost < cost:
            gained, q, cost = cost - trial_cost, trial, trial_cost
            normal, slope = _normal_equations(unknowns, q, prior)
            damping /= 10.0
            if gained < 1e-3:
                break
        else:
            damping = max(10.0 * damping, 1e-6)
    return _result(unknowns, q, normal)


def _normal_equations(unknowns: FlightUnknowns, q: FloatArray, prior: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return J^T Lambda J + prior, and the slope of the cost."""
    information = unknowns.information
    jacobian = unknowns.slopes(q).x
    pull = information.times(unknowns.motion(q).x - information.x0) + information.slope
    return jacobian.T @ information.times(jacobian) + np.diag(prior), jacobian.T @ pull + prior * q


def _cost(unknowns: FlightUnknowns, q: FloatArray, prior: FloatArray) -> float:
    information = unknowns.information
    offset = unknowns.motion(q).x - information.x0
    return float(0.5 * offset @ information.times(offset) + information.slope @ offset + 0.5 * (prior * q) @ q)


def _sensible(unknowns: FlightUnknowns, q: FloatArray) -> bool:
    rising = (np.diff(unknowns.edges(q)) > 1e-3).all()
    return bool(rising and 5.0 < q[0] < 15.0 and abs(q[1]) < 2.0)


def _result(unknowns: FlightUnknowns, q: FloatArray, normal: FloatArray) -> FlightFit:
    information = unknowns.information
    motion, slopes = unknowns.motion(q), unknowns.slopes(q)
    inverse = _solve(normal, slopes.outputs.T)
    away = motion.x - information.x0 - information.minimum()
    per = motion.outputs[2:].reshape(-1, 7)
    return FlightFit(
        float(q[0]),
        float(q[1]),
        per[:, 0],
        per[:, 1:4],
        per[:, 4:7],
        slopes.outputs @ inverse,
        (float(away @ information.times(away)), information.x0.size - q.size),
        unknowns.apexes(q),
        float(per[0, 0]) if per.size else unknowns.last(0),
        information.spline,
        information.times(slopes.x @ inverse).T[:, : 3 * information.size],
    )


def _solve(matrix: FloatArray, right: FloatArray) -> FloatArray:
    """Solve a symmetric system whose unknowns have very different sizes."""
    scale = 1.0 / np.sqrt(np.maximum(np.diag(matrix), 1e-300))
    scaled = matrix * scale[:, None] * scale[None]
    tail = (slice(None),) + (None,) * (right.ndim - 1)
    return np.asarray(scale[tail] * np.linalg.lstsq(scaled, scale[tail] * right, rcond=1e-15)[0])
