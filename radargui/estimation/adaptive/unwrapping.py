"""Unwrap phases in time, and across holes by how fast they turn on both sides."""

from dataclasses import dataclass

import numpy as np

from radargui.model.arrays import FloatArray


@dataclass(frozen=True, slots=True)
class UnwrapSettings:
    """What counts as a hole, and where the speed beside it is measured. Chosen by hand on loose contacts (decision 46).

    Attributes
    ----------
    hole_s, times_step
        A hole is longer than `hole_s` and than `times_step` typical steps: in less, half a turn would take 3 m/s of
        path.
    side_s
        Time before and after a hole over which the phase is taken as a straight line: a fall bends it by a tenth of a
        turn.
    least_points
        Least number of points that determine a speed.
    """

    hole_s: float = 0.002
    times_step: float = 4.0
    side_s: float = 0.008
    least_points: int = 4


SETTINGS = UnwrapSettings()


def unwrapped(angle_rad: FloatArray, time_s: FloatArray) -> FloatArray:
    """Return angles, shape (..., n), without steps of more than half a turn at times (n,), counted over holes.

    Over a hole of d between angular speeds a and b, the phase turns by (a + b) d / 2: exact under any even
    acceleration, an impact excepted.
    """
    # neighbours turn by less than half a turn, but not the two sides of a hole
    phase = np.unwrap(angle_rad, axis=-1)
    step_s = np.diff(time_s)
    if not step_s.size:
        return phase
    holes = np.flatnonzero(step_s > max(SETTINGS.hole_s, SETTINGS.times_step * float(np.median(step_s))))
    for last in holes:
        before = slice(int(np.searchsorted(time_s, time_s[last] - SETTINGS.side_s)), int(last) + 1)
        after = slice(int(last) + 1, int(np.searchsorted(time_s, time_s[last + 1] + SETTINGS.side_s)))
        if min(before.stop - before.start, after.stop - after.start) < SETTINGS.least_points:
            continue
        # straight lines, for the two samples beside the hole alone would add their noise to the turn
        begin, slow = _line(time_s[before], phase[..., before], time_s[last])
        end, fast = _line(time_s[after], phase[..., after], time_s[last + 1])
        turned = (slow + fast) / 2.0 * step_s[last]
        # whole turns alone: the fraction was measured on both sides
        phase[..., last + 1 :] += 2.0 * np.pi * np.rint((begin + turned - end) / (2.0 * np.pi))[..., None]
    return phase


def _line(time_s: FloatArray, phase_rad: FloatArray, at_s: float) -> tuple[FloatArray, FloatArray]:
    """Return value at a time and slope of the straight lines through phases, shape (..., n)."""
    away = time_s - time_s.mean()
    slope = (phase_rad @ away) / (away @ away)
    return phase_rad.mean(axis=-1) + slope * (at_s - time_s.mean()), slope
