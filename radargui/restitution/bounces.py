"""Bounces of a track: coefficient of restitution of each, and the free fall before the first."""

from dataclasses import replace

import numpy as np

from radargui.model.arrays import FloatArray
from radargui.model.bounce import Bounce, Bounces, FreeFall
from radargui.model.gravity import NOMINAL_GRAVITY_M_S2
from radargui.model.segment import Segment
from radargui.model.track import Track
from radargui.motion.impacts import find_track_impacts
from radargui.restitution.cross_check import cross_check
from radargui.restitution.floor_normal import UP, FloorNormal, normal_of_impacts
from radargui.restitution.parabola import Parabolas, fit_parabolas
from radargui.restitution.settings import TRACKS
from radargui.restitution.track_drag import with_drag
from radargui.restitution.track_flights import (
    FittedFlights,
    Flight,
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
    bounces = _along(track, segment, UP if normal is None else normal, sample_rate_hz, drag_1_m)
    if normal is not None or not bounces.impacts:
        return bounces
    at = _velocities(track, segment, bounces)
    # an impact that gives no e may be no impact: it has no say about the floor
    known = np.isfinite(at.u_side_m_s) & np.array([impact.valid for impact in bounces.impacts])
    floor = normal_of_impacts(at.before_m_s[known], at.after_m_s[known], at.u_side_m_s[known], u_tilt_deg)
    x, y, z = (float(part) for part in floor.normal)
    # again: heights, speeds and what counts as a flight are along the normal found
    bounces = _along(track, segment, (x, y, z), sample_rate_hz, drag_1_m)
    at = _velocities(track, segment, bounces)
    impacts = tuple(_with_normal(impact, at, k, floor) for k, impact in enumerate(bounces.impacts))
    return replace(bounces, impacts=impacts, u_tilt_deg=floor.u_tilt_deg if impacts else None)


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


def _along(
    track: Track, segment: Segment, normal: tuple[float, float, float], sample_rate_hz: float, drag_1_m: float
) -> Bounces:
    height = np.asarray(normal) @ track.position_m
    part = slice(segment.first, segment.last)
    time, known = track.time_s, track.valid & np.isfinite(height)
    impact_s = find_track_impacts(time[part], height[part], known[part], sample_rate_hz)
    if impact_s.size == 0:
        return Bounces()
    heights = Heights(time[part][known[part]], height[part][known[part]])
    begin, end = float(time[segment.first]), float(time[segment.last - 1])
    flights = find_flights(begin, end, impact_s, heights.rising_speed(float(impact_s[-1])))
    # impacts are seen to a millisecond only, and with samples of the wrong flight the parabolas are wrong: fitted twice
    rough = fit_track_flights(heights, flights)
    if rough is None:
        return Bounces()
    impact_s = rough.meet(impact_s)
    flights = find_flights(begin, end, impact_s, heights.rising_speed(float(impact_s[-1])))
    fitted = fit_track_flights(heights, flights)
    # a hand, a string or a lost fringe makes kinks as well: only what falls under gravity bounces
    if fitted is None or not _falls(fitted.parabolas, normal):
        return Bounces()
    impact_s = fitted.meet(impact_s)
    impacts = tuple(_bounce(fitted, k, float(instant)) for k, instant in enumerate(impact_s))
    fall = _free_fall(heights, flights[0], track, segment, normal, fitted, float(impact_s[0]))
    bounces = Bounces(impacts, fall, normal)
    if drag_1_m:
        times_s = [heights.within(flight)[0] for k, flight in enumerate(flights) if flight and k in fitted.place]
        bounces = with_drag(bounces, fitted, times_s, drag_1_m)
        impacts = tuple(replace(one, valid=one.valid and _is_valid(one.e, one.u_e)) for one in bounces.impacts)
        bounces = replace(bounces, impacts=impacts)
    return cross_check(bounces, heights.time_s, heights.height_m, NOMINAL_GRAVITY_M_S2 * normal[2])


def _falls(fitted: Parabolas, normal: tuple[float, float, float]) -> bool:
    """Whether the flights are about under gravity: else what looked like impacts came from elsewhere."""
    expected = NOMINAL_GRAVITY_M_S2 * max(normal[2], 1e-9)
    return abs(fitted.g_m_s2 / expected - 1.0) < TRACKS.largest_g_error


def _bounce(flights: FittedFlights, k: int, instant_s: float) -> Bounce:
    nan, fitted, place = float("nan"), flights.parabolas, flights.place
    before = -fitted.speed_at(place[k], instant_s) if k in place else nan
    after = fitted.speed_at(place[k + 1], instant_s) if k + 1 in place else nan
    # speeds along the normal have no sign left to lose: anything else is no rebound
    if not (before > 0.0 and after > 0.0):
        return Bounce(instant_s, before, after, nan, nan, METHOD, valid=False)
    e = after / before
    # error propagation with the covariance of neighbours, which share g (GUM 5.2.2)
    gradient = _e_gradient(fitted, place[k], place[k + 1], instant_s, before, after)
    u_e = float(np.sqrt(gradient @ fitted.covariance @ gradient))
    return Bounce(instant_s, before, after, e, u_e, METHOD, valid=_is_valid(e, u_e))


def _e_gradient(fitted: Parabolas, k: int, m: int, instant_s: float, before: float, after: float) -> FloatArray:
    """Return de / d parameters; the instant itself moves with the parameters of both parabolas."""
    # the meeting of two parabolas h_m(t) = h_k(t), by the implicit function theorem
    instant = (fitted.height_gradient(m, instant_s) - fitted.height_gradient(k, instant_s)) / -(before + after)
    d_before = -fitted.speed_gradient(k, instant_s) + fitted.g_m_s2 * instant
    d_after = fitted.speed_gradient(m, instant_s) - fitted.g_m_s2 * instant
    return np.asarray(d_after / before - after / before**2 * d_before)


def _free_fall(
    heights: Heights,
    flight: Flight | None,
    track: Track,
    segment: Segment,
    normal: tuple[float, float, float],
    fitted: FittedFlights,
    first_impact_s: float,
) -> FreeFall | None:
    """Return the parabola of the first fall by itself: a check of the whole chain against gravity."""
    if flight is None or 0 not in fitted.place:
        return None
    time, height = heights.within(flight)
    if time.size < TRACKS.least_fall_samples:
        return None
    # alone: with g shared by all flights, drag and a soft floor of the later ones would hide in it
    own = fit_parabolas([(time, height)])
    # along a leaning normal only the part g cos(tilt) acts
    vertical = max(abs(normal[2]), 1e-9)
    rest = slice(segment.rest_first, segment.rest_last)
    at_rest = np.asarray(normal) @ track.position_m[:, rest]
    at_rest = at_rest[track.valid[rest] & np.isfinite(at_rest)]
    # without a known rest the highest place stands for it: the fall began no lower
    release = float(at_rest.mean()) if at_rest.size else float(height.max())
    begin = float(time[0])
    return FreeFall(
        g_m_s2=own.g_m_s2 / vertical,
        u_g_m_s2=own.u_g_m_s2 / vertical,
        first_time_s=begin,
        last_time_s=float(time[-1]),
        release_height_m=release,
        drop_height_m=release - fitted.parabolas.height_at(fitted.place[0], first_impact_s),
        parabola=(own.height_at(0, begin), own.speed_at(0, begin), -0.5 * own.g_m_s2),
        residual_rms_m=own.residual_rms_m,
    )
