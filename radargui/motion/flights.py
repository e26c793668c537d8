"""Flights: the stretches between impacts in which only gravity acts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from radargui.model.arrays import FloatArray

CLEARANCE_S = 0.0015
"""Kept free around an impact, whose instant is known to about a millisecond before the flights are fitted."""
START_CLEARANCE_S = 0.02
"""Kept free after the start of the motion: the release is not a clean cut."""
LEAST_FLIGHT_S = 0.012


@dataclass(frozen=True, slots=True)
class Flight:
    """A stretch of free flight, begin_s to end_s."""

    begin_s: float
    end_s: float

    @property
    def duration_s(self) -> float:
        """Length of the stretch."""
        return self.end_s - self.begin_s


def find_flights(
    motion_begin_s: float, motion_end_s: float, impact_s: FloatArray, rising_m_s: float, g_m_s2: float
) -> tuple[Flight | None, ...]:
    """Return the flight before each impact and the one after the last, None where it is too short to fit.

    Parameters
    ----------
    motion_begin_s, motion_end_s
        Span of the motion.
    impact_s
        Instants of impact in order, shape (n_impacts,).
    rising_m_s
        Speed after the last impact: the sphere is back on the floor 2 v / g later.
    g_m_s2
        Gravity.

    Returns
    -------
    tuple
        n_impacts + 1 flights.
    """
    begins = np.concatenate([[motion_begin_s + START_CLEARANCE_S], impact_s + CLEARANCE_S])
    landing = float(impact_s[-1]) + 2.0 * rising_m_s / g_m_s2 if impact_s.size else motion_end_s
    ends = np.concatenate([impact_s, [min(motion_end_s, landing)]]) - CLEARANCE_S
    flights = (Flight(float(begin), float(end)) for begin, end in zip(begins, ends, strict=True))
    return tuple(flight if flight.duration_s >= LEAST_FLIGHT_S else None for flight in flights)
