"""Estimate what bounces that are not followed leave uncertain of the speeds at the last impacts."""

from __future__ import annotations

import math

import numpy as np

from radargui.estimation.posterior.free_motion import FreeMotion
from radargui.estimation.solve.break_velocities import LIMITS
from radargui.model.arrays import BoolArray, FloatArray

_LATE, _STEP_S = 1.5, 5e-4
"""Of the flight that a speed makes, so many times as long are looked at, in steps of so much."""
_DOWN = 0.5
"""Share of its height that a flight may end above where it began: the spline rounds the corner."""


def unfollowed_m_s(
    time_s: FloatArray,
    before_m_s: FloatArray,
    after_m_s: FloatArray,
    by_flights: BoolArray,
    g_m_s2: float,
    end_s: float,
    lands_s: float = math.nan,
) -> tuple[FloatArray, FloatArray]:
    """Return the further uncertainty of the speeds before and after each impact, (n_impacts,) each.

    A cascade continues below what is followed. If the flight after the last impact, of duration T = 2 v / g, is too
    short for the knots, its landing is unknown. The motion there is then uncertain by the height h of the following
    bounce, h / sqrt 12 for any place in it, and the slope by that over T; below two knot spacings, by the height of the
    flight itself. Bounces that are not followed also shift the instant of the last impact. A speed from the slope of
    the motion is therefore uncertain by its difference from the speed that gravity gives: before the impact g T less
    the speed at the start of the flight, after it that of a flight to where the motion comes down again.

    Parameters
    ----------
    time_s, before_m_s, after_m_s
        Of the impacts, shape (n_impacts,); speeds along the normal, both positive.
    by_flights
        Impacts whose speeds come from fitted flights, which obey gravity already, shape (n_impacts,).
    g_m_s2
        Along the normal.
    end_s
        End of the record: a flight that would land later is not cut short.
    lands_s
        When the motion comes down after the last impact, see `lands_after_s`.
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
        if flight_s >= 2.0 * LIMITS.min_flight_s:
            next_m_s *= min(float(np.median(after_m_s / before_m_s)), 1.0)
        after[-1] = next_m_s**2 / (2.0 * g_m_s2) / np.sqrt(12.0) / flight_s
    if not by_flights[-1] and math.isfinite(lands_s):
        after[-1] = np.hypot(after[-1], speed - g_m_s2 * (lands_s - float(time_s[-1])) / 2.0)
    return before, after


def lands_after_s(free: FreeMotion, normal: FloatArray, impact_s: float, speed_m_s: float) -> float:
    """Return when a motion comes down to the height at which it left the floor; NaN if not within 1.5 times its flight.

    Parameters
    ----------
    free
        The motion.
    normal
        Of the floor, shape (3,).
    impact_s, speed_m_s
        Where it left, and how fast.
    """
    flight_s = 2.0 * speed_m_s / free.gravity_m_s2
    time_s = impact_s + np.arange(0.0, _LATE * flight_s, _STEP_S)
    if time_s.size < 3 or time_s[-1] > free.edge_s[-1]:
        return math.nan
    height = normal @ free.position_m(time_s)
    top = int(np.argmax(height))
    low = top + int(np.argmin(height[top:]))
    # a ripple on the way down is no landing, nor is the end of what is looked at
    is_down = height[low] - height[0] < _DOWN * (height[top] - height[0])
    turns = low < time_s.size - 1 and time_s[low] - impact_s > LIMITS.min_flight_s
    return float(time_s[low]) if is_down and turns else math.nan
