"""Parabolas through flights, gravity shared or free, with uncertainties that know of correlated residuals.

Method 5, Flights.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from radargui.model.arrays import BoolArray, FloatArray, IntArray
from radargui.restitution.settings import TRACKS
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

    def height_at(self, flight: int | IntArray, time_s: float | FloatArray) -> FloatArray:
        """Return the height of flights' parabolas at instants, shape (...) or (..., n) for n of both."""
        d = time_s - self.origin_s[flight]
        return np.asarray(self.height_m[..., flight] + self.speed_m_s[..., flight] * d - 0.5 * self._g(flight) * d * d)

    def speed_at(self, flight: int | IntArray, time_s: float | FloatArray) -> FloatArray:
        """Return the speed of flights' parabolas at instants, shape as for `height_at`."""
        return np.asarray(self.speed_m_s[..., flight] - self._g(flight) * (time_s - self.origin_s[flight]))

    def chosen(self, which: BoolArray) -> Parabolas:
        """Return some of the flights, `which` of shape (n_flights,)."""
        return Parabolas(self.origin_s[which], self.height_m[..., which], self.speed_m_s[..., which], self.g_m_s2)

    def _g(self, flight: int | IntArray) -> FloatArray:
        return self.g_m_s2 if np.ndim(flight) == 0 else self.g_m_s2[..., None]


@dataclass(frozen=True, slots=True)
class FittedParabolas:
    """Parabolas with their uncertainty.

    Attributes
    ----------
    parabolas
        Of one set of heights.
    covariance
        Of (h0_1, v0_1, h0_2, ..., v0_n, g), shape (2 n + 1, 2 n + 1).
    residual_rms_m
        Root mean square of the residuals.
    """

    parabolas: Parabolas
    covariance: FloatArray
    residual_rms_m: float

    @property
    def g_m_s2(self) -> float:
        """Deceleration along the height."""
        return float(self.parabolas.g_m_s2)

    @property
    def u_g_m_s2(self) -> float:
        """Standard uncertainty of g."""
        return float(np.sqrt(self.covariance[-1, -1]))


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


def fit_parabolas(flights: Stretches, height_m: FloatArray) -> FittedParabolas:
    """Fit one parabola a flight with g shared, by least squares, with its covariance.

    That is the covariance of white residuals of the observed size, times their correlation length in samples and
    widened where they are not white (each flight its own): residuals of a mismatch are waves, not noise.

    Parameters
    ----------
    flights, height_m
        As for `solve_parabolas`, heights of shape (n_samples,).
    """
    blocks, solved = _blocks(flights), solve_parabolas(flights, height_m)
    inverse = _inverse(_joined(blocks))
    own = residuals(flights, height_m, solved)
    # sandwich A^-1 B A^-1: each flight has residuals of its own size (White 1980)
    meat = _joined(residual_variances(flights, own)[:, None, None] * blocks)
    return FittedParabolas(solved, inverse @ meat @ inverse, float(np.sqrt(np.mean(own**2))))


def residual_variances(flights: Stretches, own: FloatArray) -> FloatArray:
    """Return the variance of a sample of each flight, were they independent, by residuals (n_samples,)."""
    # two parameters of its own and its share of g
    freedom = np.maximum(1.0, flights.count - 2.0 - 1.0 / flights.size)
    # as many independent samples as there are correlation lengths (GUM 4.2.7)
    variance = flights.sums(own**2) / freedom * flights.correlation_lengths(own)
    return np.asarray(variance * flights.misfit_widenings(own, TRACKS.hidden_waves))


def residuals(flights: Stretches, height_m: FloatArray, parabolas: Parabolas) -> FloatArray:
    """Return heights (n_samples,) less parabolas with one g or each its own, same shape."""
    own = np.broadcast_arrays(parabolas.height_m, parabolas.speed_m_s, parabolas.g_m_s2)
    d, (level, slope, g) = flights.away_s, (flights.spread(part) for part in own)
    return np.asarray(height_m - level - slope * d + 0.5 * g * d * d)


def misfits_m(flights: Stretches, height_m: FloatArray) -> FloatArray:
    """Return the root mean square by which each flight misses a parabola of its own, shape (n_flights,)."""
    each = solve_parabolas(flights, height_m, shared=False)
    return np.asarray(np.sqrt(flights.means(residuals(flights, height_m, each) ** 2)))


def _blocks(flights: Stretches) -> FloatArray:
    """Return each flight's normal matrix of (h0, v0, g), shape (n_flights, 3, 3)."""
    # about the middle of each flight: there height and speed are uncorrelated
    square, cube, fourth = _moments(flights)
    out = np.zeros((flights.size, 3, 3))
    out[:, 0, 0], out[:, 1, 1], out[:, 2, 2] = flights.count, square, 0.25 * fourth
    out[:, 0, 2] = out[:, 2, 0] = -0.5 * square
    out[:, 1, 2] = out[:, 2, 1] = -0.5 * cube
    return out


def _moments(flights: Stretches) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the sums of the second, third and fourth powers of the times, whose first ones add up to nothing."""
    d = flights.away_s
    square = d * d
    return flights.sums(square), flights.sums(square * d), flights.sums(square * square)


def _joined(blocks: FloatArray) -> FloatArray:
    """Return blocks of (h0, v0, g) as one matrix of (h0_1, v0_1, h0_2, ..., v0_n, g), shape (2 n + 1, 2 n + 1)."""
    n = blocks.shape[0]
    out = np.zeros((2 * n + 1, 2 * n + 1))
    at = 2 * np.arange(n)
    for row in range(2):
        for column in range(2):
            out[at + row, at + column] = blocks[:, row, column]
        out[at + row, -1] = out[-1, at + row] = blocks[:, row, 2]
    out[-1, -1] = blocks[:, 2, 2].sum()
    return out


def _inverse(normal: FloatArray) -> FloatArray:
    """Return the inverse of a normal matrix (m, m)."""
    # metres, speeds and g in units of what their columns weigh: the equations are then as good as orthogonal ones
    size = np.sqrt(np.diagonal(normal))
    unit = np.outer(size, size)
    return np.asarray(np.linalg.inv(normal / unit) / unit)
