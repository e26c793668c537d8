"""Kinks of a track: instants where the velocity along the upward direction jumps from down to up."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import minimum_filter1d, uniform_filter1d

from radargui.model.arrays import FloatArray, IntArray

_WINDOW_S = 0.010
_MEETING_WINDOW_S = 0.030
_SMALLEST_JUMP_M_S = 0.12
_SIGNIFICANT = 7.0
_APART_S = 0.013
_SMALLEST_SPEED_M_S = 0.04
_GRID_S, _SMOOTH_S, _TURN_S = 0.0005, 0.002, 0.008
_LEAST_DIP_M, _DIP_SIGNIFICANT = 1.5e-4, 6.0


def find_kinks(time_s: FloatArray, height_m: FloatArray, u_height_m: FloatArray) -> FloatArray:
    """Return the times of impacts seen in a height, shape (n_impacts,).

    Candidates are local minima; quadratics over 10 ms on either side give the velocities at the minimum. An impact
    comes down, goes up, and jumps by more than max(0.12 m/s, 7 standard deviations); its time is where the quadratics
    over up to 30 ms on either side meet.

    Parameters
    ----------
    time_s
        Shape (n,), increasing, not necessarily even.
    height_m
        Height along the upward direction, shape (n,); NaN where unknown.
    u_height_m
        Standard uncertainty of each height, shape (n,).
    """
    known = np.isfinite(height_m) & np.isfinite(u_height_m)
    time, height, u = time_s[known], height_m[known], u_height_m[known]
    if time.size < 8:
        return np.zeros(0)
    minima = _local_minima(time, height)
    found: list[tuple[float, float]] = []
    for index in minima:
        jump, size = _jump(time, height, u, float(time[index]))
        if size > 0:
            found.append((float(time[index]), jump))
    kept: list[float] = []
    for moment, _ in sorted(found, key=lambda pair: -pair[1]):
        if all(abs(moment - other) > _APART_S for other in kept):
            kept.append(moment)
    kept.sort()
    edges = [float(time[0]), *kept, float(time[-1])]
    return np.array(
        [
            _meeting(time, height, u, moment, before, after)
            for before, moment, after in zip(edges[:-2], edges[1:-1], edges[2:], strict=True)
        ]
    )


def find_turns(time_s: FloatArray, height_m: FloatArray, u_height_m: FloatArray) -> FloatArray:
    """Return the times of all sharp minima of a height: impacts and what may be one, shape (n_turns,).

    A minimum counts where the height, smoothed over 2 ms, rises by more than max(0.15 mm, 6 u) within 8 ms on both
    sides, which takes a curvature of half of gravity. Parameters as in `find_kinks`.
    """
    known = np.isfinite(height_m)
    grid = np.arange(time_s[known][0], time_s[known][-1], _GRID_S)
    width = max(1, round(_SMOOTH_S / _GRID_S))
    height = uniform_filter1d(np.interp(grid, time_s[known], height_m[known]), width, mode="nearest")
    reach, near = round(_TURN_S / _GRID_S), round(0.6 * _TURN_S / _GRID_S)
    least = max(_LEAST_DIP_M, _DIP_SIGNIFICANT * float(np.median(u_height_m)))
    found: list[float] = []
    lowest = np.flatnonzero(height <= minimum_filter1d(height, 2 * near + 1, mode="nearest"))
    for k in lowest[(lowest >= near) & (lowest < grid.size - near)]:
        if found and grid[k] - found[-1] < 0.6 * _TURN_S:
            continue
        left, right = height[max(0, k - reach) : k + 1].max(), height[k : k + reach + 1].max()
        if min(left, right) - height[k] > least:
            found.append(float(grid[k]))
    return np.array(found)


def _local_minima(time: FloatArray, height: FloatArray) -> IntArray:
    first = np.searchsorted(time, time - 0.006)
    last = np.searchsorted(time, time + 0.006, side="right")
    around = np.minimum.reduceat(np.append(height, np.inf), np.stack([first, last], axis=1).ravel())[::2]
    return np.flatnonzero(height <= around)


def _jump(time: FloatArray, height: FloatArray, u: FloatArray, moment: float) -> tuple[float, float]:
    """Return the jump of velocity in deviations beyond the threshold, and 1 if it is an impact, else 0."""
    best = (0.0, 0.0)
    for shift in (-0.002, -0.001, 0.0, 0.001, 0.002):
        at = moment + shift
        before = _one_sided(time, height, u, at - _WINDOW_S, at - 0.0003, at)
        after = _one_sided(time, height, u, at + 0.0003, at + _WINDOW_S, at)
        if before is None or after is None:
            continue
        jump, deviation = after[1] - before[1], float(np.hypot(after[3], before[3]))
        real = before[1] < -_SMALLEST_SPEED_M_S and after[1] > _SMALLEST_SPEED_M_S
        if real and jump > max(_SMALLEST_JUMP_M_S, _SIGNIFICANT * deviation) and jump / deviation > best[0]:
            best = (jump / deviation, 1.0)
    return best


def _one_sided(
    time: FloatArray, height: FloatArray, u: FloatArray, first: float, last: float, at: float
) -> tuple[float, float, float, float] | None:
    """Fit a quadratic on [first, last]; return height, velocity, curvature at `at`, and u of the velocity."""
    inside = slice(int(np.searchsorted(time, first)), int(np.searchsorted(time, last, side="right")))
    t = time[inside] - at
    if t.size < 4:
        return None
    weight = 1.0 / u[inside]
    columns = np.stack([np.ones_like(t), t, t**2], axis=1) * weight[:, None]
    normal = columns.T @ columns
    try:
        covariance = np.linalg.inv(normal)
    except np.linalg.LinAlgError:
        return None
    solution = covariance @ (columns.T @ (height[inside] * weight))
    misfit = float(((height[inside] * weight - columns @ solution) ** 2).sum()) / max(t.size - 3, 1)
    deviation = float(np.sqrt(max(covariance[1, 1], 0.0) * max(1.0, misfit)))
    return float(solution[0]), float(solution[1]), float(solution[2]), deviation


def _meeting(
    time: FloatArray, height: FloatArray, u: FloatArray, moment: float, before_s: float, after_s: float
) -> float:
    """Return where the quadratics before and after meet, near `moment`."""
    back = min(_MEETING_WINDOW_S, 0.9 * (moment - before_s))
    on = min(_MEETING_WINDOW_S, 0.9 * (after_s - moment))
    for _ in range(2):
        left = _one_sided(time, height, u, moment - back, moment - 0.0005, moment)
        right = _one_sided(time, height, u, moment + 0.0005, moment + on, moment)
        if left is None or right is None:
            return moment
        a, b, c = left[2] - right[2], left[1] - right[1], left[0] - right[0]
        root = b * b - 4.0 * a * c
        if root < 0.0:
            return moment
        shift = -2.0 * c / (b + np.copysign(np.sqrt(root), b))
        moment += float(np.clip(shift, -0.004, 0.004))
    return moment
