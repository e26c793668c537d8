"""Bounces of a joint estimate: which parts of it are flights, and e from their speeds at the instant of impact.

Method 5, Flights.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from radargui.estimation.joint import JointEstimate
from radargui.estimation.posterior.free_motion import FreeMotion
from radargui.estimation.posterior.motion_posterior import AlternativeMotion, MotionPosterior
from radargui.estimation.posterior.unfollowed import lands_after_s, unfollowed_m_s
from radargui.model.arrays import BoolArray, FloatArray, runs_of
from radargui.model.result import Bounce, Bounces, FreeFall, VelocitiesAtImpacts
from radargui.model.setup import Setup
from radargui.restitution.cross_check import TimesOfFlights, cross_check, with_e_by_times, without_checks_by_walls
from radargui.restitution.flight_fit import FlightFit, break_velocities, fit_flights
from radargui.restitution.flight_unknowns import FlightPlan, impact_rows
from radargui.restitution.floor_normal import FloorNormal, normal_of_impacts
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


def fit_with_alternatives(
    posterior: MotionPosterior, alternatives: Sequence[AlternativeMotion], normal: FloatArray
) -> FlightFit | None:
    """Fit the free flights; alternatives widen the covariance of what they have in common with it.

    V = c^2 sum w (V_k + d_k d_k^T) / sum w, d_k the difference of alternative k from the best; the heaviest three are
    fitted. c = 1.2 stands for what the maps cannot follow (`FlightSettings.widened`).

    Parameters
    ----------
    posterior, alternatives
        The best motion and others that the evidence does not rule out.
    normal
        Floor's normal, shape (3,).

    Returns
    -------
    FlightFit or None
        None without free flight.

    Raises
    ------
    SolveError
        The flights' equations have no solution.
    """
    fit = fit_free_flights(posterior, normal)
    if fit is None:
        return None
    others = []
    for alternative in sorted(alternatives, key=lambda one: -one.weight)[: FLIGHTS.max_alternatives]:
        other = fit_free_flights(alternative.posterior, normal, fit)
        if other is not None:
            others.append((alternative.weight, *_shared(fit, other)))
    return replace(fit, covariance=mixed_in(fit.covariance, others))


def _shared(fit: FlightFit, other: FlightFit) -> tuple[FloatArray, FloatArray]:
    """Return how far an alternative's values are from those of a fit, and their covariance.

    How many flights are good differs between alternatives: those of more or fewer impacts say something about gravity,
    drag and the impacts that both have (left out, u of g was 0.0006 where g was off by 0.0116 m/s^2). Of the
    others they say what the fit says.
    """
    both = min(fit.values.size, other.values.size)
    away, covariance = np.zeros_like(fit.values), fit.covariance.copy()
    away[:both] = other.values[:both] - fit.values[:both]
    covariance[:both] = covariance[:, :both] = 0.0
    covariance[:both, :both] = other.covariance[:both, :both]
    return away, covariance


def mixed_in(covariance: FloatArray, others: Iterable[tuple[float, FloatArray, FloatArray]]) -> FloatArray:
    """Return a covariance (n, n) with alternatives mixed in, of each its weight, how far off it is, and its covariance.

    The law of total variance, and a factor for what no alternative says.
    """
    total, mixed = 1.0, covariance.copy()
    for weight, away, own in others:
        mixed += weight * (own + np.outer(away, away))
        total += weight
    return np.asarray(FLIGHTS.widened**2 * mixed / total)


def fit_free_flights(posterior: MotionPosterior, normal: FloatArray, like: FlightFit | None = None) -> FlightFit | None:
    """Fit the longest run of flights from the release on that obeys the equation of free flight.

    Where no two neighbours do, the first fall alone, up to where it ends or something stops it. A misfit that stays
    widens the covariance. The first 10 ms after the onset are left out, and where that fits none, all until a hand that
    throws it has let go. Of an alternative to a fit, `like`, no more flights than that has.
    Other parameters, result and errors as for `fit_with_alternatives`.
    """
    free = posterior.free
    speeds = posterior.breaks.along(normal)
    # flights end where a break is no impact on floor or wall: there a hand acted
    n_flights = 1 + int(np.argmin(np.append(speeds.are_impacts() | speeds.are_kicks(), False)))
    # the record may end within a flight, or the sphere lie: then the last segment is no free flight
    if n_flights == len(free.segments) and _off_gravity(free, n_flights - 1) > FLIGHTS.near_g:
        n_flights -= 1
    first = _released(posterior)
    if first >= free.segments[0].n_spans or _never_falls(free, first):
        return None
    count = _likely(free, min(n_flights, _affordable(free)))
    if like is not None:
        count = min(count, like.apex_s.size)
    counts = range(count, 1, -1)
    best = _fit_run(posterior, counts, first)
    # a fall alone that begins later may be any motion that bends like one for a while
    if count > 1 and (best is None or not best.is_good) and (let_go := _let_go(free, first)) is not None:
        later = _fit_run(posterior, counts, let_go)
        best = best if later is None else _better(best, later)
    if best is None:
        best = _fit_first_fall(posterior, first)
    return best if best is None or best.is_good else best.widened()


def _released(posterior: MotionPosterior) -> int:
    # no release is a clean cut: magnet or fingers pull for some milliseconds
    return posterior.free.first_coefficient_from(posterior.onset_s + FLIGHTS.after_onset_s)


def _fit_run(posterior: MotionPosterior, counts: Sequence[int], first: int) -> FlightFit | None:
    """Fit the first run of so many flights that is good, beginning with a span; else that of least misfit."""
    best: FlightFit | None = None
    # from the most on: more flights share g, and the first run that is good is the best one
    for count in counts:
        fit = _fitted(posterior, FlightPlan(count, first))
        best = _better(best, fit)
        if fit.is_good:
            break
    return best


def _fitted(posterior: MotionPosterior, plan: FlightPlan) -> FlightFit:
    return fit_flights(plan.information(posterior), plan)


def _better(best: FlightFit | None, fit: FlightFit) -> FlightFit | None:
    """Return the one of less misfit; one that the samples do not determine never."""
    if not fit.is_determined:
        return best
    return fit if best is None or fit.reduced_misfit < best.reduced_misfit else best


def _fit_first_fall(posterior: MotionPosterior, first: int) -> FlightFit | None:
    """Fit the first fall alone; None where the motion does not fall like a free body for 50 ms.

    A sphere that meets grains has no break in its velocity, and a spline with 10 ms knots feels the contact before it
    comes: the end goes back until the misfit is good, and 10 ms further.
    """
    knot = posterior.free.segments[0].knot_s
    falls = _falls(posterior.free, first)
    count = int(np.argmin(np.append(falls, False)))
    ends = [last for last in range(first + count, first, -1) if knot[last] - knot[first] > FLIGHTS.shortest_fall_s]
    best: FlightFit | None = None
    for last in ends:
        fit = _fitted(posterior, FlightPlan(1, first, last))
        best = _better(best, fit)
        if fit.is_good:
            # the spline has spread the contact over a knot: what is just before it is pulled already
            before = [other for other in ends if knot[other] <= knot[last] - FLIGHTS.before_contact_s]
            return _better(None, _fitted(posterior, FlightPlan(1, first, before[0]))) if before else fit
    return best


def _falls(free: FreeMotion, first: int) -> BoolArray:
    """Return which spans of the first segment, from one of them on, fall like a free body, shape (n_spans - first,)."""
    knot = free.segments[0].knot_s
    step = np.diff(knot)[first:] / 4.0
    middle = (knot[first:-1] + knot[first + 1 :]) / 2.0
    height = free.position_m((middle + np.array([-1.0, 0.0, 1.0])[:, None] * step).ravel())[2].reshape(3, -1)
    # second difference of the spline in each of its spans: its acceleration
    bend = (height[0] - 2.0 * height[1] + height[2]) / step**2
    return np.asarray(np.abs(bend / free.gravity_m_s2 + 1.0) < FLIGHTS.about_g)


def _never_falls(free: FreeMotion, first: int) -> bool:
    """Whether nothing of a first segment of 50 ms or more falls: what rolls down a rail turns round at a stop, too."""
    lasts_s = free.segments[0].end_s - free.segments[0].knot_s[first]
    return bool(lasts_s > FLIGHTS.shortest_fall_s and not _falls(free, first).any())


def _let_go(free: FreeMotion, first: int) -> int | None:
    """Return the span of the first segment from which on it falls, after a hand that throws; None where none does."""
    runs = runs_of(_falls(free, first))
    if runs.size == 0 or runs[0, 0] == 0:
        return None
    begin, end = max(runs, key=lambda run: run[1] - run[0])
    # the spline spreads the hand's push over a knot
    begin, knot = first + int(begin) + 1, free.segments[0].knot_s
    return begin if knot[first + end] - knot[begin] > FLIGHTS.shortest_fall_s else None


def _affordable(free: FreeMotion) -> int:
    """Return how many flights a dense fit can take."""
    sizes = [segment.stop_coefficient - 1 for segment in free.segments]
    return max(1, int(np.searchsorted(sizes, FLIGHTS.max_coefficients, side="right")))


def _likely(free: FreeMotion, n_flights: int) -> int:
    """Return how many flights come before one that does not fall at all: the sphere lay, or was carried back."""
    for number in range(2, n_flights):
        # of a shorter one the spline's bend is not known well enough to say that it does not fall
        is_long = free.segments[number].duration_s > FLIGHTS.shortest_fall_s
        if is_long and _off_gravity(free, number) > FLIGHTS.about_g:
            return number
    return n_flights


def _off_gravity(free: FreeMotion, number: int) -> float:
    """Return by which share of g a segment's acceleration differs from gravity."""
    segment = free.segments[number]
    # the ends hold what is left of impacts
    margin = 0.1 * segment.duration_s
    time = np.linspace(segment.begin_s + margin, segment.end_s - margin, 15)
    height = free.position_m(time)[2]
    return float(abs(2.0 * np.polyfit(time - time[0], height, 2)[0] / free.gravity_m_s2 + 1.0))


def joint_bounces(
    estimate: JointEstimate, setup: Setup, responses: SetupResponses | None = None
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
    responses
        How the estimate follows the setup's uncertainties; None: it has none.

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
        reflecting = _reflecting_floor(estimate, None if responses is None else responses.floor_covariance())
        at = JointImpacts.of(posterior, fit, floor.normal, responses)
        # what a wall has done says nothing of the floor
        alone = ~at.with_wall
        floor = normal_of_impacts(
            at.velocities.before_m_s[alone],
            at.velocities.after_m_s[alone],
            at.u_side_m_s[alone],
            setup.floor.u_tilt_deg,
            reflecting,
        )
        # then other breaks may be impacts, and the flights between them other ones
        if floor.tilt_deg > FLIGHTS.near_vertical_deg:
            fit = fit_with_alternatives(posterior, estimate.alternatives, floor.normal)
    at = JointImpacts.of(posterior, fit, floor.normal, responses)
    bounces = tuple(at.bounce(number, floor) for number in range(at.with_wall.size))
    fall = None if fit is None else _free_fall(posterior, fit, floor.normal, bounces)
    x, y, z = (float(part) for part in floor.normal)
    u_tilt_deg = None if given or not bounces else floor.u_tilt_deg
    shared_s = tuple(at.velocities.time_s[at.with_wall].tolist())
    velocities = replace(at.velocities, slope_variance=floor.slope_variance)
    found = Bounces(
        bounces, fall, (x, y, z), u_tilt_deg, walls_s=at.walls_s, with_walls_s=shared_s, velocities=velocities
    )
    return _checked(found, posterior, fit, floor.normal), fit


def _reflecting_floor(estimate: JointEstimate, setup_covariance: FloatArray | None) -> FloorNormal | None:
    """Return the normal of the floor that reflects, alternatives mixed in as for the flights; None without one."""
    found = estimate.posterior.floor_slope
    if found is None:
        return None
    others = ((one.weight, one.posterior.floor_slope) for one in estimate.alternatives)
    apart = ((weight, own.slope - found.slope, own.covariance) for weight, own in others if own is not None)
    covariance = mixed_in(found.covariance, apart)
    if setup_covariance is not None:
        covariance = covariance + setup_covariance
    normal = np.array([*found.slope, 1.0])
    return FloorNormal(normal / np.linalg.norm(normal), float(np.trace(covariance) / 2.0))


def _checked(bounces: Bounces, posterior: MotionPosterior, fit: FlightFit | None, normal: FloatArray) -> Bounces:
    """Return the bounces with e from flight times and heights of the free motion, under the fitted g and drag."""
    free = posterior.free
    # what never falls comes back later, and lower, than gravity makes it
    if fit is None and _never_falls(free, min(_released(posterior), free.segments[0].n_spans)):
        return bounces
    time = np.arange(posterior.onset_s, float(free.edge_s[-1]), FLIGHTS.check_step_s)
    # without fitted flights there is no drag to correct with: the check's tolerance holds it
    g, drag = (free.gravity_m_s2, 0.0) if fit is None else (fit.g_m_s2, fit.drag_1_m)
    height, along = normal @ free.position_m(time), g * float(normal[2])
    checked = cross_check(bounces, time, height, along, drag, free.drag.slow_m_s)
    if fit is not None and fit.impact_s.size:
        checked = with_e_by_times(checked, _times(fit, float(normal[2]), free.drag.slow_m_s))
    return without_checks_by_walls(checked)


def _times(fit: FlightFit, upright: float, slow_m_s: float) -> TimesOfFlights:
    """Return the times of flights; the first counts from its apex, the start of a fall from rest."""
    g, k = fit.g_m_s2, fit.drag_1_m
    speed = -float(fit.before_m_s[0, 2])
    # of a fall from rest, to first order in k
    fall_s = speed / g * (1.0 + k * speed**2 / (3.0 * g) + 0.5 * k * slow_m_s * speed / g)
    times = np.append(fit.impact_s[0] - fall_s, fit.impact_s)
    by_values = np.zeros((times.size, fit.values.size))
    at = impact_rows(np.arange(float(fit.values.size))).astype(np.intp)
    by_values[np.arange(1, times.size), at[:, 0]] = 1.0
    by_values[0, [at[0, 0], at[0, 3]]] = 1.0, 1.0 / g
    return TimesOfFlights(times, by_values @ fit.covariance @ by_values.T, g * upright, k, slow_m_s)


def _free_fall(posterior: MotionPosterior, fit: FlightFit, normal: FloatArray, bounces: tuple[Bounce, ...]) -> FreeFall:
    """Return the first fall against the parabola with the flights' g."""
    free = posterior.free
    first, last = fit.first_begin_s, fit.first_end_s
    time = np.linspace(first, last, 200)
    release = float(free.release_m @ normal)
    height = normal @ free.position_m(time)
    # what is drawn is a parabola; g is that of all flights, with drag
    bend, slope, level = np.polyfit(time - first, height, 2).tolist()
    residual_rms = float(np.sqrt(((height - np.polyval([bend, slope, level], time - first)) ** 2).mean()))
    drop_height = float("nan")
    if bounces and fit.impact_s.size:
        # not where the first flight ends: a wall beside the fall may have been met before the floor
        drop_height = release - float(normal @ free.position_m(np.array([bounces[0].time_s]))[:, 0])
    parabola = (level, slope, bend)
    return FreeFall(fit.g_m_s2, fit.u_g_m_s2, first, last, release, drop_height, parabola, residual_rms)
