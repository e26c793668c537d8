"""Speeds at the impacts of a track along the floor's normal, their ratio e, and its uncertainty, drag included.

Method 5, Flights.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from radargui.model.arrays import BoolArray, FloatArray, IntArray
from radargui.model.gravity import Drag
from radargui.model.result import Bounce, FreeFall
from radargui.motion.free_flight import fall_below_apex, speed_below_apex
from radargui.restitution.parabola import (
    FittedParabolas,
    Parabolas,
    fit_parabolas,
    residual_variances,
    residuals,
    solve_parabolas,
)
from radargui.restitution.settings import TRACKS
from radargui.restitution.stretches import Stretches
from radargui.restitution.track_flights import FittedFlights


@dataclass(frozen=True, slots=True)
class ImpactSpeeds:
    """All impacts in time order; fields as of `Bounce`, shapes (n_impacts,), NaN where too little is known."""

    time_s: FloatArray
    before_m_s: FloatArray
    after_m_s: FloatArray
    e: FloatArray
    u_e: FloatArray
    valid: BoolArray

    def widened(self, u_e: FloatArray, among: BoolArray) -> ImpactSpeeds:
        """Return them with another, independent part of u_e; only some may be valid; both shapes (n_impacts,)."""
        u_e = np.hypot(self.u_e, u_e)
        return replace(self, u_e=u_e, valid=_is_valid(self.e, u_e) & among)

    def bounces(self, method: str) -> tuple[Bounce, ...]:
        """Return them one by one."""
        columns = (self.time_s, self.before_m_s, self.after_m_s, self.e, self.u_e)
        rows = zip(np.stack(columns, axis=1).tolist(), self.valid.tolist(), strict=True)
        return tuple(Bounce(at, before, after, e, u, method, valid) for (at, before, after, e, u), valid in rows)


def _is_valid(e: FloatArray, u_e: FloatArray) -> BoolArray:
    # no passive impact gives more than it takes: e above 1 beyond its u is a wrong track
    return np.asarray((u_e < TRACKS.largest_u_e) & (e < 1.0 + TRACKS.sigmas_above_1 * u_e))


def speeds_at_impacts(flights: FittedFlights, impact_s: FloatArray) -> ImpactSpeeds:
    """Return the speeds at which the fitted flights meet at instants (n_impacts,); u_e is that of the fit alone."""
    fitted = fit_parabolas(flights.samples, flights.height_m)
    arriving, leaving, e, u_e = np.full((4, impact_s.size), np.nan)
    # flight k ends with impact k, and begins with the one before
    number, place = (np.array(list(own), dtype=np.intp) for own in (flights.place, flights.place.values()))
    ends, begins = number < impact_s.size, number > 0
    arriving[number[ends]] = -fitted.parabolas.speed_at(place[ends], impact_s[number[ends]])
    leaving[number[begins] - 1] = fitted.parabolas.speed_at(place[begins], impact_s[number[begins] - 1])
    known, one, other = flights.sides(impact_s.size)
    # speeds along the normal have no sign left to lose: anything else is no rebound
    rebounds = (arriving[known] > 0.0) & (leaving[known] > 0.0)
    known, one, other = known[rebounds], one[rebounds], other[rebounds]
    e[known] = leaving[known] / arriving[known]
    u_e[known] = _u_e(fitted, np.stack([one, other]), impact_s[known], arriving[known], leaving[known])
    return ImpactSpeeds(impact_s, arriving, leaving, e, u_e, _is_valid(e, u_e))


def _u_e(
    fitted: FittedParabolas, sides: IntArray, instant_s: FloatArray, before_m_s: FloatArray, after_m_s: FloatArray
) -> FloatArray:
    """Return u of e = after / before, by the covariance of neighbours, which share g (GUM 5.2.2).

    Parameters
    ----------
    fitted
        Parabolas.
    sides
        Places of those before and after each impact, shape (2, n_impacts).
    instant_s, before_m_s, after_m_s
        Of each impact, shape (n_impacts,).
    """
    one, other = sides
    zero, unit = np.zeros(one.size), np.ones(one.size)
    d_one, d_other = (instant_s - fitted.parabolas.origin_s[flight] for flight in (one, other))
    # d / d (height and speed of the one, of the other, g)
    height_one = np.stack([unit, d_one, zero, zero, -0.5 * d_one**2])
    height_other = np.stack([zero, zero, unit, d_other, -0.5 * d_other**2])
    speed_one, speed_other = np.stack([zero, unit, zero, zero, -d_one]), np.stack([zero, zero, zero, unit, -d_other])
    arriving, leaving = (height_one, speed_one), (height_other, speed_other)
    slope = changes_of_e(arriving, leaving, before_m_s, after_m_s, fitted.g_m_s2)
    places = np.stack([2 * one, 2 * one + 1, 2 * other, 2 * other + 1, np.full(one.size, -1)])
    covariance = fitted.covariance[places[:, None], places]
    return np.asarray(np.sqrt(np.einsum("ak,abk,bk->k", slope, covariance, slope)))


def changes_of_e(
    arriving: tuple[FloatArray, FloatArray],
    leaving: tuple[FloatArray, FloatArray],
    before_m_s: FloatArray,
    after_m_s: FloatArray,
    g_m_s2: float,
) -> FloatArray:
    """Return what small changes of the flights on both sides make of e = after / before, (..., n_impacts).

    Parameters
    ----------
    arriving, leaving
        Changes of height and upward speed of the flights before and after each impact, at its instant, shapes
        (..., n_impacts).
    before_m_s, after_m_s
        Speeds at the impacts, both positive, shape (n_impacts,).
    g_m_s2
        Along the normal.
    """
    (height_in, speed_in), (height_out, speed_out) = arriving, leaving
    # they meet elsewhere, by the implicit function theorem, and both speeds change by g until then
    gained = g_m_s2 * (height_in - height_out) / (before_m_s + after_m_s)
    return np.asarray((speed_out - gained - after_m_s / before_m_s * (gained - speed_in)) / before_m_s)


def _bend(after_apex_s: FloatArray, g_m_s2: float, drag: Drag) -> FloatArray:
    """Return by how much a flight with drag is above the parabola of the same apex and g."""
    return fall_below_apex(after_apex_s, g_m_s2, 0.0) - fall_below_apex(after_apex_s, g_m_s2, drag.k_1_m, drag.slow_m_s)


def drag_of_flights(flights: FittedFlights, slow_m_s: float, least_1_m: float = -math.inf) -> tuple[float, float]:
    """Return k of the sphere by how its flights bend, and its standard uncertainty, 1/m.

    What a parabola leaves of a flight with drag is as good as linear in k: least squares of the heights' residuals,
    which count as those of the parabolas do (`fit_parabolas`). Below the least that matters u is not worked out.
    """
    own, samples = flights.parabolas, flights.samples
    small_1_m = 1e-3
    bend = _bends(own, Drag(small_1_m, 0.0, slow_m_s), samples)
    shape = residuals(samples, bend, solve_parabolas(samples, bend)) / small_1_m
    left = residuals(samples, flights.height_m, own)
    squares = samples.sums(shape**2)
    drag_1_m = float(shape @ left / squares.sum())
    if drag_1_m < least_1_m:
        return drag_1_m, math.inf
    variance = residual_variances(samples, left - drag_1_m * shape)
    return drag_1_m, float(np.sqrt((variance * squares).sum()) / squares.sum())


def _bends(parabolas: Parabolas, drag: Drag, samples: Stretches) -> FloatArray:
    """Return the bends of flights at their samples; what parabolas make of them is the error that drag leaves."""
    # about its apex: v0 / g after the middle of the flight
    after_apex = samples.away_s - samples.spread(parabolas.speed_m_s / parabolas.g_m_s2)
    return _bend(after_apex, float(parabolas.g_m_s2), drag)


def error_of_e(impacts: ImpactSpeeds, flights: FittedFlights, drag: Drag) -> FloatArray:
    """Return by how much drag makes e of parabolas too small, to first order in k, (n_impacts,); 0 where it has none.

    Drag bends a flight by g^2 k D^4 / 12, which a parabola takes for another speed and another g: with k = 0.005 1/m
    (10 mm of steel) e of a 25 cm drop came out 0.1 % too small, and its u 0.006 %. It is not taken off: only the joint
    estimate finds k in the flights themselves.

    Parameters
    ----------
    impacts, flights
        Of parabolas with one g.
    drag
        Of the sphere.
    """
    own, g = flights.parabolas, float(flights.parabolas.g_m_s2)
    # a fit is linear in heights: what it makes of the bends is its error
    fitted = solve_parabolas(flights.samples, _bends(own, drag, flights.samples))
    sides = np.stack(flights.sides(impacts.e.size))
    known, before, after = sides[:, np.isfinite(impacts.e[sides[0]])]
    instant, arriving, leaving = (values[known] for values in (impacts.time_s, impacts.before_m_s, impacts.after_m_s))

    def missed(place: IntArray) -> tuple[FloatArray, FloatArray]:
        """Return true less fitted height and upward speed of flights at the instants."""
        d = np.asarray(instant - own.origin_s[place] - own.speed_m_s[place] / g)
        faster = speed_below_apex(d, g, drag.k_1_m, drag.slow_m_s) - speed_below_apex(d, g, 0.0)
        # of the flight with drag: what its own parabola has not followed
        return _bend(d, g, drag) - fitted.height_at(place, instant), faster - fitted.speed_at(place, instant)

    out = np.zeros(impacts.e.size)
    out[known] = changes_of_e(missed(before), missed(after), arriving, leaving, g)
    return out


def with_drag(fall: FreeFall, flights: FittedFlights, drag: Drag, normal: tuple[float, float, float]) -> FreeFall:
    """Return the first fall with what drag does in the uncertainty of its g; parameters as above."""
    first = np.arange(flights.samples.size) == flights.place[0]
    samples = flights.samples.chosen(first)
    g = solve_parabolas(samples, _bends(flights.parabolas.chosen(first), drag, samples)).g_m_s2
    return replace(fall, u_g_m_s2=math.hypot(fall.u_g_m_s2, float(g) / max(abs(normal[2]), 1e-9)))
