"""Bounces of a joint estimate: e from the speeds of the flights at the instant of impact."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from radargui.correction.joint.breaks import BreakSpeeds, break_speeds, one_sided_slopes, side_covariance
from radargui.correction.joint.estimate import JointEstimate
from radargui.correction.joint.minimise import Solution
from radargui.model.arrays import FloatArray
from radargui.model.bounce import Bounce, Bounces, FreeFall
from radargui.model.setup import Setup
from radargui.restitution.cross_check import cross_check
from radargui.restitution.flight_fit import FlightFit
from radargui.restitution.flight_rivals import fit_with_rivals
from radargui.restitution.impact_normal import FloorNormal, normal_of_impacts

_USABLE_U_E = 0.05
_STANDARD_GRAVITY = 9.81
_CHECK_STEP_S = 0.001


def joint_bounces(estimate: JointEstimate, setup: Setup) -> tuple[Bounces, FlightFit | None]:
    """Return the bounces, and the fit of the flights where there is one.

    Impacts between fitted flights take the flights' speeds; others the one-sided slopes of the motion. Standard
    uncertainties are those of the posterior and its rivals, and that of the floor's normal where it is
    found from the impacts.

    Parameters
    ----------
    estimate
        From `estimate_joint`.
    setup
        Its floor's normal is the direction of the speeds; where it gives none, the one the impacts support.
    """
    solution = estimate.chosen.solution
    floor = FloorNormal(np.asarray(setup.floor.normal))
    fit = fit_with_rivals(estimate.chosen, floor.normal, estimate.onset_s)
    given = "normal" in setup.floor.model_fields_set
    if not given:
        floor = _found_normal(solution, floor.normal, fit)
        if floor.tilted:
            fit = fit_with_rivals(estimate.chosen, floor.normal, estimate.onset_s)
    speeds = break_speeds(solution, floor.normal)
    covariance = side_covariance(solution, floor.normal)
    slopes = _Slopes.of(solution)
    bounces = []
    for number in np.flatnonzero(speeds.are_impacts()):
        if fit is not None and number < fit.impact_s.size:
            bounces.append(_from_flights(fit, int(number), floor))
        else:
            bounces.append(_from_slopes(speeds, covariance, slopes, int(number), floor))
    fall = None if fit is None else _free_fall(estimate, fit, floor.normal)
    x, y, z = (float(part) for part in floor.normal)
    found = Bounces(tuple(bounces), fall, (x, y, z), None if given or not bounces else floor.u_tilt_deg)
    return _checked(found, estimate, fit, floor.normal), fit


@dataclass(frozen=True, slots=True)
class _Slopes:
    """Velocities just before and just after each break, shapes (n_breaks, 3)."""

    before_m_s: FloatArray
    after_m_s: FloatArray

    @staticmethod
    def of(solution: Solution) -> _Slopes:
        spline, coefficients = solution.at.spline, solution.state.coefficients
        if spline.break_s.size == 0:
            return _Slopes(np.zeros((0, 3)), np.zeros((0, 3)))
        before, after = one_sided_slopes(spline)
        return _Slopes(before @ coefficients, after @ coefficients)


def _found_normal(solution: Solution, level: FloatArray, fit: FlightFit | None) -> FloorNormal:
    """Return the normal that all impacts support: between fitted flights by their speeds, else by the slopes."""
    impacts = break_speeds(solution, level).are_impacts()
    if not impacts.any():
        return FloorNormal(level)
    slopes = _Slopes.of(solution)
    u = np.sqrt(np.mean([break_speeds(solution, axis).u_jump_m_s ** 2 for axis in np.eye(3)[:2]], axis=0))
    if fit is not None:
        first = slice(0, fit.impact_s.size)
        slopes.before_m_s[first], slopes.after_m_s[first], u[first] = fit.before_m_s, fit.after_m_s, fit.u_change()
    return normal_of_impacts(slopes.before_m_s[impacts], slopes.after_m_s[impacts], u[impacts])


def _bounce(
    time_s: float, before: float, after: float, covariance: FloatArray, by_normal: float, method: str
) -> Bounce:
    """Return e = after / before with u_e from the covariance of (before, after), both positive, and the normal's."""
    e = after / before
    slope = np.array([-e / before, 1.0 / before])
    u_e = float(np.sqrt(max(float(slope @ covariance @ slope), 0.0) + by_normal))
    return Bounce(time_s, before, after, e, u_e, method, bool(0.0 < e < 1.2 and u_e < _USABLE_U_E))


def _from_flights(fit: FlightFit, number: int, floor: FloorNormal) -> Bounce:
    place = 2 + 7 * number
    rows = np.zeros((2, fit.covariance.shape[0]))
    rows[0, place + 1 : place + 4] = -floor.normal
    rows[1, place + 4 : place + 7] = floor.normal
    covariance = rows @ fit.covariance @ rows.T
    before, after = fit.before_m_s[number], fit.after_m_s[number]
    speeds = -float(before @ floor.normal), float(after @ floor.normal)
    return _bounce(float(fit.impact_s[number]), *speeds, covariance, floor.e_variance(before, after), "flights")


def _from_slopes(
    speeds: BreakSpeeds, covariance: FloatArray, slopes: _Slopes, number: int, floor: FloorNormal
) -> Bounce:
    before, after = -float(speeds.before_m_s[number]), float(speeds.after_m_s[number])
    sign = np.array([-1.0, 1.0])
    own = covariance[number] * sign[:, None] * sign
    by_normal = floor.e_variance(slopes.before_m_s[number], slopes.after_m_s[number])
    return _bounce(float(speeds.time_s[number]), before, after, own, by_normal, "slopes")


def _checked(bounces: Bounces, estimate: JointEstimate, fit: FlightFit | None, normal: FloatArray) -> Bounces:
    """Return the bounces with e from flight times and heights of the free motion, under the fitted g and drag."""
    spline = estimate.chosen.solution.at.spline
    time = np.arange(estimate.onset_s, float(spline.edge_s[-1]), _CHECK_STEP_S)
    height = spline.design(time) @ (estimate.chosen.solution.state.coefficients @ normal)
    g, drag = (_STANDARD_GRAVITY, 0.0) if fit is None else (fit.g_m_s2, fit.drag_1_m)
    return cross_check(bounces, time, height, g * float(normal[2]), drag)


def _free_fall(estimate: JointEstimate, fit: FlightFit, normal: FloatArray) -> FreeFall:
    """Return the first fall against the parabola with the flights' g."""
    solution = estimate.chosen.solution
    first, last = estimate.onset_s + 0.010, fit.first_end_s
    time = np.linspace(first, last, 200)
    release = float(solution.problem.stage.release_m @ normal)
    height = solution.at.spline.design(time) @ (solution.state.coefficients @ normal) + release
    bend, slope, level = np.polyfit(time - first, height, 2)
    residual = height - np.polyval([bend, slope, level], time - first)
    return FreeFall(
        fit.g_m_s2,
        fit.u_g(),
        first,
        last,
        release,
        float(release - height[-1]) if fit.impact_s.size else float("nan"),
        (float(level), float(slope), float(bend)),
        float(np.sqrt((residual**2).mean())),
    )
