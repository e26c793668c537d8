"""Impacts: instants at which the height turns from falling to rising at once."""

from __future__ import annotations

import numpy as np
from scipy.signal import find_peaks

from radargui.model.arrays import BoolArray, FloatArray, IntArray

STEP_S = 0.0005
SIDE_S = 0.010
"""One-sided window of the parabolas whose slopes are compared."""
LEAST_JUMP_M_S = 0.12
LEAST_SPEED_M_S = 0.03
SIGMAS = 7.0
APART_S = 0.013
WAVES = 3.0
G_M_S2 = 9.81
MARGIN = 0.5


def find_impacts(time_s: FloatArray, height_m: FloatArray, valid: BoolArray, sample_rate_hz: float) -> FloatArray:
    """Find the impacts of a track.

    At every instant the slope of a parabola through the 10 ms before is held against that of one through the 10 ms
    after. An impact falls before, rises after and jumps by more than 0.12 m/s and seven standard deviations; an apex
    or a smooth turn-round does not jump, a stop in a granular bed does not rise.

    Parameters
    ----------
    time_s
        Shape (n_samples,).
    height_m
        Height along the floor's normal, shape (n_samples,); NaN where unknown.
    valid
        Shape (n_samples,).
    sample_rate_hz
        Rate of the samples.

    Returns
    -------
    FloatArray
        Times in s, shape (n_impacts,), in order; good to about a millisecond.
    """
    size = max(1, round(STEP_S * sample_rate_hz))
    count = height_m.size // size
    known = valid & np.isfinite(height_m)
    usable = np.asarray(known[: count * size].reshape(count, size).all(axis=1))
    side = max(4, round(SIDE_S * sample_rate_hz / size))
    if count < 2 * side + 3:
        return np.empty(0)
    step_s = size / sample_rate_hz
    filled = np.where(known, height_m, 0.0)[: count * size].reshape(count, size).mean(axis=1)
    kernel = end_slope_kernel(side) / step_s
    windows = np.lib.stride_tricks.sliding_window_view(filled, side)
    whole = np.asarray(np.lib.stride_tricks.sliding_window_view(usable, side).all(axis=1))
    before, after = windows[:-side] @ kernel, -(windows[side:, ::-1] @ kernel)
    complete = whole[:-side] & whole[side:]
    sigma = _slope_noise(filled, usable, kernel)
    jump = after - before
    least = max(LEAST_JUMP_M_S, SIGMAS * np.sqrt(2.0) * sigma, WAVES * _waves(jump[complete]))
    falls_then_rises = (before < -LEAST_SPEED_M_S) & (after > max(LEAST_SPEED_M_S, SIGMAS * sigma)) & complete
    candidates = np.where(falls_then_rises, jump, 0.0)
    found, _ = find_peaks(np.pad(candidates, 1), height=least, distance=max(1, round(APART_S / step_s)))
    found = _possible(found - 1, before, after, step_s)
    centre_s = time_s[0] + (found + side) * step_s - 0.5 / sample_rate_hz
    return np.asarray(centre_s, dtype=np.float64)


def _possible(found: IntArray, before: FloatArray, after: FloatArray, step_s: float) -> IntArray:
    """Return the impacts that can follow each other, the hardest first.

    A sphere that leaves the floor at v comes back after 2 v / g, and one that arrives at v has fallen for v / g: an
    impact much nearer to a harder one is a flaw of the correction.
    """
    kept: list[int] = []
    for index in sorted(found, key=lambda k: before[k] - after[k]):
        clear = True
        for other in kept:
            harder_first = other < index
            least_s = MARGIN * (2.0 * after[other] if harder_first else -before[other]) / G_M_S2
            clear = clear and abs(index - other) * step_s >= least_s
        if clear:
            kept.append(int(index))
    return np.asarray(sorted(kept), dtype=np.intp)


def _waves(jump_m_s: FloatArray) -> float:
    """Return the size of the jumps that a mismatch left in the track makes everywhere, not only at impacts."""
    if jump_m_s.size == 0:
        return 0.0
    return float(np.median(np.abs(jump_m_s - np.median(jump_m_s))) / 0.674489750196)


def end_slope_kernel(count: int) -> FloatArray:
    """Return weights w with slope at the end of a window = w @ values, for a least-squares parabola, per step."""
    x = np.arange(count) - count + 0.5
    return np.asarray(np.linalg.pinv(np.vander(x, 3, increasing=True))[1])


def _slope_noise(height_m: FloatArray, usable: BoolArray, kernel: FloatArray) -> float:
    """Return the standard deviation that white noise of the height gives a one-sided slope."""
    third = np.diff(height_m, 3)[np.lib.stride_tricks.sliding_window_view(usable, 4).all(axis=1)]
    if third.size == 0:
        return float("inf")
    noise = float(np.median(np.abs(third)) / (0.674489750196 * np.sqrt(20.0)))
    return noise * float(np.linalg.norm(kernel))
