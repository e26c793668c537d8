"""Noise of path lengths that is correlated with the place, as residuals show it (method 5, Flights).

What a correction leaves is of reflections and front ends, and changes with the place: C = v (S exp(-|p - p'| / l) + w).
S = 1 within a flight and 0.8 between two, where the body comes by again and the error is nearly the same; w is white.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from radargui.model.arrays import FloatArray, IntArray

LENGTHS_M = (0.003, 0.01, 0.03, 0.1, 0.3)
"""l, from a tenth of a wavelength to the whole motion."""
SHARED = 0.8
"""Correlation of what is left at one place in two flights. Of 66 drops 0, 0.3, 0.5, 0.8 and 1 left 0.95 to 1 of the
first e inside 2u; u over error was nearest to each other for the three corrections at 0.8."""
WHITE = (1e-3, 1e-2, 0.1, 1.0, 10.0)
"""w, from waves to noise."""
LEAST_M = 1e-6
"""No path is known better: what a mean of it leaves of a flight."""
TURNS = 4
"""Of the variances, which the unknowns take a part of."""


class NoiseShape(NamedTuple):
    """Places of length and white share in their lists."""

    length: int = 2
    white: int = 2


@dataclass(frozen=True, eq=False)
class PathNoise:
    """Noise of paths.

    Attributes
    ----------
    shape
        How it is correlated, common to all receivers.
    variance
        v of each receiver, m^2, shape (n_receivers,).
    """

    shape: NoiseShape
    variance: FloatArray


class _Sums(NamedTuple):
    """rows^T C^-1 rows, rows^T C^-1 residual and residual^T C^-1 residual of one receiver, for v = 1."""

    matrix: FloatArray
    pull: FloatArray
    square: float


class NoiseModel:
    """Likelihood of residuals of path lengths.

    Parameters
    ----------
    position_m
        About where the body was, shape (3, n).
    flight
        In which flight, shape (n,).
    """

    def __init__(self, position_m: FloatArray, flight: IntArray) -> None:
        self._same = np.where(flight[:, None] == flight, 1.0, SHARED)
        square = (position_m**2).sum(axis=0)
        apart = square[:, None] + square - 2.0 * position_m.T @ position_m
        self._apart_m = np.sqrt(np.maximum(apart, 0.0))
        self._n = position_m.shape[1]
        self._factors: dict[NoiseShape, tuple[FloatArray, float]] = {}

    def chi_square(self, noise: PathNoise, residual_m: FloatArray) -> float:
        """Return r^T C^-1 r of residuals (n_receivers, n)."""
        none = np.zeros((*residual_m.shape, 0))
        each = self._sums(noise.shape, none, residual_m)
        return float(sum(one.square / v for one, v in zip(each, noise.variance, strict=True)))

    def normal(self, noise: PathNoise, slopes: FloatArray, residual_m: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return J^T C^-1 J, (k, k), and J^T C^-1 r, (k,), of derivatives (n_receivers, n, k) and residuals."""
        return _joined(self._sums(noise.shape, slopes, residual_m), noise.variance)

    def fitted(
        self,
        residual_m: FloatArray,
        slopes: FloatArray,
        precision: FloatArray,
        start: PathNoise | None,
        *,
        is_settled: bool,
    ) -> PathNoise:
        """Return the noise of greatest evidence, linear unknowns marginalised (REML; Patterson & Thompson 1971).

        Parameters
        ----------
        residual_m, slopes
            As above.
        precision
            Of the unknowns' priors, shape (k,).
        start
            Where the search over shapes begins; None: anywhere.
        is_settled
            Whether the shape stays, and only the variances are found anew.
        """
        variance = np.maximum((residual_m**2).mean(axis=1), LEAST_M**2) if start is None else start.variance
        shape = NoiseShape() if start is None else start.shape
        tried = {shape: self._of(shape, residual_m, slopes, precision, variance)}
        if is_settled:
            return PathNoise(shape, tried[shape][0])
        while True:
            near = [
                NoiseShape(a, b)
                for a, b in (
                    (shape.length - 1, shape.white),
                    (shape.length + 1, shape.white),
                    (shape.length, shape.white - 1),
                    (shape.length, shape.white + 1),
                )
                if 0 <= a < len(LENGTHS_M) and 0 <= b < len(WHITE)
            ]
            for other in near:
                if other not in tried:
                    tried[other] = self._of(other, residual_m, slopes, precision, tried[shape][0])
            best = max((shape, *near), key=lambda one: tried[one][1])
            if best == shape:
                return PathNoise(shape, tried[shape][0])
            shape = best

    def _of(
        self,
        shape: NoiseShape,
        residual_m: FloatArray,
        slopes: FloatArray,
        precision: FloatArray,
        variance: FloatArray,
    ) -> tuple[FloatArray, float]:
        """Return the likeliest variances of a shape, and ln of its evidence."""
        each = self._sums(shape, slopes, residual_m)
        for _ in range(TURNS):
            matrix, pull = _joined(each, variance)
            inverse = np.linalg.inv(matrix + np.diag(precision))
            off = inverse @ pull
            left = [one.square - 2.0 * one.pull @ off + off @ one.matrix @ off for one in each]
            # what the unknowns take of the n values: tr (J^T C^-1 J + P)^-1 J^T C_i^-1 J
            taken = [float((inverse * one.matrix).sum()) / v for one, v in zip(each, variance, strict=True)]
            variance = np.maximum(np.array(left) / np.maximum(self._n - np.array(taken), 1.0), LEAST_M**2)
        matrix, pull = _joined(each, variance)
        whole = matrix + np.diag(precision)
        value = pull @ np.linalg.solve(whole, pull) - np.linalg.slogdet(whole)[1]
        for one, v in zip(each, variance, strict=True):
            value -= one.square / v + self._n * np.log(v) + self._factor(shape)[1]
        return variance, 0.5 * float(value)

    def _sums(self, shape: NoiseShape, slopes: FloatArray, residual_m: FloatArray) -> list[_Sums]:
        white, _ = self._factor(shape)
        out = []
        for rows, own in zip(slopes, residual_m, strict=True):
            both = white @ np.column_stack([rows, own])
            sums = both.T @ both
            out.append(_Sums(sums[:-1, :-1], sums[:-1, -1], float(sums[-1, -1])))
        return out

    def _factor(self, shape: NoiseShape) -> tuple[FloatArray, float]:
        """Return what makes noise of v = 1 white, and ln det of its covariance."""
        if shape not in self._factors:
            covariance = np.exp(-self._apart_m / LENGTHS_M[shape.length]) * self._same
            covariance[np.diag_indices(self._n)] += WHITE[shape.white]
            root = np.linalg.cholesky(covariance)
            self._factors[shape] = np.linalg.inv(root), 2.0 * float(np.log(np.diag(root)).sum())
        return self._factors[shape]


def _joined(each: Sequence[_Sums], variance: FloatArray) -> tuple[FloatArray, FloatArray]:
    matrix = np.sum([one.matrix / v for one, v in zip(each, variance, strict=True)], axis=0)
    return matrix, np.sum([one.pull / v for one, v in zip(each, variance, strict=True)], axis=0)
