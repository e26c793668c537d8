"""Which parts of a motion are free flights, their common fit, and what alternative motions add to its uncertainty."""

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from radargui.estimation.readout.free_motion import FreeMotion
from radargui.estimation.readout.motion_posterior import AlternativeMotion, MotionPosterior
from radargui.model.arrays import FloatArray
from radargui.model.gravity import NOMINAL_GRAVITY_M_S2
from radargui.restitution.flight_fit import FlightFit, fit_flights
from radargui.restitution.flight_unknowns import FlightPlan
from radargui.restitution.settings import FLIGHTS


def fit_with_alternatives(
    posterior: MotionPosterior, alternatives: Sequence[AlternativeMotion], normal: FloatArray
) -> FlightFit | None:
    """Fit the free flights; alternatives with the same impacts widen the covariance.

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
    for alternative in sorted(alternatives, key=lambda one: -one.weight)[: FLIGHTS.most_alternatives]:
        other = fit_free_flights(alternative.posterior, normal)
        # with other impacts the values mean something else, and no mean of them is a result
        if other is not None and other.impact_s.size == fit.impact_s.size:
            others.append((alternative.weight, other.values - fit.values, other.covariance))
    return replace(fit, covariance=mixed_in(fit.covariance, others))


def mixed_in(covariance: FloatArray, others: Iterable[tuple[float, FloatArray, FloatArray]]) -> FloatArray:
    """Return a covariance (n, n) with alternatives mixed in, of each its weight, how far off it is, and its covariance.

    The law of total variance, and a factor for what no alternative says.
    """
    total, mixed = 1.0, covariance.copy()
    for weight, away, own in others:
        mixed += weight * (own + np.outer(away, away))
        total += weight
    return np.asarray(FLIGHTS.widened**2 * mixed / total)


def fit_free_flights(posterior: MotionPosterior, normal: FloatArray) -> FlightFit | None:
    """Fit the longest run of flights from the release on that obeys the equation of free flight.

    Where no two neighbours do, the first fall alone, up to where it ends or something stops it. A misfit that stays
    widens the covariance. The first 10 ms after the onset are left out. Parameters, result and errors as for
    `fit_with_alternatives`.
    """
    free = posterior.free
    impacts = posterior.breaks.along(normal).are_impacts()
    # flights end where a break is no impact: there a hand or a wall acted
    n_flights = 1 + int(np.argmin(np.append(impacts, False)))
    # the record may end within a flight, or the sphere lie: then the last segment is no free flight
    if n_flights == len(free.segments) and _off_gravity(free, n_flights - 1) > FLIGHTS.near_g_m_s2:
        n_flights -= 1
    # no release is a clean cut: magnet or fingers pull for some milliseconds
    first = free.first_coefficient_from(posterior.onset_s + FLIGHTS.after_onset_s)
    if first >= free.segments[0].n_spans:
        return None
    best: FlightFit | None = None
    # from the most on: more flights share g, and the first run that is good is the best one
    for count in range(_likely(free, min(n_flights, _affordable(free))), 1, -1):
        fit = _fitted(posterior, FlightPlan(count, first))
        best = _better(best, fit)
        if fit.is_good:
            break
    if best is None:
        best = _fit_first_fall(posterior, first)
    return best if best is None or best.is_good else best.widened()


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
    step = np.diff(knot)[first:] / 4.0
    middle = (knot[first:-1] + knot[first + 1 :]) / 2.0
    height = posterior.free.position_m((middle + np.array([-1.0, 0.0, 1.0])[:, None] * step).ravel())[2].reshape(3, -1)
    # second difference of the spline in each of its spans: its acceleration
    bend = (height[0] - 2.0 * height[1] + height[2]) / step**2
    falls = np.abs(bend + NOMINAL_GRAVITY_M_S2) < FLIGHTS.about_g_m_s2
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


def _affordable(free: FreeMotion) -> int:
    """Return how many flights a dense fit can take."""
    sizes = [segment.stop_coefficient - 1 for segment in free.segments]
    return max(1, int(np.searchsorted(sizes, FLIGHTS.most_coefficients, side="right")))


def _likely(free: FreeMotion, n_flights: int) -> int:
    """Return how many flights come before one that does not fall at all: the sphere lay, or was carried back."""
    for number in range(2, n_flights):
        is_long = free.segments[number].duration_s > FLIGHTS.shortest_fall_s
        if is_long and _off_gravity(free, number) > FLIGHTS.about_g_m_s2:
            return number
    return n_flights


def _off_gravity(free: FreeMotion, number: int) -> float:
    """Return by how much a segment's acceleration differs from that of gravity, m/s^2."""
    segment = free.segments[number]
    # the ends hold what is left of impacts
    margin = 0.1 * segment.duration_s
    time = np.linspace(segment.begin_s + margin, segment.end_s - margin, 15)
    height = free.position_m(time)[2]
    return float(abs(2.0 * np.polyfit(time - time[0], height, 2)[0] + NOMINAL_GRAVITY_M_S2))
