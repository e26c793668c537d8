"""Coefficient of restitution of each bounce, and the free fall before the first."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from radargui.model.arrays import FloatArray
from radargui.model.bounce import Bounce, Bounces, FreeFall
from radargui.model.segment import Segment
from radargui.model.track import Track
from radargui.motion.flights import Flight, find_flights
from radargui.motion.impacts import find_impacts
from radargui.restitution.cross_check import cross_check
from radargui.restitution.floor_normal import UP, find_normal
from radargui.restitution.parabola import Parabolas, fit_parabolas

NOMINAL_G_M_S2 = 9.81
METHOD = "parabolas with shared g"
LARGEST_U_E = 0.1
"""A coefficient less certain than this is told as not valid."""
LARGEST_G_ERROR = 0.3
LEAST_SAMPLES = 8
LARGEST_RESIDUAL = 5.0
LEAST_RESIDUAL_M = 1.0e-3
"""A flight is no parabola where it misses its own by this, and by five times what the flights of the run do."""


@dataclass(frozen=True, slots=True)
class _Heights:
    """Height along the floor's normal on the valid samples of the motion."""

    time_s: FloatArray
    height_m: FloatArray

    def within(self, flight: Flight) -> tuple[FloatArray, FloatArray]:
        inside = slice(*np.searchsorted(self.time_s, [flight.begin_s, flight.end_s]))
        return self.time_s[inside], self.height_m[inside]


def find_bounces(
    track: Track, segment: Segment, normal: tuple[float, float, float] | None, sample_rate_hz: float
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
        Unit vector away from the floor; None: found from the impacts.
    sample_rate_hz
        Rate of the samples.
    """
    if normal is not None:
        return _along(track, segment, normal, sample_rate_hz)
    bounces = _along(track, segment, UP, sample_rate_hz)
    part = slice(segment.first, segment.last)
    known = track.valid[part] & np.isfinite(track.position_m[:, part]).all(axis=0)
    impact_s = np.array([impact.time_s for impact in bounces.impacts if impact.valid])
    found = find_normal(track.time_s[part][known], track.position_m[:, part][:, known], impact_s, NOMINAL_G_M_S2)
    return bounces if found == UP else _along(track, segment, found, sample_rate_hz)


def _along(track: Track, segment: Segment, normal: tuple[float, float, float], sample_rate_hz: float) -> Bounces:
    height = np.asarray(normal) @ track.position_m
    part = slice(segment.first, segment.last)
    time, known = track.time_s, track.valid & np.isfinite(height)
    impact_s = find_impacts(time[part], height[part], known[part], sample_rate_hz)
    if impact_s.size == 0:
        return Bounces()
    heights = _Heights(time[part][known[part]], height[part][known[part]])
    begin, end = float(time[segment.first]), float(time[segment.last - 1])
    flights = find_flights(begin, end, impact_s, _rising_speed(heights, impact_s), NOMINAL_G_M_S2)
    rough, place = _fit(heights, flights)
    if rough is None:
        return Bounces()
    impact_s = _meet(rough, place, impact_s)
    flights = find_flights(begin, end, impact_s, _rising_speed(heights, impact_s), NOMINAL_G_M_S2)
    fitted, place = _fit(heights, flights)
    if fitted is None or not _falls(fitted, normal):
        return Bounces()
    impact_s = _meet(fitted, place, impact_s)
    impacts = tuple(_bounce(fitted, place, k, instant) for k, instant in enumerate(impact_s))
    fall = _free_fall(heights, flights[0], track, segment, normal, fitted, place, float(impact_s[0]))
    return cross_check(Bounces(impacts, fall, normal), heights.time_s, heights.height_m, NOMINAL_G_M_S2 * normal[2])


def _falls(fitted: Parabolas, normal: tuple[float, float, float]) -> bool:
    """Whether the flights are about under gravity: else what looked like impacts came from elsewhere."""
    return abs(fitted.g_m_s2 / (NOMINAL_G_M_S2 * max(normal[2], 1e-9)) - 1.0) < LARGEST_G_ERROR


def _rising_speed(heights: _Heights, impact_s: FloatArray) -> float:
    """Return the speed after the last impact from the 12 ms that follow it."""
    time, height = heights.within(Flight(float(impact_s[-1]) + 0.001, float(impact_s[-1]) + 0.013))
    if time.size < 4:
        return 0.0
    d = time - impact_s[-1]
    return max(0.0, float(np.polyfit(d, height + 0.5 * NOMINAL_G_M_S2 * d * d, 1)[0]))


def _fit(heights: _Heights, flights: tuple[Flight | None, ...]) -> tuple[Parabolas | None, dict[int, int]]:
    """Fit all flights; return the parabolas and, for each flight that was fitted, its place among them.

    A stretch that is no parabola (an impact missed in it, a lost fringe) would spoil the shared g: it is left out.
    """
    stretches = {
        k: stretch
        for k, stretch in ((k, heights.within(flight)) for k, flight in enumerate(flights) if flight)
        if stretch[0].size >= LEAST_SAMPLES
    }
    if len(stretches) > 2:
        alone = {k: fit_parabolas([stretch]).residual_rms_m for k, stretch in stretches.items()}
        most = max(LARGEST_RESIDUAL * float(np.median(list(alone.values()))), LEAST_RESIDUAL_M)
        stretches = {k: stretch for k, stretch in stretches.items() if alone[k] <= most}
    place = {k: n for n, k in enumerate(stretches)}
    return (fit_parabolas(list(stretches.values())) if stretches else None), place


def _meet(fitted: Parabolas, place: dict[int, int], impact_s: FloatArray) -> FloatArray:
    """Return where the parabolas before and after each impact meet, nearest to the first estimate."""
    out = impact_s.copy()
    for k, instant in enumerate(impact_s):
        if k not in place or k + 1 not in place:
            continue
        before, after = place[k], place[k + 1]
        gap = fitted.height_at(after, instant) - fitted.height_at(before, instant)
        closing = fitted.speed_at(before, instant) - fitted.speed_at(after, instant)
        step = gap / closing if closing != 0.0 else 0.0
        if abs(step) < 0.005:
            out[k] = instant + step
    return out


def _bounce(fitted: Parabolas, place: dict[int, int], k: int, instant_s: float) -> Bounce:
    nan = float("nan")
    before = -fitted.speed_at(place[k], instant_s) if k in place else nan
    after = fitted.speed_at(place[k + 1], instant_s) if k + 1 in place else nan
    if not (before > 0.0 and after > 0.0):
        return Bounce(instant_s, before, after, nan, nan, METHOD, valid=False)
    e = after / before
    gradient = _e_gradient(fitted, place[k], place[k + 1], instant_s, before, after)
    u_e = float(np.sqrt(gradient @ fitted.covariance @ gradient))
    return Bounce(instant_s, before, after, e, u_e, METHOD, valid=bool(u_e < LARGEST_U_E and e < 1.0 + 3.0 * u_e))


def _e_gradient(fitted: Parabolas, k: int, m: int, instant_s: float, before: float, after: float) -> FloatArray:
    """Return de / d parameters; the instant itself moves with the parameters of both parabolas."""
    instant = (fitted.height_gradient(m, instant_s) - fitted.height_gradient(k, instant_s)) / -(before + after)
    d_before = -fitted.speed_gradient(k, instant_s) + fitted.g_m_s2 * instant
    d_after = fitted.speed_gradient(m, instant_s) - fitted.g_m_s2 * instant
    return np.asarray(d_after / before - after / before**2 * d_before)


def _free_fall(
    heights: _Heights,
    flight: Flight | None,
    track: Track,
    segment: Segment,
    normal: tuple[float, float, float],
    fitted: Parabolas,
    place: dict[int, int],
    first_impact_s: float,
) -> FreeFall | None:
    """Return the parabola of the first fall by itself: a check of the whole chain against gravity."""
    if flight is None or 0 not in place:
        return None
    time, height = heights.within(flight)
    if time.size < 16:
        return None
    own = fit_parabolas([(time, height)])
    vertical = max(abs(normal[2]), 1e-9)
    rest = slice(segment.rest_first, segment.rest_last)
    at_rest = np.asarray(normal) @ track.position_m[:, rest]
    at_rest = at_rest[track.valid[rest] & np.isfinite(at_rest)]
    release = float(at_rest.mean()) if at_rest.size else float(height.max())
    begin = float(time[0])
    return FreeFall(
        g_m_s2=own.g_m_s2 / vertical,
        u_g_m_s2=own.u_g_m_s2 / vertical,
        first_time_s=begin,
        last_time_s=float(time[-1]),
        release_height_m=release,
        drop_height_m=release - fitted.height_at(place[0], first_impact_s),
        parabola=(own.height_at(0, begin), own.speed_at(0, begin), -0.5 * own.g_m_s2),
        residual_rms_m=own.residual_rms_m,
    )
