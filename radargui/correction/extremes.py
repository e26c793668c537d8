"""Find the extremes of a wave that exceed its noise, and draw the cubic spline through them."""

from __future__ import annotations

import numpy as np

from radargui.model.arrays import BoolArray, FloatArray, IntArray


def turning_points(x: FloatArray) -> tuple[IntArray, BoolArray]:
    """Return the local extremes of a curve (n,) in order, a plateau's in its middle, and which are maxima."""
    step = np.diff(x)
    moving = np.flatnonzero(step)
    rising = step[moving] > 0.0
    turn = np.flatnonzero(rising[1:] != rising[:-1])
    # from the first sample of a plateau to its last
    return (moving[turn] + 1 + moving[turn + 1]) // 2, rising[turn]


def prominent(x: FloatArray, place: IntArray, least: FloatArray | float) -> IntArray:
    """Return which extremes have a prominence above their limit, in order.

    Two neighbouring extremes that differ by less are a wiggle. The smallest wiggles are removed first, until none is
    left. Towards an end of the curve an extreme must exceed what lies before the end.

    Parameters
    ----------
    x
        The curve, shape (n,).
    place
        All its turning points, shape (m,).
    least
        Least prominence of each, shape (m,) or one for all.

    Returns
    -------
    IntArray
        Numbers of the turning points.
    """
    # with both ends, which are never taken out
    number = np.arange(-1, place.size + 1)
    value = np.concatenate([x[:1], x[place], x[-1:]])
    enough = np.zeros(number.size)
    enough[1:-1] = least
    while True:
        swing = np.abs(value[1:] - value[:-1])
        small = np.flatnonzero(swing < np.minimum(enough[1:], enough[:-1]))
        first = small[(swing[small] <= swing[small - 1]) & (swing[small] < swing[small + 1])]
        if first.size == 0:
            break
        keep = np.ones(number.size, dtype=np.bool_)
        keep[first] = keep[first + 1] = False
        number, value, enough = number[keep], value[keep], enough[keep]
    # at an end, or where its neighbour needs less, what an extreme stands out of lies farther away
    keep = np.asarray(np.minimum(swing[:-1], swing[1:]) >= enough[1:-1])
    values = value.tolist()
    for k in np.flatnonzero(~keep):
        keep[k] = _prominence(values, int(k) + 1) >= enough[k + 1]
    return np.asarray(number[1:-1][keep])


def _prominence(value: list[float], at: int) -> float:
    """Return the prominence of an extreme; each side reaches to what exceeds it, or to the end."""
    sign = 1.0 if value[at] >= value[at - 1] else -1.0
    own, out = sign * value[at], float("inf")
    for side in (range(at - 1, -1, -1), range(at + 1, len(value))):
        lowest = own
        for place in side:
            one = sign * value[place]
            if one > own:
                break
            lowest = min(lowest, one)
        out = min(out, own - lowest)
    return out


def spline_through(place: IntArray, value: FloatArray) -> FloatArray:
    """Return the cubic spline through values (n,) at sample numbers, at every sample from the first to the last.

    Not-a-knot at both ends (de Boor 1978, ch. IV); four values at least.
    """
    dx = np.diff(place).astype(np.float64)
    mean = np.diff(value) / dx
    slope = _slopes(dx, mean)
    bend = (slope[:-1] + slope[1:] - 2.0 * mean) / dx
    # of each piece, in powers of the distance from its beginning
    powers = np.stack([value[:-1], slope[:-1], (mean - slope[:-1]) / dx - bend, bend / dx])
    count = np.diff(place)
    level, linear, square, cube = np.repeat(powers, count, axis=1)
    away = np.arange(place[0], place[-1]) - np.repeat(place[:-1], count)
    return np.append(level + away * (linear + away * (square + away * cube)), value[-1])


def _slopes(dx: FloatArray, mean: FloatArray) -> FloatArray:
    """Return the slopes at the knots from the distances and mean slopes of the pieces between them."""
    n = dx.size + 1
    # dx_i s_(i-1) + 2 (dx_(i-1) + dx_i) s_i + dx_(i-1) s_(i+1) = 3 (dx_i m_(i-1) + dx_(i-1) m_i)
    lower, middle, upper, right = (np.empty(n) for _ in range(4))
    lower[1:-1], middle[1:-1], upper[1:-1] = dx[1:], 2.0 * (dx[:-1] + dx[1:]), dx[:-1]
    right[1:-1] = 3.0 * (dx[1:] * mean[:-1] + dx[:-1] * mean[1:])
    begin, end = dx[0] + dx[1], dx[-1] + dx[-2]
    middle[0], upper[0], lower[-1], middle[-1] = dx[1], begin, end, dx[-2]
    right[0] = ((dx[0] + 2.0 * begin) * dx[1] * mean[0] + dx[0] ** 2 * mean[1]) / begin
    right[-1] = (dx[-1] ** 2 * mean[-2] + (2.0 * end + dx[-1]) * dx[-2] * mean[-1]) / end
    a, b, c, d = (row.tolist() for row in (lower, middle, upper, right))
    for k in range(1, n):
        share = a[k] / b[k - 1]
        b[k] -= share * c[k - 1]
        d[k] -= share * d[k - 1]
    d[-1] /= b[-1]
    for k in range(n - 2, -1, -1):
        d[k] = (d[k] - c[k] * d[k + 1]) / b[k]
    return np.array(d)
