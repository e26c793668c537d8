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


if TYPE_CHECKING:
    # loads what only one or two receivers need
    from radargui.conditioning.echo import Echo


@dataclass(frozen=True, slots=True)
class PieceSettings:
    """When the phase is carried over a hole. Chosen by hand.

    Attributes
    ----------
    slope_s
        Time before and after the hole from which the speed is taken.
    longest_s
        A longer hole is never bridged.
    least_samples
        Least number of samples that determine a speed.
    most_u_rad
        Largest standard uncertainty of the phase carried over: twice it is a quarter of a wavelength of path.
    """

    slope_s: float = 0.004
    longest_s: float = 0.006
    least_samples: int = 4
    most_u_rad: float = 0.25 * np.pi


SETTINGS = PieceSettings()


def join_pieces(
    phase_rad: FloatArray, valid: BoolArray, sample_rate_hz: float, echoes: Sequence[Echo | None] = ()
) -> tuple[FloatArray, IntArray]:
    """Return the phases and the number of the piece of each sample, shapes (n_receivers, n_samples) and (n_samples,).

    Over a hole of d samples between speeds a and b the phase turns by (a + b) d / 2, uncertain by |a - b| d / 4 and by
    the speeds' own uncertainty. Where that is below a quarter of a turn the phase goes on; else a new piece begins,
    for all receivers.

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
        runs = [(a, b) for a, b in runs_of(good).tolist() if b - a >= SETTINGS.least_samples]
        for before, after in pairwise(runs):
            # longer holes are where an echo was lost: there it may have turned round
            short = after[0] - before[1] < SETTINGS.longest_s * sample_rate_hz
            if echo is None:
                turn = _carried(row, before, after, sample_rate_hz)
            elif short and echo.leads[before[1] - 1 : after[0] + 1].all():
                turn = float(echo.phase_rad[after[0]] - echo.phase_rad[before[1] - 1])
            else:
                turn = np.nan
            away = row[before[1] - 1] + turn - row[after[0]]
            turns = 2.0 * np.pi * np.round(away / (2.0 * np.pi))
            # speeds tell whole turns alone; against an echo what is left over is a slip; an unknown turn is neither
            if abs(away - turns) <= (np.inf if echo is None else SETTINGS.most_u_rad):
                row[after[0] :] += turns
            else:
                begins[after[0]] = 1
    return out, np.cumsum(begins)


def _carried(phase: FloatArray, before: tuple[int, int], after: tuple[int, int], rate_hz: float) -> float:
    """Return by how much the phase turns over a hole; NaN where the motion does not determine it."""
    hole = after[0] - before[1] + 1
    if hole > SETTINGS.longest_s * rate_hz:
        return np.nan
    reach = max(SETTINGS.least_samples, round(SETTINGS.slope_s * rate_hz))
    slope_a, u_a = _slope(phase[max(before[0], before[1] - reach) : before[1]])
    slope_b, u_b = _slope(phase[after[0] : min(after[1], after[0] + reach)])
    # between the speeds at both ends it may have been either all the way
    u = np.hypot(0.25 * abs(slope_a - slope_b) * hole, 0.5 * hole * np.hypot(u_a, u_b))
    return 0.5 * (slope_a + slope_b) * hole if u < SETTINGS.most_u_rad else np.nan


def _slope(phase: FloatArray) -> tuple[float, float]:
    """Return the slope of a line through phases at successive samples, and its standard uncertainty."""
    x = np.arange(phase.size) - 0.5 * (phase.size - 1)
    square = float(x @ x)
    slope = float(x @ phase) / square
    residual = phase - phase.mean() - slope * x
    return slope, float(np.sqrt(residual @ residual / max(phase.size - 2, 1) / square))
