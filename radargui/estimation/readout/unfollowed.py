"""What bounces that are not followed leave open of the speeds at impacts.

Method 5, e and the floor's normal.
"""

from __future__ import annotations

import numpy as np

from radargui.estimation.solve.break_velocities import LIMITS
from radargui.model.arrays import BoolArray, FloatArray


def unfollowed_m_s(
    time_s: FloatArray,
    before_m_s: FloatArray,
    after_m_s: FloatArray,
    by_flights: BoolArray,
    g_m_s2: float,
    end_s: float,
) -> tuple[FloatArray, FloatArray]:
    """Return what stays open of the speeds before and after each impact, (n_impacts,) each, beside their covariance.

    A cascade goes on below what is followed. Where the flight after the last impact, of the duration T = 2 v / g, is
    shorter than the knots follow, nothing says when it lands: the motion there is off by up to the height h of the
    bounce after it, h / sqrt 12 of any place in it, and the slope by as much over T; below two knot spacings of the
    motion, by that of the flight itself. And what is not followed draws the
    last impact's instant away: a speed from the motion's slope is off by what gravity makes of the flight before it
    otherwise, g T less the speed that it left with.

    Parameters
    ----------
    time_s, before_m_s, after_m_s
        Of the impacts, shape (n_impacts,); speeds along the normal, both positive.
    by_flights
        At which fitted flights tell the speeds, shape (n_impacts,): gravity holds those already.
    g_m_s2
        Along the normal.
    end_s
        Of the record: what would land later is not cut short.
    """
    before, after = np.zeros(time_s.size), np.zeros(time_s.size)
    if not time_s.size:
        return before, after
    left = after_m_s[:-1]
    arrives = g_m_s2 * np.diff(time_s) - left
    # what lay or was carried since, or fell deeper, arrives otherwise
    same_floor = np.abs(arrives - left) < left
    before[1:] = np.where(same_floor & ~by_flights[1:], np.abs(before_m_s[1:] - arrives), 0.0)
    speed = float(after_m_s[-1])
    flight_s = 2.0 * speed / g_m_s2
    if 0.0 < flight_s < LIMITS.unfollowed_s and time_s[-1] + flight_s < end_s:
        next_m_s = speed
        # of two knot spacings the flight itself is followed; the next one keeps the share that impacts kept so far
        if flight_s >= 2.0 * LIMITS.least_flight_s:
            next_m_s *= min(float(np.median(after_m_s / before_m_s)), 1.0)
        after[-1] = next_m_s**2 / (2.0 * g_m_s2) / np.sqrt(12.0) / flight_s
    return before, after
