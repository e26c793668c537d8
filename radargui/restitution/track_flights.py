"""Flights of a track: the stretches between impacts in which only gravity acts, and the velocities at their ends.

Method 5, Flights.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from radargui.model.arrays import BoolArray, FloatArray, IntArray, median
from radargui.model.result import Segment, Track
from radargui.restitution.parabola import Parabolas, misfits_m, solve_parabolas
from radargui.restitution.settings import TRACKS
from radargui.restitution.stretches import Stretches


@dataclass(frozen=True, slots=True)
class Heights:
    """Height along the floor's normal on the valid samples of the motion, shapes (n,)."""

    time_s: FloatArray
    height_m: FloatArray

    def rising_speed(self, impact_s: float, gravity_m_s2: float) -> float:
        """Return the upward speed just after an impact from the milliseconds that follow it."""
        # the corner itself is rounded by the low-pass of the correction
        begin = impact_s + 0.001
        inside = slice(*np.searchsorted(self.time_s, [begin, begin + TRACKS.rising_s]))
        d, height = self.time_s[inside] - impact_s, self.height_m[inside]
        # the line has one unknown, and a second says whether it is one
        if d.size < 2 or d[-1] - d[0] < TRACKS.least_rising_s:
            return 0.0
        # gravity taken off, a line has one unknown less: so few samples bear no parabola
        straight, away = height + 0.5 * gravity_m_s2 * d * d, d - d.mean()
        return max(0.0, float(away @ straight / (away @ away)))


@dataclass(frozen=True, slots=True)
class FittedFlights:
    """Parabolas through the flights.

    Attributes
    ----------
    samples, height_m
        Of the flights that were fitted.
    parabolas
        One a fitted flight.
    place
        For each flight that was fitted its place among them; flight k ends with impact k.
    """

    samples: Stretches
    height_m: FloatArray
    parabolas: Parabolas
    place: dict[int, int]

    @staticmethod
    def of(number: IntArray, samples: Stretches, height_m: FloatArray) -> FittedFlights:
        """Return the flights of these numbers, fitted to heights (..., n_samples) with one g."""
        place = {int(k): n for n, k in enumerate(number)}
        return FittedFlights(samples, height_m, solve_parabolas(samples, height_m), place)

    def sides(self, n_impacts: int) -> tuple[IntArray, IntArray, IntArray]:
        """Return the impacts with fitted flights on both sides, and the places of those before and after, (n,) each."""
        known = [k for k in range(n_impacts) if k in self.place and k + 1 in self.place]
        before, after = ([self.place[k + side] for k in known] for side in (0, 1))
        return np.array(known, dtype=np.intp), np.array(before, dtype=np.intp), np.array(after, dtype=np.intp)

    def meet(self, impact_s: FloatArray) -> FloatArray:
        """Return where the parabolas before and after each impact meet, (n_impacts,), nearest to the first estimate."""
        out, fitted = impact_s.copy(), self.parabolas
        known, before, after = self.sides(impact_s.size)
        instant = impact_s[known]
        # one Newton step: the parabolas are nearly straight within a millisecond
        gap = fitted.height_at(after, instant) - fitted.height_at(before, instant)
        closing = fitted.speed_at(before, instant) - fitted.speed_at(after, instant)
        step = np.where(closing != 0.0, gap / np.where(closing != 0.0, closing, 1.0), 0.0)
        out[known] += np.where(np.abs(step) < TRACKS.largest_shift_s, step, 0.0)
        return out


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
    return np.where((ends - begins >= TRACKS.least_flight_s)[:, None], np.stack([begins, ends], axis=1), np.nan)


def fit_track_flights(heights: Heights, flights_s: FloatArray) -> FittedFlights | None:
    """Fit all flights, begin and end in s of shape (n_flights, 2), with one g; None where none can be.

    A stretch that is no parabola (an impact missed in it, a lost fringe) would spoil the shared g: it is left out.
    """
    number, samples = samples_of_flights(heights.time_s, flights_s, TRACKS.least_samples, TRACKS.least_known_s)
    if not number.size:
        return None
    if samples.size > 2:
        # two flights have no median that tells which of them is wrong
        alone = misfits_m(samples, samples.of(heights.height_m))
        # by the run's own median: noise differs from run to run
        fits = alone <= max(TRACKS.largest_residual * float(median(alone)), TRACKS.least_residual_m)
        number, samples = number[fits], samples.chosen(fits)
    return FittedFlights.of(number, samples, samples.of(heights.height_m))


def are_known(
    time_s: FloatArray, begin: IntArray, end: IntArray, least_s: float, least: int = TRACKS.least_samples
) -> BoolArray:
    """Return which stretches of samples, from `begin` to before `end`, last so long and can bear a parabola.

    How much they tell is a matter of their duration: that of so many samples is another one at each rate.
    """
    if time_s.size == 0:
        return np.zeros(begin.shape, dtype=np.bool_)
    lasts_s = time_s[np.maximum(end - 1, 0)] - time_s[np.minimum(begin, time_s.size - 1)]
    return np.asarray((end - begin >= least) & (lasts_s >= least_s))


def samples_of_flights(
    time_s: FloatArray, flights_s: FloatArray, least: int, least_s: float = 0.0
) -> tuple[IntArray, Stretches]:
    """Return the numbers of the flights that hold enough of the samples at times (n,), and these."""
    # an unknown begin and end are both after all samples: such a flight holds none
    begin, end = np.searchsorted(time_s, flights_s.T)
    enough = are_known(time_s, begin, end, least_s, least)
    return np.flatnonzero(enough), Stretches.between(time_s, begin[enough], end[enough])


@dataclass(frozen=True, slots=True)
class ImpactVelocities:
    """Velocities at impacts.

    Attributes
    ----------
    before_m_s, after_m_s
        Shape (n_impacts, 3); NaN where too little is known.
    u_side_m_s
        Standard uncertainty of a horizontal component of their difference, shape (n_impacts,).
    """

    before_m_s: FloatArray
    after_m_s: FloatArray
    u_side_m_s: FloatArray


def impact_velocities(
    time_s: FloatArray, position_m: FloatArray, impact_s: FloatArray, gravity_m_s2: float, *, white: bool = False
) -> ImpactVelocities:
    """Return the velocities at impacts: the ends of lines through 30 ms before and after each, gravity taken off.

    Parameters
    ----------
    time_s, position_m
        Known samples of the motion, shapes (n_samples,) and (3, n_samples).
    impact_s
        Instants of impact, shape (n_impacts,).
    gravity_m_s2
        g of the place.
    white
        Whether residuals count as white: their correlation is most of the work, and about the same at all impacts.
    """
    side, impact, samples = impact_sides(time_s, impact_s)
    velocity, variance = np.full((2, impact_s.size, 3), np.nan), np.full((2, impact_s.size), np.nan)
    straight = samples.of(position_m)
    d = samples.away_s + samples.spread(samples.origin_s - impact_s[impact])
    straight[2] += 0.5 * gravity_m_s2 * d * d
    level, slope = samples.lines(straight)
    velocity[side, impact] = slope.T
    off = straight[:2] - samples.spread(level[:2]) - samples.spread(slope[:2]) * samples.away_s
    square = samples.sums(off**2) / (samples.count - 2)
    if not white:
        square *= samples.correlation_lengths(off)
    variance[side, impact] = square.mean(axis=0) / samples.sums(samples.away_s**2)
    return ImpactVelocities(velocity[0], velocity[1], np.sqrt(variance.sum(axis=0)))


def velocities_of_track(track: Track, segment: Segment, impact_s: FloatArray, gravity_m_s2: float) -> ImpactVelocities:
    """Return `impact_velocities` of the known samples of a track's motion, impacts of shape (n_impacts,)."""
    part = slice(segment.first, segment.last)
    time, position = track.time_s[part], track.position_m[:, part]
    known = track.valid[part] & np.isfinite(position).all(axis=0)
    if not known.all():
        time, position = time[known], position[:, known]
    return impact_velocities(time, position, impact_s, gravity_m_s2)


def impact_sides(time_s: FloatArray, impact_s: FloatArray) -> tuple[IntArray, IntArray, Stretches]:
    """Return the samples of a curve at times (n,) on both sides of impacts (n_impacts,), where they bear a line.

    Side (0 before, 1 after) and number of the impact, shapes (n_sides,), and the samples of each.
    """
    near, far = TRACKS.clearance_s, TRACKS.side_s
    begin = np.searchsorted(time_s, np.stack([impact_s - far, impact_s + near]))
    end = np.searchsorted(time_s, np.stack([impact_s - near, impact_s + far]))
    side, impact = np.nonzero(are_known(time_s, begin, end, TRACKS.least_side_s))
    return side, impact, Stretches.between(time_s, begin[side, impact], end[side, impact])
