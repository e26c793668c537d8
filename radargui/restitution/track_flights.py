"""Flights of a track: the stretches between impacts in which only gravity acts, and the velocities at their ends."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from radargui.model.arrays import FloatArray
from radargui.model.gravity import NOMINAL_GRAVITY_M_S2
from radargui.restitution.parabola import Parabolas, correlation_length, fit_parabolas
from radargui.restitution.settings import TRACKS


@dataclass(frozen=True, slots=True)
class Flight:
    """A stretch of free flight, begin_s to end_s."""

    begin_s: float
    end_s: float


@dataclass(frozen=True, slots=True)
class Heights:
    """Height along the floor's normal on the valid samples of the motion, shapes (n,)."""

    time_s: FloatArray
    height_m: FloatArray

    def within(self, flight: Flight) -> tuple[FloatArray, FloatArray]:
        """Return times and heights of a flight."""
        inside = slice(*np.searchsorted(self.time_s, [flight.begin_s, flight.end_s]))
        return self.time_s[inside], self.height_m[inside]

    def rising_speed(self, impact_s: float) -> float:
        """Return the upward speed just after an impact from the milliseconds that follow it."""
        # the corner itself is rounded by the low-pass of the correction
        begin = impact_s + 0.001
        time, height = self.within(Flight(begin, begin + TRACKS.rising_s))
        if time.size < TRACKS.least_rising:
            return 0.0
        d = time - impact_s
        # gravity taken off, a line has one unknown less: so few samples bear no parabola
        return max(0.0, float(np.polyfit(d, height + 0.5 * NOMINAL_GRAVITY_M_S2 * d * d, 1)[0]))


@dataclass(frozen=True, slots=True)
class FittedFlights:
    """Parabolas through the flights.

    Attributes
    ----------
    parabolas
        One a fitted flight.
    place
        For each flight that was fitted its place among them; flight k ends with impact k.
    """

    parabolas: Parabolas
    place: dict[int, int]

    def meet(self, impact_s: FloatArray) -> FloatArray:
        """Return where the parabolas before and after each impact meet, nearest to the first estimate."""
        out, fitted = impact_s.copy(), self.parabolas
        for k, instant in enumerate(impact_s):
            if k not in self.place or k + 1 not in self.place:
                continue
            before, after = self.place[k], self.place[k + 1]
            # one Newton step: the parabolas are nearly straight within a millisecond
            gap = fitted.height_at(after, instant) - fitted.height_at(before, instant)
            closing = fitted.speed_at(before, instant) - fitted.speed_at(after, instant)
            step = gap / closing if closing != 0.0 else 0.0
            if abs(step) < TRACKS.largest_shift_s:
                out[k] = instant + step
        return out


def find_flights(begin_s: float, end_s: float, impact_s: FloatArray, rising_m_s: float) -> tuple[Flight | None, ...]:
    """Return the flight before each impact and the one after the last, None where it is too short to fit.

    Parameters
    ----------
    begin_s, end_s
        Span of the motion.
    impact_s
        Instants of impact in order, shape (n_impacts,).
    rising_m_s
        Speed after the last impact: the sphere is back on the floor 2 v / g later.

    Returns
    -------
    tuple
        n_impacts + 1 flights.
    """
    begins = np.concatenate([[begin_s + TRACKS.start_clearance_s], impact_s + TRACKS.clearance_s])
    # the flight after the last impact ends on the floor although no impact was seen there
    landing = float(impact_s[-1]) + 2.0 * rising_m_s / NOMINAL_GRAVITY_M_S2 if impact_s.size else end_s
    ends = np.concatenate([impact_s, [min(end_s, landing)]]) - TRACKS.clearance_s
    flights = (Flight(float(begin), float(end)) for begin, end in zip(begins, ends, strict=True))
    return tuple(one if one.end_s - one.begin_s >= TRACKS.least_flight_s else None for one in flights)


def fit_track_flights(heights: Heights, flights: tuple[Flight | None, ...]) -> FittedFlights | None:
    """Fit all flights with one g; None where none can be.

    A stretch that is no parabola (an impact missed in it, a lost fringe) would spoil the shared g: it is left out.
    """
    stretches = {
        k: stretch
        for k, stretch in ((k, heights.within(flight)) for k, flight in enumerate(flights) if flight)
        if stretch[0].size >= TRACKS.least_samples
    }
    if len(stretches) > 2:
        alone = {k: fit_parabolas([stretch]).residual_rms_m for k, stretch in stretches.items()}
        # by the run's own median: noise differs from run to run
        most = max(TRACKS.largest_residual * float(np.median(list(alone.values()))), TRACKS.least_residual_m)
        stretches = {k: stretch for k, stretch in stretches.items() if alone[k] <= most}
    if not stretches:
        return None
    return FittedFlights(fit_parabolas(list(stretches.values())), {k: n for n, k in enumerate(stretches)})


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


def impact_velocities(time_s: FloatArray, position_m: FloatArray, impact_s: FloatArray) -> ImpactVelocities:
    """Return the velocities at impacts: the ends of lines through 30 ms before and after each, gravity taken off.

    Parameters
    ----------
    time_s, position_m
        Known samples of the motion, shapes (n_samples,) and (3, n_samples).
    impact_s
        Instants of impact, shape (n_impacts,).
    """
    velocity, variance = np.full((2, impact_s.size, 3), np.nan), np.full((2, impact_s.size), np.nan)
    for number, side, inside in impact_sides(time_s, impact_s):
        d = time_s[inside] - impact_s[number]
        straight = position_m[:, inside].copy()
        straight[2] += 0.5 * NOMINAL_GRAVITY_M_S2 * d * d
        line = np.polynomial.polynomial.polyfit(d, straight.T, 1)
        velocity[side, number] = line[1]
        off = straight[:2] - line[0, :2, None] - line[1, :2, None] * d
        white = [float(own @ own) / (d.size - 2) * correlation_length(own) for own in off]
        variance[side, number] = float(np.mean(white)) / float(((d - d.mean()) ** 2).sum())
    return ImpactVelocities(velocity[0], velocity[1], np.sqrt(variance.sum(axis=0)))


def impact_sides(time_s: FloatArray, impact_s: FloatArray) -> Iterator[tuple[int, int, slice]]:
    """Yield the impact's number, 0 before it and 1 after, and the samples there, where these are enough for a line."""
    for number, instant in enumerate(impact_s):
        for side, sign in enumerate((-1.0, 1.0)):
            ends = np.sort(instant + sign * np.array([TRACKS.clearance_s, TRACKS.side_s]))
            inside = slice(*np.searchsorted(time_s, ends))
            if inside.stop - inside.start >= TRACKS.least_side_samples:
                yield number, side, inside
