"""Bounces of a track: coefficient of restitution of each, and the free fall before the first."""

from dataclasses import dataclass, replace

import numpy as np

from radargui.model.arrays import FloatArray, IntArray
from radargui.model.gravity import NOMINAL_GRAVITY_M_S2
from radargui.model.result import Bounce, Bounces, FreeFall, Segment, Track
from radargui.motion.impacts import find_track_impacts
from radargui.restitution.cross_check import cross_check
from radargui.restitution.floor_normal import UP, FloorNormal, normal_of_impacts
from radargui.restitution.parabola import FittedParabolas, fit_parabolas
from radargui.restitution.settings import TRACKS
from radargui.restitution.track_drag import with_drag
from radargui.restitution.track_flights import (
    FittedFlights,
    Heights,
    ImpactVelocities,
    find_flights,
    fit_track_flights,
    impact_velocities,
)

METHOD = "parabolas with shared g"


def find_bounces(
    track: Track,
    segment: Segment,
    normal: tuple[float, float, float] | None,
    sample_rate_hz: float,
    u_tilt_deg: float | None = None,
    drag_1_m: float = 0.0,
) -> Bounces:
    """Return impacts with e = speed after / speed before along the floor's normal, and the first fall.

    The flights before and after an impact are parabolas with one g; the instant of impact is where neighbours meet,
    and the speeds are their slopes there.

    Parameters
    ----------
    track
        Position of the sphere's centre.
    segment
        The motion within the track.
    normal
        Unit vector away from the floor; None: found from the impacts, its uncertainty a part of u_e.
    sample_rate_hz
        Rate of the samples.
    u_tilt_deg
        Standard deviation of the floor's slope from level, where the setup gives it and no normal.
    drag_1_m
        k of the sphere in air, part of the uncertainties.
    """
    # first along the vertical: the impacts themselves say how the floor leans, and where they are does not need it
    found = _along(track, segment, UP if normal is None else normal, sample_rate_hz, drag_1_m, final=normal is not None)
    if normal is None and found.bounces.impacts:
        at = _velocities(track, segment, found.bounces)
        # an impact that gives no e may be no impact: it has no say about the floor
        known = np.isfinite(at.u_side_m_s) & np.array([impact.valid for impact in found.bounces.impacts])
        floor = normal_of_impacts(at.before_m_s[known], at.after_m_s[known], at.u_side_m_s[known], u_tilt_deg)
        x, y, z = (float(part) for part in floor.normal)
        # again: heights, speeds and what counts as a flight are along the normal found
        impact_s = np.array([impact.time_s for impact in found.bounces.impacts])
        found = _along(track, segment, (x, y, z), sample_rate_hz, drag_1_m, impact_s, final=True)
        impacts = tuple(_with_normal(impact, at, k, floor) for k, impact in enumerate(found.bounces.impacts))
        leaning = replace(found.bounces, impacts=impacts, u_tilt_deg=floor.u_tilt_deg if impacts else None)
        found = replace(found, bounces=leaning)
    bounces, heights = found.bounces, found.heights
    if bounces.normal is None:
        return bounces
    return cross_check(bounces, heights.time_s, heights.height_m, NOMINAL_GRAVITY_M_S2 * bounces.normal[2])


def _velocities(track: Track, segment: Segment, bounces: Bounces) -> ImpactVelocities:
    part = slice(segment.first, segment.last)
    position = track.position_m[:, part]
    known = track.valid[part] & np.isfinite(position).all(axis=0)
    instants = np.array([impact.time_s for impact in bounces.impacts])
    return impact_velocities(track.time_s[part][known], position[:, known], instants)


def _with_normal(impact: Bounce, at: ImpactVelocities, number: int, floor: FloorNormal) -> Bounce:
    """Return the bounce with the normal's part in its uncertainty, where the velocities are known."""
    if not np.isfinite(impact.u_e) or not np.isfinite(at.u_side_m_s[number]):
        return impact
    # the normal comes from velocities sideways, u_e from heights: independent
    u_e = float(np.hypot(impact.u_e, np.sqrt(floor.e_variance(at.before_m_s[number], at.after_m_s[number]))))
    return replace(impact, u_e=u_e, valid=_is_valid(impact.e, u_e))


def _is_valid(e: float, u_e: float) -> bool:
    # no passive impact gives more than it takes: e above 1 beyond its u is a wrong track
    return bool(u_e < TRACKS.largest_u_e and e < 1.0 + TRACKS.sigmas_above_1 * u_e)


@dataclass(frozen=True, slots=True)
class _Along:
    """Bounces along a normal, and the heights along it on the known samples of the motion."""

    bounces: Bounces
    heights: Heights


def _along(
    track: Track,
    segment: Segment,
    normal: tuple[float, float, float],
    sample_rate_hz: float,
    drag_1_m: float,
    impact_s: FloatArray | None = None,
    *,
    final: bool,
) -> _Along:
    """Return the bounces along a normal; those that are not final lack the fall, and drag in their uncertainties.

    Their instants are sought where they are not known already.
    """
    height = np.asarray(normal) @ track.position_m
    part = slice(segment.first, segment.last)
    time, known = track.time_s, track.valid & np.isfinite(height)
    inside = known[part]
    heights = Heights(time[part][inside], height[part][inside])
    begin, end = float(time[segment.first]), float(time[segment.last - 1])

    def flights_between(impact_s: FloatArray) -> FittedFlights | None:
        flights = find_flights(begin, end, impact_s, heights.rising_speed(float(impact_s[-1])))
        return fit_track_flights(heights, flights)

    if impact_s is None:
        impact_s = find_track_impacts(time[part], height[part], inside, sample_rate_hz)
        # seen to a millisecond only, and with samples of the wrong flight the parabolas are wrong: fitted twice
        rough = flights_between(impact_s) if impact_s.size else None
        if rough is None:
            return _Along(Bounces(), heights)
        impact_s = rough.meet(impact_s)
    fitted = flights_between(impact_s)
    # a hand, a string or a lost fringe makes kinks as well: only what falls under gravity bounces
    if fitted is None or not _falls(fitted, normal):
        return _Along(Bounces(), heights)
    impact_s = fitted.meet(impact_s)
    bounces = Bounces(_impacts(fitted, impact_s), None, normal)
    if not final:
        return _Along(bounces, heights)
    fall = _free_fall(track, segment, normal, fitted, float(impact_s[0]))
    bounces = replace(bounces, free_fall=fall)
    if drag_1_m:
        bounces = with_drag(bounces, fitted, drag_1_m)
        impacts = tuple(replace(one, valid=one.valid and _is_valid(one.e, one.u_e)) for one in bounces.impacts)
        bounces = replace(bounces, impacts=impacts)
    return _Along(bounces, heights)


def _falls(fitted: FittedFlights, normal: tuple[float, float, float]) -> bool:
    """Whether the flights are about under gravity: else what looked like impacts came from elsewhere."""
    expected = NOMINAL_GRAVITY_M_S2 * max(normal[2], 1e-9)
    return abs(float(fitted.parabolas.g_m_s2) / expected - 1.0) < TRACKS.largest_g_error


def _impacts(flights: FittedFlights, impact_s: FloatArray) -> tuple[Bounce, ...]:
    fitted, nan = fit_parabolas(flights.samples, flights.height_m), np.full(impact_s.size, np.nan)
    known, one, other = flights.sides(impact_s.size)
    arriving, leaving, e, u_e = nan.copy(), nan.copy(), nan.copy(), nan.copy()
    for k in range(impact_s.size):
        if k in flights.place:
            arriving[k] = -fitted.parabolas.speed_at(flights.place[k], impact_s[k])
        if k + 1 in flights.place:
            leaving[k] = fitted.parabolas.speed_at(flights.place[k + 1], impact_s[k])
    # speeds along the normal have no sign left to lose: anything else is no rebound
    rebounds = (arriving[known] > 0.0) & (leaving[known] > 0.0)
    known, one, other = known[rebounds], one[rebounds], other[rebounds]
    e[known] = leaving[known] / arriving[known]
    u_e[known] = _u_e(fitted, one, other, impact_s[known], arriving[known], leaving[known])
    rows = np.stack([impact_s, arriving, leaving, e, u_e], axis=1).tolist()
    return tuple(
        Bounce(instant, before, after, ratio, u, METHOD, _is_valid(ratio, u))
        for instant, before, after, ratio, u in rows
    )


def _u_e(
    fitted: FittedParabolas,
    one: IntArray,
    other: IntArray,
    instant_s: FloatArray,
    before_m_s: FloatArray,
    after_m_s: FloatArray,
) -> FloatArray:
    """Return u of e = after / before, by the covariance of neighbours, which share g (GUM 5.2.2).

    Parameters
    ----------
    fitted
        Parabolas.
    one, other
        Places of those before and after each impact, shape (n_impacts,).
    instant_s, before_m_s, after_m_s
        Of each impact, same shape.
    """
    zero, unit = np.zeros(one.size), np.ones(one.size)
    d_one, d_other = (instant_s - fitted.parabolas.origin_s[flight] for flight in (one, other))
    # d / d (height and speed of the one, of the other, g)
    height_one = np.stack([unit, d_one, zero, zero, -0.5 * d_one**2])
    height_other = np.stack([zero, zero, unit, d_other, -0.5 * d_other**2])
    speed_one, speed_other = np.stack([zero, unit, zero, zero, -d_one]), np.stack([zero, zero, zero, unit, -d_other])
    # the meeting of two parabolas moves with both, by the implicit function theorem
    instant = (height_other - height_one) / -(before_m_s + after_m_s)
    before = -speed_one + fitted.g_m_s2 * instant
    after = speed_other - fitted.g_m_s2 * instant
    slope = (after - after_m_s / before_m_s * before) / before_m_s
    places = np.stack([2 * one, 2 * one + 1, 2 * other, 2 * other + 1, np.full(one.size, -1)])
    covariance = fitted.covariance[places[:, None], places]
    return np.asarray(np.sqrt(np.einsum("ak,abk,bk->k", slope, covariance, slope)))


def _free_fall(
    track: Track,
    segment: Segment,
    normal: tuple[float, float, float],
    flights: FittedFlights,
    first_impact_s: float,
) -> FreeFall | None:
    """Return the parabola of the first fall by itself: a check of the whole chain against gravity."""
    if 0 not in flights.place:
        return None
    first = flights.samples.chosen(np.arange(flights.samples.size) == flights.place[0])
    if first.count[0] < TRACKS.least_fall_samples:
        return None
    height = flights.height_m[: first.count[0]]
    # alone: with g shared by all flights, drag and a soft floor of the later ones would hide in it
    own = fit_parabolas(first, height)
    # along a leaning normal only the part g cos(tilt) acts
    vertical = max(abs(normal[2]), 1e-9)
    rest = slice(segment.rest_first, segment.rest_last)
    at_rest = np.asarray(normal) @ track.position_m[:, rest]
    at_rest = at_rest[track.valid[rest] & np.isfinite(at_rest)]
    # without a known rest the highest place stands for it: the fall began no lower
    release = float(at_rest.mean()) if at_rest.size else float(height.max())
    begin, end = (float(first.origin_s[0] + first.away_s[k]) for k in (0, -1))
    return FreeFall(
        g_m_s2=own.g_m_s2 / vertical,
        u_g_m_s2=own.u_g_m_s2 / vertical,
        first_time_s=begin,
        last_time_s=end,
        release_height_m=release,
        drop_height_m=release - float(flights.parabolas.height_at(flights.place[0], first_impact_s)),
        parabola=(
            float(own.parabolas.height_at(0, begin)),
            float(own.parabolas.speed_at(0, begin)),
            -0.5 * own.g_m_s2,
        ),
        residual_rms_m=own.residual_rms_m,
    )
