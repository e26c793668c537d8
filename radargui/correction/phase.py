"""Compute and unwrap the phase.

After a hole the phase begins anew, unless the motion tells how far it has turned.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise, zip_longest
from typing import TYPE_CHECKING

import numpy as np

from radargui.model.arrays import BoolArray, FloatArray, IntArray, runs_of

if TYPE_CHECKING:
    # loads what only one or two receivers need
    from radargui.signals.echo import Echo


def wrapped_phase(i: FloatArray, q: FloatArray) -> FloatArray:
    """Return arctan(Q / I) in all four quadrants, in rad, of the shape of I and Q (Rech & Huang 2019, eq. 1)."""
    return np.arctan2(q, i)


def unwrap(phase_rad: FloatArray) -> FloatArray:
    """Add multiples of 2 pi wherever phases, shape (n_receivers, n_samples), step by more than half a turn.

    A larger step between neighbours counts as a wrap, not as motion. NaN are passed over.
    """
    out = phase_rad.copy()
    for row in out:
        # from before a hole to behind it the shorter way is taken; what else it may be `join_pieces` decides
        known = np.isfinite(row)
        if known.all():
            _unwrap(row)
        else:
            row[known] = _unwrap(row[known])
    return out


def _unwrap(phase_rad: FloatArray) -> FloatArray:
    """Unwrap phases (n,) in place: numpy's `unwrap` looks at every sample several times, wraps are few."""
    step = np.diff(phase_rad)
    wrap = np.flatnonzero(np.abs(step) > np.pi)
    turned = 2.0 * np.pi * np.cumsum(np.rint(step[wrap] / (2.0 * np.pi)))
    phase_rad[1:] -= np.repeat(np.append(0.0, turned), np.diff(wrap, prepend=0, append=step.size))
    return phase_rad


@dataclass(frozen=True, slots=True)
class HoleSettings:
    """When the phase is carried over a hole. Chosen by hand, `hole_s` to `side_s` on loose contacts (decision 46).

    Attributes
    ----------
    min_samples
        Least number of samples that determine a speed.
    hole_s, times_step, side_s
        Where an estimate knows what moves, a hole is longer than `hole_s` and than `times_step` typical steps: in less,
        half a turn would take 3 m/s of path. The speed is taken from `side_s` before and after it: a fall bends that by
        a tenth of a turn.
    slope_s, longest_s, max_u_rad
        Of one receiver by itself: time from which the speed is taken; the longest hole that is bridged; and the largest
        standard uncertainty of the phase carried over: twice it is a quarter of a wavelength of path.
    """

    min_samples: int = 4
    hole_s: float = 0.002
    times_step: float = 4.0
    side_s: float = 0.008
    slope_s: float = 0.004
    longest_s: float = 0.006
    max_u_rad: float = 0.25 * np.pi


SETTINGS = HoleSettings()


def unwrapped(angle_rad: FloatArray, time_s: FloatArray) -> FloatArray:
    """Return angles, shape (..., n), without steps of more than half a turn at times (n,), counted over holes."""
    # neighbours turn by less than half a turn, but not the two sides of a hole
    phase, step_s = np.unwrap(angle_rad, axis=-1), np.diff(time_s)
    longest_s = max(SETTINGS.hole_s, SETTINGS.times_step * float(np.median(step_s))) if step_s.size else np.inf
    for last in np.flatnonzero(step_s > longest_s):
        before = slice(int(np.searchsorted(time_s, time_s[last] - SETTINGS.side_s)), int(last) + 1)
        after = slice(int(last) + 1, int(np.searchsorted(time_s, time_s[last + 1] + SETTINGS.side_s)))
        if min(before.stop - before.start, after.stop - after.start) >= SETTINGS.min_samples:
            missed, _ = _missed(time_s[before], phase[..., before], time_s[after], phase[..., after])
            # whole turns alone: the fraction was measured on both sides
            phase[..., last + 1 :] += 2.0 * np.pi * np.rint(missed / (2.0 * np.pi))[..., None]
    return phase


def join_pieces(
    phase_rad: FloatArray, valid: BoolArray, sample_rate_hz: float, echoes: Sequence[Echo | None] = ()
) -> tuple[FloatArray, IntArray]:
    """Return the phases and the number of the piece of each sample, shapes (n_receivers, n_samples) and (n_samples,).

    Where the turn over a hole is uncertain by less than a quarter the phase goes on; else a new piece begins, for all
    receivers.

    Parameters
    ----------
    phase_rad
        Continuous within runs of valid samples, shape (n_receivers, n_samples).
    valid
        Same shape.
    sample_rate_hz
        Rate of the samples.
    echoes
        Echoes of the receivers, where they are known. The phase is carried over a hole only where the echo goes on,
        because otherwise the hole is a slip of the phase.
    """
    out = phase_rad.copy()
    begins = np.zeros(phase_rad.shape[1], dtype=np.intp)
    for row, good, echo in zip_longest(out, valid, echoes[: len(out)]):
        runs = [(a, b) for a, b in runs_of(good).tolist() if b - a >= SETTINGS.min_samples]
        for before, after in pairwise(runs):
            # longer holes are where an echo was lost: there it may have turned round
            short = after[0] - before[1] < SETTINGS.longest_s * sample_rate_hz
            away = np.nan
            if echo is None:
                away = _carried(row, before, after, sample_rate_hz)
            elif short and echo.leads[before[1] - 1 : after[0] + 1].all():
                turn = float(echo.phase_rad[after[0]] - echo.phase_rad[before[1] - 1])
                away = row[before[1] - 1] + turn - row[after[0]]
            turns = 2.0 * np.pi * np.round(away / (2.0 * np.pi))
            # speeds tell whole turns alone; against an echo what is left over is a slip; an unknown turn is neither
            if abs(away - turns) <= (np.inf if echo is None else SETTINGS.max_u_rad):
                row[after[0] :] += turns
            else:
                begins[after[0]] = 1
    return out, np.cumsum(begins)


def _carried(phase: FloatArray, before: tuple[int, int], after: tuple[int, int], rate_hz: float) -> float:
    """Return what the phase misses over a hole; NaN where the motion does not determine it."""
    if after[0] - before[1] + 1 > SETTINGS.longest_s * rate_hz:
        return np.nan
    reach = max(SETTINGS.min_samples, round(SETTINGS.slope_s * rate_hz))
    left = np.arange(max(before[0], before[1] - reach), before[1])
    right = np.arange(after[0], min(after[1], after[0] + reach))
    missed, u = _missed(left, phase[left], right, phase[right])
    return float(missed) if u < SETTINGS.max_u_rad else np.nan


def _missed(
    before_s: FloatArray | IntArray, before: FloatArray, after_s: FloatArray | IntArray, after: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return what phases (..., n) miss over a hole, and its standard uncertainty, shapes (...).

    Over a hole of d between angular speeds a and b the phase turns by (a + b) d / 2: exact under any even acceleration,
    an impact excepted. It is uncertain by |a - b| d / 4, for it may have had either speed all the way, and by the
    speeds' own uncertainty.
    """
    (begin, slow, u_slow), (end, fast, u_fast) = _line(before_s, before, -1), _line(after_s, after, 0)
    hole = after_s[0] - before_s[-1]
    u = hole * np.hypot(0.25 * np.abs(slow - fast), 0.5 * np.hypot(u_slow, u_fast))
    return np.asarray(begin + 0.5 * (slow + fast) * hole - end), np.asarray(u)


def _line(
    time_s: FloatArray | IntArray, phase_rad: FloatArray, place: int
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return value at one of the times, slope and its standard uncertainty of lines through phases, shapes (...)."""
    # one sample beside a hole would add its noise to the turn
    away, mean = time_s - time_s.mean(), phase_rad.mean(axis=-1)
    slope = (phase_rad @ away) / (away @ away)
    left = phase_rad - mean[..., None] - slope[..., None] * away
    u_slope = np.sqrt((left**2).sum(axis=-1) / max(away.size - 2, 1) / (away @ away))
    return mean + slope * away[place], slope, u_slope
