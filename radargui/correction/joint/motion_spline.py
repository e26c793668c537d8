"""The motion as a cubic B-spline that may change its velocity at breaks."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.interpolate import BSpline
from scipy.sparse import csr_matrix

from radargui.model.arrays import FloatArray

_KNOT_SPACING_S = 0.010
_DIFFERENCE_S = 2e-6


@dataclass(frozen=True, slots=True)
class MotionSpline:
    """p(t) - p(start) = B(t) c with triple knots at breaks: position continuous, velocity free to jump.

    The first coefficient is left out: the motion starts at the release position.

    Attributes
    ----------
    edge_s
        Start, breaks, end, shape (n_breaks + 2,).
    fractions
        Knots between neighbouring edges as shares of their distance, from 0 to 1: they move with the breaks.
    """

    edge_s: FloatArray
    fractions: tuple[FloatArray, ...]

    @property
    def spans(self) -> tuple[int, ...]:
        """Number of knot spans between neighbouring edges."""
        return tuple(share.size - 1 for share in self.fractions)

    @property
    def size(self) -> int:
        """Number of coefficients per coordinate."""
        return int(sum(self.spans) + 2 * (len(self.spans) - 1) + 2)

    @property
    def break_s(self) -> FloatArray:
        """Times of the breaks, shape (n_breaks,)."""
        return self.edge_s[1:-1]

    def knots(self) -> FloatArray:
        """Return the knots with multiplicities 4, 3, ..., 3, 4."""
        parts = [np.repeat(self.edge_s[0], 3)]
        for first, last, share in zip(self.edge_s[:-1], self.edge_s[1:], self.fractions, strict=True):
            parts += [first + (last - first) * share[:-1], np.repeat(last, 2)]
        return np.concatenate([*parts, np.repeat(self.edge_s[-1], 2)])

    def design(self, time_s: FloatArray) -> csr_matrix:
        """Return B at times, shape (n, size); rows before the start are zero, after the end constant."""
        clipped = np.clip(time_s, self.edge_s[0], self.edge_s[-1])
        matrix = BSpline.design_matrix(clipped, self.knots(), 3)
        return csr_matrix(matrix[:, 1:])

    def with_breaks(self, break_s: FloatArray) -> MotionSpline:
        """Return the spline with its breaks moved."""
        return MotionSpline(np.concatenate([self.edge_s[:1], break_s, self.edge_s[-1:]]), self.fractions)

    def break_slopes(self, time_s: FloatArray, coefficients: FloatArray) -> FloatArray:
        """Return dp/dtau of each break at fixed coefficients, shape (n_breaks, n, 3), by central differences."""
        out = np.zeros((self.break_s.size, time_s.size, coefficients.shape[1]))
        for k, moment in enumerate(self.break_s):
            near = (time_s > self.edge_s[k]) & (time_s < self.edge_s[k + 2])
            value = []
            for sign in (1.0, -1.0):
                moved = self.break_s.copy()
                moved[k] = moment + sign * _DIFFERENCE_S
                value.append(self.with_breaks(moved).design(time_s[near]) @ coefficients)
            out[k, near] = (value[0] - value[1]) / (2.0 * _DIFFERENCE_S)
        return out

    def jerk(self) -> tuple[csr_matrix, FloatArray, FloatArray]:
        """Return the matrix of the third derivative in each span, the spans' middles, and their lengths.

        A cubic's third derivative is its third difference at four even points over h^3.
        """
        shares = zip(self.edge_s[:-1], self.edge_s[1:], self.fractions, strict=True)
        edges = np.concatenate([*(a + (b - a) * share[:-1] for a, b, share in shares), self.edge_s[-1:]])
        length = np.diff(edges)
        h = length / 4.0
        rows = [self.design(edges[:-1] + (0.5 + k) * h) for k in range(4)]
        third = rows[3] - 3.0 * rows[2] + 3.0 * rows[1] - rows[0]
        return csr_matrix(third.multiply(1.0 / h[:, None] ** 3)), edges[:-1] + length / 2.0, length


def make_spline(start_s: float, end_s: float, break_s: FloatArray, sharp_s: FloatArray | None = None) -> MotionSpline:
    """Return a spline with knots about every 10 ms between start, breaks and end; 2.5 ms around `sharp_s`."""
    edge = np.concatenate([[start_s], break_s, [end_s]])
    sharp = np.zeros(0) if sharp_s is None else sharp_s
    fractions = []
    for first, last in pairwise(edge):
        count = max(1, int(np.ceil((last - first) / _KNOT_SPACING_S - 1e-9)))
        coarse = np.linspace(0.0, 1.0, count + 1)
        middle = first + (last - first) * (coarse[:-1] + coarse[1:]) / 2.0
        close = (np.abs(middle[:, None] - sharp[None]) < _KNOT_SPACING_S).any(axis=1)
        parts = [np.linspace(a, b, 5 if fine else 2)[:-1] for (a, b), fine in zip(pairwise(coarse), close, strict=True)]
        fractions.append(np.concatenate([*parts, [1.0]]))
    return MotionSpline(edge, tuple(fractions))
