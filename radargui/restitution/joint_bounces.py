"""Bounces of a joint estimate: e from the speeds of the flights at the instant of impact."""

from __future__ import annotations

import numpy as np

from radargui.correction.joint.breaks import BreakSpeeds, break_speeds, side_covariance
from radargui.correction.joint.estimate import JointEstimate
from radargui.model.arrays import FloatArray
from radargui.model.bounce import Bounce, Bounces, FreeFall
from radargui.model.setup import Setup
from radargui.restitution.flight_fit import FlightFit
from radargui.restitution.flight_plan import fit_free_flights

_COVERAGE = 1.5
_USABLE_U_E = 0.05


def joint_bounces(estimate: JointEstimate, setup: Setup) -> tuple[Bounces, FlightFit | None]:
    """Return the bounces, and the fit of the flights where there is one.

    Impacts between fitted flights take the flights' speeds; others the one-sided slopes of the motion. Standard
    uncertainties are those of the posterior times 1.5, as for the motion.

    Parameters
    ----------
    estimate
        From `estimate_joint`.
    setup
        Its floor's normal is the direction of the speeds.
    """
    solution, normal = estimate.chosen.solution, np.asarray(setup.floor.normal)
    fit = fit_free_flights(solution, normal, estimate.onset_s)
    speeds = break_speeds(solution, normal)
    covariance = side_covariance(solution, normal)
    bounces = []
    for number in np.flatnonzero(speeds.are_impacts()):
        if fit is not None and number < fit.impact_s.size:
            bounces.append(_from_flights(fit, int(number), normal))
        else:
            bounces.append(_from_slopes(speeds, covariance, int(number)))
    return Bounces(tuple(bounces), None if fit is None else _free_fall(estimate, fit)), fit


def _bounce(time_s: float, before: float, after: float, covariance: FloatArray, method: str) -> Bounce:
    """Return e = after / before with u_e from the covariance of (before, after), both positive."""
    e = after / before
    slope = np.array([-e / before, 1.0 / before])
    u_e = _COVERAGE * float(np.sqrt(max(slope @ covariance @ slope, 0.0)))
    return Bounce(time_s, before, after, e, u_e, method, bool(0.0 < e < 1.2 and u_e < _USABLE_U_E))


def _from_flights(fit: FlightFit, number: int, normal: FloatArray) -> Bounce:
    place = 2 + 7 * number
    rows = np.zeros((2, fit.covariance.shape[0]))
    rows[0, place + 1 : place + 4] = -normal
    rows[1, place + 4 : place + 7] = normal
    covariance = rows @ fit.covariance @ rows.T
    before, after = -float(fit.before_m_s[number] @ normal), float(fit.after_m_s[number] @ normal)
    return _bounce(float(fit.impact_s[number]), before, after, covariance, "flights")


def _from_slopes(speeds: BreakSpeeds, covariance: FloatArray, number: int) -> Bounce:
    before, after = -float(speeds.before_m_s[number]), float(speeds.after_m_s[number])
    sign = np.array([-1.0, 1.0])
    own = covariance[number] * sign[:, None] * sign
    return _bounce(float(speeds.time_s[number]), before, after, own, "slopes")


def _free_fall(estimate: JointEstimate, fit: FlightFit) -> FreeFall:
    """Return the first fall against the parabola with the flights' g."""
    solution = estimate.chosen.solution
    first, last = estimate.onset_s + 0.010, float(fit.impact_s[0])
    time = np.linspace(first, last, 200)
    release = solution.problem.stage.release_m
    height = solution.at.spline.design(time) @ solution.state.coefficients[:, 2] + release[2]
    bend, slope, level = np.polyfit(time - first, height, 2)
    residual = height - np.polyval([bend, slope, level], time - first)
    return FreeFall(
        fit.g_m_s2,
        _COVERAGE * fit.u_g(),
        first,
        last,
        float(release[2]),
        float(release[2] - height[-1]),
        (float(level), float(slope), float(bend)),
        float(np.sqrt((residual**2).mean())),
    )
