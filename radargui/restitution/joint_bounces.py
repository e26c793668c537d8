"""Bounces of a joint estimate: e from the speeds of the flights at the instant of impact."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from radargui.estimation.joint import JointEstimate
from radargui.estimation.readout.motion_posterior import MotionPosterior
from radargui.model.arrays import BoolArray, FloatArray
from radargui.model.gravity import NOMINAL_GRAVITY_M_S2
from radargui.model.result import Bounce, Bounces, FreeFall
from radargui.model.setup import Setup
from radargui.restitution.cross_check import cross_check
from radargui.restitution.flight_fit import FlightFit, break_velocities
from radargui.restitution.flight_plan import fit_with_alternatives, mixed_in
from radargui.restitution.floor_normal import FloorNormal, normal_of_impacts
from radargui.restitution.settings import FLIGHTS


def joint_bounces(
    estimate: JointEstimate, setup: Setup, floor_covariance: FloatArray | None = None
) -> tuple[Bounces, FlightFit | None]:
    """Return the bounces, and the fit of the flights where there is one.

    Impacts between fitted flights take the flights' speeds; others the one-sided slopes of the motion. Standard
    uncertainties are those of the posterior and its alternatives, and that of the floor's normal where it is
    found from the impacts.

    Parameters
    ----------
    estimate
        From `estimate_joint`.
    setup
        Its floor's normal is the direction of the speeds; where it gives none, the one that the impacts and the floor
        that reflects support.
    floor_covariance
        What the setup's uncertainties leave to the slope of the floor that reflects, shape (2, 2); None: nothing.

    Raises
    ------
    SolveError
        The flights' equations have no solution.
    """
    posterior = estimate.posterior
    # level until the impacts say otherwise: which breaks are impacts depends on it by degrees only
    floor = FloorNormal(np.asarray(setup.floor.normal))
    fit = fit_with_alternatives(posterior, estimate.alternatives, floor.normal)
    given = "normal" in setup.floor.model_fields_set
    if not given:
        reflecting = _reflecting_floor(estimate, floor_covariance)
        at = _Impacts.of(posterior, fit, floor.normal)
        floor = normal_of_impacts(at.before_m_s, at.after_m_s, at.u_side_m_s, setup.floor.u_tilt_deg, reflecting)
        # then other breaks may be impacts, and the flights between them other ones
        if floor.tilt_deg > FLIGHTS.near_vertical_deg:
            fit = fit_with_alternatives(posterior, estimate.alternatives, floor.normal)
    at = _Impacts.of(posterior, fit, floor.normal)
    bounces = tuple(at.bounce(number, floor) for number in range(at.time_s.size))
    fall = None if fit is None else _free_fall(posterior, fit, floor.normal)
    x, y, z = (float(part) for part in floor.normal)
    found = Bounces(bounces, fall, (x, y, z), None if given or not bounces else floor.u_tilt_deg)
    return _checked(found, posterior, fit, floor.normal), fit


def _reflecting_floor(estimate: JointEstimate, setup_covariance: FloatArray | None) -> FloorNormal | None:
    """Return the normal of the floor that reflects, alternatives mixed in as for the flights; None without one."""
    found = estimate.posterior.floor_slope
    if found is None:
        return None
    others = ((one.weight, one.posterior.floor_slope) for one in estimate.alternatives)
    covariance = mixed_in(
        found.covariance,
        ((weight, own.slope - found.slope, own.covariance) for weight, own in others if own is not None),
    )
    if setup_covariance is not None:
        covariance = covariance + setup_covariance
    normal = np.array([*found.slope, 1.0])
    return FloorNormal(normal / np.linalg.norm(normal), float(np.trace(covariance) / 2.0))


@dataclass(frozen=True, slots=True)
class _Impacts:
    """What is known of the velocities at the impacts.

    Attributes
    ----------
    time_s
        Shape (n_impacts,).
    before_m_s, after_m_s
        Shape (n_impacts, 3).
    covariance
        Of (before x, y, z, after x, y, z), shape (n_impacts, 6, 6).
    by_flights
        Whether fitted flights say so, shape (n_impacts,); else the one-sided slopes of the motion.
    """

    time_s: FloatArray
    before_m_s: FloatArray
    after_m_s: FloatArray
    covariance: FloatArray
    by_flights: BoolArray

    @staticmethod
    def of(posterior: MotionPosterior, fit: FlightFit | None, normal: FloatArray) -> _Impacts:
        """Return the impacts along a normal."""
        breaks, n_fitted = posterior.breaks, 0
        time, covariance = breaks.time_s.copy(), breaks.covariance.copy()
        before, after = break_velocities(posterior, fit)
        if fit is not None:
            n_fitted = fit.impact_s.size
            time[:n_fitted], covariance[:n_fitted] = fit.impact_s, fit.velocity_covariances
        impacts = breaks.along(normal).are_impacts()
        by_flights = np.arange(time.size) < n_fitted
        return _Impacts(time[impacts], before[impacts], after[impacts], covariance[impacts], by_flights[impacts])

    @property
    def u_side_m_s(self) -> FloatArray:
        """Uncertainty of a horizontal component of the velocity's change at each impact, shape (n_impacts,)."""
        # after less before, x and y: their covariance with each other is a part of it
        change = np.concatenate([-np.eye(2, 3), np.eye(2, 3)], axis=1)
        variance = change @ self.covariance @ change.T
        return np.asarray(np.sqrt(np.maximum(np.trace(variance, axis1=1, axis2=2) / 2.0, 0.0)))

    def bounce(self, number: int, floor: FloorNormal) -> Bounce:
        """Return e = after / before along the normal, u_e with that of the normal."""
        before_m_s, after_m_s = self.before_m_s[number], self.after_m_s[number]
        before, after = -float(before_m_s @ floor.normal), float(after_m_s @ floor.normal)
        # signs so that both are positive: before points into the floor
        e = after / before
        slope = np.concatenate([e / before * floor.normal, floor.normal / before])
        # rounding of a covariance that the alternatives widened
        variance = max(float(slope @ self.covariance[number] @ slope), 0.0)
        u_e = float(np.sqrt(variance + floor.e_variance(before_m_s, after_m_s)))
        method = "flights" if self.by_flights[number] else "slopes"
        # a rebound faster than the arrival is no passive one; a wide u_e says nothing
        valid = bool(0.0 < e < FLIGHTS.most_e and u_e < FLIGHTS.usable_u_e)
        return Bounce(float(self.time_s[number]), before, after, e, u_e, method, valid)


def _checked(bounces: Bounces, posterior: MotionPosterior, fit: FlightFit | None, normal: FloatArray) -> Bounces:
    """Return the bounces with e from flight times and heights of the free motion, under the fitted g and drag."""
    free = posterior.free
    time = np.arange(posterior.onset_s, float(free.edge_s[-1]), FLIGHTS.check_step_s)
    # without fitted flights there is no drag to correct with: the check's tolerance holds it
    g, drag = (NOMINAL_GRAVITY_M_S2, 0.0) if fit is None else (fit.g_m_s2, fit.drag_1_m)
    return cross_check(bounces, time, normal @ free.position_m(time), g * float(normal[2]), drag)


def _free_fall(posterior: MotionPosterior, fit: FlightFit, normal: FloatArray) -> FreeFall:
    """Return the first fall against the parabola with the flights' g."""
    free = posterior.free
    first, last = posterior.onset_s + FLIGHTS.after_onset_s, fit.first_end_s
    time = np.linspace(first, last, 200)
    release = float(free.release_m @ normal)
    height = normal @ free.position_m(time)
    # what is drawn is a parabola; g is that of all flights, with drag
    bend, slope, level = np.polyfit(time - first, height, 2)
    residual = height - np.polyval([bend, slope, level], time - first)
    return FreeFall(
        fit.g_m_s2,
        fit.u_g_m_s2,
        first,
        last,
        release,
        float(release - height[-1]) if fit.impact_s.size else float("nan"),
        (float(level), float(slope), float(bend)),
        float(np.sqrt((residual**2).mean())),
    )
