"""Flights of a track: the stretches between impacts in which only gravity acts, and about what they are.

Method 5, Flights.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from radargui.model.arrays import BoolArray, FloatArray, IntArray, median
from radargui.model.result import Segment, Track
from radargui.motion.impacts import find_track_impacts
from radargui.restitution.parabola import misfits_m, solve_parabolas
from radargui.restitution.settings import TRACKS
from radargui.restitution.stretches import Stretches


@dataclass(frozen=True, slots=True)
class TrackFlights:
    """Flights between the impacts of a track, that before the first and that after the last included.

    Attributes
    ----------
    impact_s
        About when, shape (n_impacts,).
    begin_s, end_s
        Of each flight, clear of the impacts, shape (n_impacts + 1,); NaN where it cannot be fitted.
    start_m, velocity_m_s
        About where each flight begins (at the impact before it), shapes (n_impacts + 1, 3).
    """

    impact_s: FloatArray
    begin_s: FloatArray
    end_s: FloatArray
    start_m: FloatArray
    velocity_m_s: FloatArray

    @property
    def first_s(self) -> FloatArray:
        """When each flight begins: at the impact before it, the first one clear of the release, (n_impacts + 1,)."""
        return np.append(self.begin_s[:1], self.impact_s)

    @property
    def are_known(self) -> BoolArray:
        """Which can be fitted, shape (n_impacts + 1,)."""
        return np.isfinite(self.begin_s)


def find_track_flights(
    track: Track, segment: Segment, sample_rate_hz: float, gravity_m_s2: float
) -> TrackFlights | float | None:
    """Return the flights of a track's motion; None where nothing bounces.

    Of what falls and bounces with another g than that of the place, that g. A stretch that is no parabola (an impact
    missed in it, a lost fringe) is no flight.

    Parameters
    ----------
    track, segment
        Places, and the motion within them.
    sample_rate_hz
        Of the track.
    gravity_m_s2
        g of the place, `expected_gravity_m_s2`: what falls otherwise is no flight.
    """
    part = slice(segment.first, segment.last)
    time, position = track.time_s[part], track.position_m[:, part]
    known = track.valid[part] & np.isfinite(position).all(axis=0)
    impact_s = find_track_impacts(time, position[2], known, sample_rate_hz, gravity_m_s2)
    if not impact_s.size:
        return None
    begin_s, end_s = float(time[0]), float(time[-1])
    if not known.all():
        time, position = time[known], position[:, known]
    rising_m_s = _rising_speed(time, position[2], float(impact_s[-1]), gravity_m_s2)
    flights_s = find_flights(begin_s, end_s, impact_s, rising_m_s, gravity_m_s2)
    number, samples = samples_of_flights(time, flights_s, TRACKS.min_samples, TRACKS.min_known_s)
    if not number.size:
        return None
    height = samples.of(position[2])
    if samples.size > 2:
        # two flights have no median that tells which of them is wrong
        alone = misfits_m(samples, height)
        # by the run's own median: noise differs from run to run
        fits = alone <= max(TRACKS.largest_residual * float(median(alone)), TRACKS.min_residual_m)
        number, samples = number[fits], samples.chosen(fits)
        height = samples.of(position[2])
    # a hand, a string or a lost fringe makes kinks as well: only what falls under gravity bounces
    shared = float(solve_parabolas(samples, height).g_m_s2)
    if abs(shared / gravity_m_s2 - 1.0) >= TRACKS.largest_g_error:
        each = solve_parabolas(samples, height, shared=False).g_m_s2
        alike = samples.size > 1 and shared > 0.0 and bool((np.abs(each / shared - 1.0) <= TRACKS.alike_g).all())
        return shared if alike else None
    first_s = np.append(flights_s[0, 0], impact_s)
    ends_s, (start, velocity) = np.full((first_s.size, 2), np.nan), np.zeros((2, first_s.size, 3))
    ends_s[number] = flights_s[number]
    # with what gravity does taken off they are straight
    since_s = samples.away_s + samples.spread(samples.origin_s - first_s[number])
    straight = samples.of(position)
    straight[2] += 0.5 * gravity_m_s2 * since_s**2
    level, slope = samples.lines(straight)
    velocity[number], start[number] = slope.T, (level - slope * (samples.origin_s - first_s[number])).T
    return TrackFlights(impact_s, ends_s[:, 0], ends_s[:, 1], start, velocity)


def _rising_speed(time_s: FloatArray, height_m: FloatArray, impact_s: float, gravity_m_s2: float) -> float:
    """Return the upward speed just after an impact from the milliseconds that follow it."""
    # the corner itself is rounded by the low-pass of the correction
    begin = impact_s + 0.001
    inside = slice(*np.searchsorted(time_s, [begin, begin + TRACKS.rising_s]))
    d, height = time_s[inside] - impact_s, height_m[inside]
    # the line has one unknown, and a second says whether it is one
    if d.size < 2 or d[-1] - d[0] < TRACKS.min_rising_s:
        return 0.0
    # gravity taken off, a line has one unknown less: so few samples bear no parabola
    straight, away = height + 0.5 * gravity_m_s2 * d * d, d - d.mean()
    return max(0.0, float(away @ straight / (away @ away)))


def find_flights(
    begin_s: float, end_s: float, impact_s: FloatArray, rising_m_s: float, gravity_m_s2: float
) -> FloatArray:
    """Return begin and end of the flight before each impact and of the one after the last, NaN if too short to fit.

    Parameters
    ----------
    begin_s, end_s
        Span of the motion.
    impact_s
        Instants of impact in order, shape (n_impacts,).
    rising_m_s, gravity_m_s2
        Speed after the last impact, and g of the place: the sphere is back on the floor 2 v / g later.

    Returns
    -------
    FloatArray
        Shape (n_impacts + 1, 2).
    """
    begins = np.concatenate([[begin_s + TRACKS.start_clearance_s], impact_s + TRACKS.clearance_s])
    # the flight after the last impact ends on the floor although no impact was seen there
    landing = float(impact_s[-1]) + 2.0 * rising_m_s / gravity_m_s2 if impact_s.size else end_s
    ends = np.concatenate([impact_s, [min(end_s, landing)]]) - TRACKS.clearance_s
    return np.where((ends - begins >= TRACKS.min_flight_s)[:, None], np.stack([begins, ends], axis=1), np.nan)


def are_known(
    time_s: FloatArray, begin: IntArray, end: IntArray, min_s: float, least: int = TRACKS.min_samples
) -> BoolArray:
    """Return which stretches of samples, from `begin` to before `end`, last so long and can bear a parabola.

    How much they tell is a matter of their duration: that of so many samples is another one at each rate.
    """
    if time_s.size == 0:
        return np.zeros(begin.shape, dtype=np.bool_)
    lasts_s = time_s[np.maximum(end - 1, 0)] - time_s[np.minimum(begin, time_s.size - 1)]
    return np.asarray((end - begin >= least) & (lasts_s >= min_s))


def samples_of_flights(
    time_s: FloatArray, flights_s: FloatArray, least: int, min_s: float = 0.0
) -> tuple[IntArray, Stretches]:
    """Return the numbers of the flights that hold enough of the samples at times (n,), and these."""
    # an unknown begin and end are both after all samples: such a flight holds none
    begin, end = np.searchsorted(time_s, flights_s.T)
    enough = are_known(time_s, begin, end, min_s, least)
    return np.flatnonzero(enough), Stretches.between(time_s, begin[enough], end[enough])


def impact_sides(time_s: FloatArray, impact_s: FloatArray) -> tuple[IntArray, IntArray, Stretches]:
    """Return the samples of a curve at times (n,) on both sides of impacts (n_impacts,), where they bear a line.

    Side (0 before, 1 after) and number of the impact, shapes (n_sides,), and the samples of each.
    """
    near, far = TRACKS.clearance_s, TRACKS.side_s
    begin = np.searchsorted(time_s, np.stack([impact_s - far, impact_s + near]))
    end = np.searchsorted(time_s, np.stack([impact_s - near, impact_s + far]))
    side, impact = np.nonzero(are_known(time_s, begin, end, TRACKS.min_side_s))
    return side, impact, Stretches.between(time_s, begin[side, impact], end[side, impact])
