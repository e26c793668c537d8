"""Speeds at the impacts of a joint estimate: from its flights, else from the slopes of its motion.

Method 5, e and the floor's normal.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from radargui.estimation.posterior.motion_posterior import MotionPosterior
from radargui.estimation.posterior.unfollowed import lands_after_s, unfollowed_m_s
from radargui.model.arrays import BoolArray, FloatArray
from radargui.model.result import Bounce, VelocitiesAtImpacts
from radargui.restitution.flight_fit import FlightFit, break_velocities
from radargui.restitution.floor_normal import FloorNormal
from radargui.restitution.input_changes import SetupResponses
from radargui.restitution.settings import FLIGHTS
from radargui.restitution.wall_at_impact import walls_at_impacts


@dataclass(frozen=True, slots=True)
class JointImpacts:
    """What is known of the velocities at the impacts.

    Attributes
    ----------
    velocities
        When, which, and how well they are known.
    by_flights
        Whether fitted flights say so, shape (n_impacts,); else the one-sided slopes of the motion.
    with_wall
        Whether a wall was met at the impact, too, or so near that neither is known by itself, shape (n_impacts,).
    walls_s
        Instants at which a wall threw the body back along the floor, from one flight into the next.
    """

    velocities: VelocitiesAtImpacts
    by_flights: BoolArray
    with_wall: BoolArray
    walls_s: tuple[float, ...]

    @staticmethod
    def of(
        posterior: MotionPosterior, fit: FlightFit | None, normal: FloatArray, responses: SetupResponses | None
    ) -> JointImpacts:
        """Return the impacts along a normal."""
        inputs = None if fit is None or responses is None else responses.beside(fit)
        breaks, n_fitted = posterior.breaks, 0
        time, covariance = breaks.time_s.copy(), breaks.covariance.copy()
        before, after = break_velocities(posterior, fit)
        if fit is not None:
            n_fitted = fit.impact_s.size
            time[:n_fitted], covariance[:n_fitted] = fit.impact_s, fit.velocity_covariances
        speeds = breaks.along(normal)
        impacts = speeds.are_impacts()
        by_flights = np.arange(time.size) < n_fitted
        walls = tuple(time[speeds.are_kicks() & ~impacts & by_flights].tolist())
        with_wall = walls_at_impacts(posterior, fit, normal, inputs)[impacts]
        time, before, after, by_flights = time[impacts], before[impacts], after[impacts], by_flights[impacts]
        g = (posterior.free.gravity_m_s2 if fit is None else fit.g_m_s2) * float(normal[2])
        end_s = float(posterior.free.edge_s[-1])
        into, out_of = -before @ normal, after @ normal
        lands_s = lands_after_s(posterior.free, normal, float(time[-1]), float(out_of[-1])) if time.size else math.nan
        left_open = unfollowed_m_s(time, into, out_of, by_flights, g, end_s, lands_s)
        covariance, along = covariance[impacts], np.outer(normal, normal)
        for side, u_m_s in zip((slice(0, 3), slice(3, 6)), left_open, strict=True):
            covariance[:, side, side] += u_m_s[:, None, None] ** 2 * along
        velocities = VelocitiesAtImpacts(time, before, after, covariance)
        return JointImpacts(velocities, by_flights, with_wall, walls)

    @property
    def u_side_m_s(self) -> FloatArray:
        """Uncertainty of a horizontal component of the velocity's change at each impact, shape (n_impacts,)."""
        # after less before, x and y: their covariance with each other is a part of it
        change = np.concatenate([-np.eye(2, 3), np.eye(2, 3)], axis=1)
        variance = change @ self.velocities.covariance @ change.T
        return np.asarray(np.sqrt(np.maximum(np.trace(variance, axis1=1, axis2=2) / 2.0, 0.0)))

    def bounce(self, number: int, floor: FloorNormal) -> Bounce:
        """Return e = after / before along the normal, u_e with that of the normal."""
        known = self.velocities
        before_m_s, after_m_s = known.before_m_s[number], known.after_m_s[number]
        before, after = -float(before_m_s @ floor.normal), float(after_m_s @ floor.normal)
        # signs so that both are positive: before points into the floor
        e = after / before
        slope = np.concatenate([e / before * floor.normal, floor.normal / before])
        # rounding of a covariance that the alternatives widened
        variance = max(float(slope @ known.covariance[number] @ slope), 0.0)
        u_e = float(np.sqrt(variance + floor.e_variance(before_m_s, after_m_s)))
        method = "flights" if self.by_flights[number] else "slopes"
        # a rebound faster than the arrival is no passive one; a wide u_e says nothing
        valid = bool(0.0 < e < FLIGHTS.most_e and u_e < FLIGHTS.usable_u_e and not self.with_wall[number])
        return Bounce(float(known.time_s[number]), before, after, e, u_e, method, valid)
