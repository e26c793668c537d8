"""Bounces of a track: coefficient of restitution of each, and the free fall before the first (method 5, Flights)."""

from dataclasses import dataclass

import numpy as np

from radargui.model.arrays import FloatArray, robust_sd
from radargui.model.gravity import NO_DRAG, Drag
from radargui.model.result import Bounces, FreeFall, Segment, Track
from radargui.motion.impacts import THIRD_DIFFERENCE_GAIN, find_track_impacts
from radargui.restitution.cross_check import PARABOLAS, cross_check, without_checks_by_walls
from radargui.restitution.floor_normal import UP, normal_of_impacts
from radargui.restitution.impact_speeds import ImpactSpeeds, drag_of_flights, error_of_e, speeds_at_impacts, with_drag
from radargui.restitution.parabola import fit_parabolas
from radargui.restitution.settings import TRACKS
from radargui.restitution.track_flights import (
    FittedFlights,
    Heights,
    find_flights,
    fit_track_flights,
    velocities_of_track,
)
from radargui.restitution.walls_of_track import without_e_by_walls

SOME = 16
"""One sample of so many tells u, and one third difference the noise."""


def find_bounces(
    track: Track,
    segment: Segment,
    normal: tuple[float, float, float] | None,
    sample_rate_hz: float,
    gravity_m_s2: float,
    u_tilt_deg: float | None = None,
    drag: Drag = NO_DRAG,
    *,
    is_drag_known: bool = True,
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
    gravity_m_s2
        g of the place, `expected_gravity_m_s2`: what falls otherwise is no flight.
    u_tilt_deg
        Standard deviation of the floor's slope from level, where the setup gives it and no normal.
    drag, is_drag_known
        Of the sphere in air, part of the uncertainties; unless it is known, k of the flights where they show more.
    """
    # first along the vertical: the impacts themselves say how the floor leans, and where they are does not need it
    found = _along(track, segment, UP if normal is None else normal, sample_rate_hz, gravity_m_s2)
    u_by_normal, u_found_deg = None, None
    if not isinstance(found, _Along):
        return Bounces(falls_with_m_s2=found)
    at = velocities_of_track(track, segment, found.impacts.time_s, gravity_m_s2)
    if normal is None:
        # an impact that gives no e may be no impact: it has no say about the floor
        known = np.isfinite(at.u_side_m_s) & found.impacts.valid
        floor = normal_of_impacts(at.before_m_s[known], at.after_m_s[known], at.u_side_m_s[known], u_tilt_deg)
        x, y, z = (float(part) for part in floor.normal)
        u_by_normal, u_found_deg = np.sqrt(floor.e_variance(at.before_m_s, at.after_m_s)), floor.u_tilt_deg
        # again: heights, speeds and what counts as a flight are along the normal found
        found = _along(track, segment, (x, y, z), sample_rate_hz, gravity_m_s2, found.impacts.time_s)
    if not isinstance(found, _Along):
        return Bounces(falls_with_m_s2=found)
    impacts, heights, g_along_m_s2 = found.impacts, found.heights, gravity_m_s2 * found.normal[2]
    fall = _free_fall(track, segment, found, gravity_m_s2)
    braked_1_m = None
    # air on a sphere of metal is known; a plastic one nobody named is braked ten times as much
    if not is_drag_known:
        least_1_m = TRACKS.much_drag * drag.k_1_m
        seen_1_m, u_seen_1_m = drag_of_flights(found.flights, drag.slow_m_s, least_1_m)
        if seen_1_m - TRACKS.sure_of_drag * u_seen_1_m > least_1_m:
            braked_1_m, drag = seen_1_m, drag._replace(k_1_m=seen_1_m)
    # waves as long as a rebound is high bend both flights, and leave no residuals
    u_at_impact_m = _u_of_waves_m(track, found)
    rebound_m = impacts.after_m_s**2 / (2.0 * g_along_m_s2)
    impacts = impacts.widened(TRACKS.waves_in_rebounds * impacts.e * u_at_impact_m / rebound_m, impacts.valid)
    if drag.k_1_m:
        impacts = impacts.widened(error_of_e(impacts, found.flights, drag), impacts.valid)
        fall = None if fall is None else with_drag(fall, found.flights, drag, found.normal)
    if u_by_normal is not None:
        # the normal comes from velocities sideways, u_e from heights: independent
        known = np.isfinite(impacts.u_e) & np.isfinite(u_by_normal)
        impacts = impacts.widened(np.where(known, u_by_normal, 0.0), known | impacts.valid)
    bounces = Bounces(impacts.bounces(PARABOLAS), fall, found.normal, u_found_deg, braked_1_m)
    span_s = float(track.time_s[segment.first]), _landing_s(bounces, segment, track, gravity_m_s2)
    bounces = without_e_by_walls(bounces, track, at, span_s)
    return without_checks_by_walls(cross_check(bounces, heights.time_s, heights.height_m, g_along_m_s2))


def _landing_s(bounces: Bounces, segment: Segment, track: Track, gravity_m_s2: float) -> float:
    """Return when the flight after the last impact ends."""
    last = bounces.impacts[-1]
    landing_s = last.time_s + 2.0 * last.speed_after_m_s / gravity_m_s2
    return min(landing_s, float(track.time_s[segment.last - 1]))


@dataclass(frozen=True, slots=True)
class _Along:
    """Impacts and flights along a normal, and the heights along it on the known samples of the motion."""

    normal: tuple[float, float, float]
    heights: Heights
    flights: FittedFlights
    impacts: ImpactSpeeds


def _along(
    track: Track,
    segment: Segment,
    normal: tuple[float, float, float],
    sample_rate_hz: float,
    gravity_m_s2: float,
    impact_s: FloatArray | None = None,
) -> _Along | float | None:
    """Return the impacts along a normal, None without any; their instants are sought where they are not known.

    Of what falls and bounces with another g than that of the place, that g.
    """
    height = np.asarray(normal) @ track.position_m
    part = slice(segment.first, segment.last)
    time, known = track.time_s, track.valid & np.isfinite(height)
    inside = known[part]
    heights = Heights(time[part][inside], height[part][inside])
    begin, end = float(time[segment.first]), float(time[segment.last - 1])

    def flights_between(impact_s: FloatArray) -> FittedFlights | None:
        rising_m_s = heights.rising_speed(float(impact_s[-1]), gravity_m_s2)
        flights = find_flights(begin, end, impact_s, rising_m_s, gravity_m_s2)
        return fit_track_flights(heights, flights)

    if impact_s is None:
        impact_s = find_track_impacts(time[part], height[part], inside, sample_rate_hz, gravity_m_s2)
        # seen to a millisecond only, and with samples of the wrong flight the parabolas are wrong: fitted twice
        rough = flights_between(impact_s) if impact_s.size else None
        if rough is None:
            return None
        impact_s = rough.meet(impact_s)
    fitted, expected = flights_between(impact_s), gravity_m_s2 * max(normal[2], 1e-9)
    # a hand, a string or a lost fringe makes kinks as well: only what falls under gravity bounces
    if fitted is None:
        return None
    if abs(float(fitted.parabolas.g_m_s2) / expected - 1.0) >= TRACKS.largest_g_error:
        return _g_of_all(fitted, max(normal[2], 1e-9))
    return _Along(normal, heights, fitted, speeds_at_impacts(fitted, fitted.meet(impact_s)))


def _g_of_all(fitted: FittedFlights, vertical: float) -> float | None:
    """Return the vertical acceleration downwards that two flights or more have alike, each by itself; else None."""
    count, shared = fitted.samples.size, float(fitted.parabolas.g_m_s2)
    if count < 2 or shared <= 0.0:
        return None
    for number in range(count):
        one = fitted.samples.chosen(np.arange(count) == number)
        first = int(fitted.samples.count[:number].sum())
        own = fit_parabolas(one, fitted.height_m[first : first + int(one.count[0])])
        if abs(own.g_m_s2 / shared - 1.0) > TRACKS.alike_g:
            return None
    return shared / vertical


def _u_of_waves_m(track: Track, found: _Along) -> FloatArray:
    """Return u of the height at the impacts without the noise from sample to sample, shape (n_impacts,)."""
    # it changes slowly: some samples tell it
    some = np.flatnonzero(track.valid[::SOME]) * SOME
    u_m = np.linalg.norm(np.array(found.normal)[:, None] * track.u_position_m[:, some], axis=0)
    # the third difference has none of what is smooth; its median none of gaps and impacts
    height = found.heights.height_m
    height = height[: height.size // SOME * SOME].reshape(-1, SOME)
    third = height[:, 3] - 3.0 * (height[:, 2] - height[:, 1]) - height[:, 0]
    noise_m = robust_sd(third) / np.sqrt(THIRD_DIFFERENCE_GAIN)
    waves_m = np.sqrt(np.maximum(u_m**2 - noise_m**2, 0.0))
    return np.asarray(np.interp(found.impacts.time_s, track.time_s[some], waves_m))


def _free_fall(track: Track, segment: Segment, found: _Along, gravity_m_s2: float) -> FreeFall | None:
    """Return the parabola of the first fall by itself: a check of the whole chain against gravity."""
    normal, flights = found.normal, found.flights
    if 0 not in flights.place:
        return None
    first = flights.samples.chosen(np.arange(flights.samples.size) == flights.place[0])
    if np.ptp(first.away_s[: first.count[0]]) < TRACKS.least_fall_s:
        return None
    height = flights.height_m[: first.count[0]]
    # alone: with g shared by all flights, drag and a soft floor of the later ones would hide in it
    own, vertical = fit_parabolas(first, height), max(abs(normal[2]), 1e-9)
    # along a leaning normal only the part g cos(tilt) acts; what rides a plate, or hangs, does not fall
    if abs(own.g_m_s2 / vertical / gravity_m_s2 - 1.0) >= TRACKS.largest_g_error:
        return None
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
        drop_height_m=release - float(flights.parabolas.height_at(flights.place[0], found.impacts.time_s[0])),
        parabola=(float(own.parabolas.height_at(0, begin)), float(own.parabolas.speed_at(0, begin)), -0.5 * own.g_m_s2),
        residual_rms_m=own.residual_rms_m,
    )
