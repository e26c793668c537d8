"""Parabolas through flights, gravity shared or free: which stretches are flights, and how high they rise.

Method 5, Flights.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from radargui.model.arrays import FloatArray
from radargui.restitution.stretches import Stretches


@dataclass(frozen=True, slots=True)
class Parabolas:
    """h_k(t) = h0_k + v0_k (t - t0_k) - g (t - t0_k)^2 / 2 for flights k = 1 ... n.

    Attributes
    ----------
    origin_s
        t0_k, shape (n_flights,).
    height_m, speed_m_s
        h0_k and v0_k, shape (..., n_flights), one set of them for each set of heights.
    g_m_s2
        Deceleration along the height, shared, shape (...).
    """

    origin_s: FloatArray
    height_m: FloatArray
    speed_m_s: FloatArray
    g_m_s2: FloatArray


def solve_parabolas(flights: Stretches, height_m: FloatArray, *, shared: bool = True) -> Parabolas:
    """Fit one parabola a flight with g shared, or each its own, by least squares.

    Parameters
    ----------
    flights
        At least four samples each.
    height_m
        At their samples, shape (..., n_samples).
    shared
        Whether all have one g.
    """
    # with a g given h0 and v0 are means, so that g is solved for alone
    d, (square, cube, fourth) = flights.away_s, _moments(flights)
    moved = height_m * d
    level, slope = flights.sums(height_m) / flights.count, flights.sums(moved) / square
    # of what falls by d^2 / 2: the same level and slope, what is left of it, and the height's product with that
    fallen, steeper = 0.5 * square / flights.count, 0.5 * cube / square
    left = 0.25 * fourth - 0.5 * (fallen * square + steeper * cube)
    pull = fallen * flights.count * level + steeper * square * slope - 0.5 * flights.sums(moved * d)
    if shared:
        left, pull = left.sum(), pull.sum(axis=-1, keepdims=True)
    g = pull / left
    return Parabolas(flights.origin_s, level + fallen * g, slope + steeper * g, g[..., 0] if shared else g)


def residuals(flights: Stretches, height_m: FloatArray, parabolas: Parabolas) -> FloatArray:
    """Return heights (n_samples,) less parabolas with one g or each its own, same shape."""
    own = np.broadcast_arrays(parabolas.height_m, parabolas.speed_m_s, parabolas.g_m_s2)
    d, (level, slope, g) = flights.away_s, (flights.spread(part) for part in own)
    return np.asarray(height_m - level - slope * d + 0.5 * g * d * d)


def misfits_m(flights: Stretches, height_m: FloatArray) -> FloatArray:
    """Return the root mean square by which each flight misses a parabola of its own, shape (n_flights,)."""
    each = solve_parabolas(flights, height_m, shared=False)
    return np.asarray(np.sqrt(flights.means(residuals(flights, height_m, each) ** 2)))


def _moments(flights: Stretches) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the sums of the second, third and fourth powers of the times, whose first ones add up to nothing."""
    d = flights.away_s
    square = d * d
    return flights.sums(square), flights.sums(square * d), flights.sums(square * square)
