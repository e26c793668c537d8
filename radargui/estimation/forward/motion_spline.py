"""The motion as a cubic B-spline that may change its velocity at breaks (method 4, SplineMotion)."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.interpolate import BSpline
from scipy.sparse import csr_matrix

from radargui.model.arrays import FloatArray, IntArray


@dataclass(frozen=True, slots=True)
class SplineSettings:
    """How finely the motion is described.

    Attributes
    ----------
    knot_s
        Distance of the knots: a cubic between them follows a fall with drag to far below a micrometre, and the jerk's
        prior takes what freedom is left. Chosen by hand.
    parts_where_sharp
        Into how many parts a span is divided where the residuals ask (2.5 ms).
    """

    knot_s: float = 0.010
    parts_where_sharp: int = 4


SPLINE = SplineSettings()


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
        # a triple knot leaves the position continuous and frees velocity: an impact
        parts = [np.repeat(self.edge_s[0], 3)]
        for first, last, share in zip(self.edge_s[:-1], self.edge_s[1:], self.fractions, strict=True):
            parts += [first + (last - first) * share[:-1], np.repeat(last, 2)]
        return np.concatenate([*parts, np.repeat(self.edge_s[-1], 2)])

    def design(self, time_s: FloatArray) -> csr_matrix:
        """Return B at times, shape (n, size); rows before the start are zero, after the end constant."""
        value, first = self._basis(time_s)
        return self._rows(value, first)

    def offset(self, time_s: FloatArray, coefficients: FloatArray) -> FloatArray:
        """Return B(t) c = p(t) - p(start) for coefficients (size, k), shape (n, k)."""
        return self._derivative(time_s, coefficients, 0)

    def with_breaks(self, break_s: FloatArray) -> MotionSpline:
        """Return the spline with its breaks moved."""
        return MotionSpline(np.concatenate([self.edge_s[:1], break_s, self.edge_s[-1:]]), self.fractions)

    def break_slopes(self, time_s: FloatArray, coefficients: FloatArray) -> csr_matrix:
        """Return dp/dtau of each break at fixed coefficients, x, y, z interleaved, shape (3 n, n_breaks).

        Between edges a and b the motion is a function of s = (t - a) / (b - a) alone, because the knots move with the
        breaks: dp/da = -(1 - s) v, dp/db = -s v.
        """
        # exact, at the cost of a velocity: without it impact times would need numerical columns
        velocity = self._derivative(time_s, coefficients, 1)
        part = np.searchsorted(self.edge_s, time_s) - 1
        inside = (part >= 0) & (part < self.edge_s.size - 1)
        part = np.where(inside, part, 0)
        share = (time_s - self.edge_s[part]) / np.diff(self.edge_s)[part]
        row = np.arange(time_s.size)
        out = []
        for number, weight in ((part - 1, share - 1.0), (part, -share)):
            use = inside & (number >= 0) & (number < self.break_s.size)
            rows, columns = (3 * row[use, None] + np.arange(3)).ravel(), np.repeat(number[use], 3)
            values = (weight[:, None] * velocity)[use].ravel()
            out.append(csr_matrix((values, (rows, columns)), shape=(3 * time_s.size, self.break_s.size)))
        return csr_matrix(out[0] + out[1])

    def jerk(self) -> tuple[csr_matrix, FloatArray, FloatArray]:
        """Return the matrix of the third derivative in each span, the spans' middles, and their lengths.

        A cubic's third derivative is its third difference at four even points over h^3.
        """
        shares = zip(self.edge_s[:-1], self.edge_s[1:], self.fractions, strict=True)
        edges = np.concatenate([*(a + (b - a) * share[:-1] for a, b, share in shares), self.edge_s[-1:]])
        length = np.diff(edges)
        # four even points inside the span: no knot between them, so that the difference is exact
        h = length / 4.0
        value, first = self._basis((edges[:-1, None] + (0.5 + np.arange(4)) * h[:, None]).ravel())
        third = np.array([-1.0, 3.0, -3.0, 1.0]) @ value.reshape(-1, 4, 4)
        return self._rows(third / h[:, None] ** 3, first[::4]), edges[:-1] + length / 2.0, length

    def _derivative(self, time_s: FloatArray, coefficients: FloatArray, order: int) -> FloatArray:
        # before the release it hangs, after the record nobody asks
        clipped = np.clip(time_s, self.edge_s[0], self.edge_s[-1])
        first = np.zeros_like(coefficients[:1])
        return np.asarray(BSpline(self.knots(), np.concatenate([first, coefficients]), 3)(clipped, nu=order))

    def _basis(self, time_s: FloatArray) -> tuple[FloatArray, IntArray]:
        """Return the four functions that are not zero at each time, (n, 4), and the number of the first, (n,)."""
        clipped = np.clip(time_s, self.edge_s[0], self.edge_s[-1])
        matrix = BSpline.design_matrix(clipped, self.knots(), 3)
        return matrix.data.reshape(-1, 4), matrix.indices[::4]

    def _rows(self, value: FloatArray, first: IntArray) -> csr_matrix:
        """Return rows of four neighbours each as a matrix, the first coefficient left out."""
        # four functions live in each span; the very first coefficient is the release itself
        column = first[:, None] + np.arange(-1, 3)
        kept = column >= 0
        pointer = np.concatenate([[0], np.cumsum(kept.sum(axis=1))])
        return csr_matrix((value[kept], column[kept], pointer), shape=(first.size, self.size))


@dataclass(frozen=True, slots=True)
class SplineMotion:
    """A motion: its spline and the coefficients (spline.size, 3) relative to the release position, metres."""

    spline: MotionSpline
    coefficients: FloatArray


def make_spline(
    start_s: float,
    end_s: float,
    break_s: FloatArray,
    sharp_s: FloatArray | None = None,
    settings: SplineSettings = SPLINE,
) -> MotionSpline:
    """Return a spline with knots about every 10 ms between start, breaks and end; 2.5 ms around `sharp_s`."""
    edge = np.concatenate([[start_s], break_s, [end_s]])
    sharp = np.zeros(0) if sharp_s is None else sharp_s
    fractions = []
    for first, last in pairwise(edge):
        # evenly in each flight: knots as shares move with the breaks, and impact times have exact derivatives
        count = max(1, int(np.ceil((last - first) / settings.knot_s - 1e-9)))
        coarse = np.linspace(0.0, 1.0, count + 1)
        middle = first + (last - first) * (coarse[:-1] + coarse[1:]) / 2.0
        # neighbours too: a push begins before its largest residual
        close = (np.abs(middle[:, None] - sharp[None]) < settings.knot_s).any(axis=1)
        parts = [
            np.linspace(a, b, (settings.parts_where_sharp if fine else 1) + 1)[:-1]
            for (a, b), fine in zip(pairwise(coarse), close, strict=True)
        ]
        fractions.append(np.concatenate([*parts, [1.0]]))
    return MotionSpline(edge, tuple(fractions))
