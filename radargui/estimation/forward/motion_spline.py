"""The motion as a cubic B-spline that may change its velocity at breaks (method 4, Motion)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from scipy.interpolate import BSpline
from scipy.sparse import csr_matrix

from radargui.estimation.forward.banded_rows import BandedRows
from radargui.model.arrays import BoolArray, FloatArray, IntArray


@dataclass(frozen=True, slots=True)
class SplineSettings:
    """How finely the motion is described.

    Attributes
    ----------
    knot_s
        Distance of the knots: a cubic between them follows a fall with drag to far below a micrometre, and the jerk's
        prior takes what freedom is left. Chosen by hand.
    parts_where_sharp
        Into how many parts a span is divided where the residuals ask (2.5 ms). Chosen by hand.
    """

    knot_s: float = 0.010
    parts_where_sharp: int = 4


SPLINE = SplineSettings()
_STENCILS = np.array(
    [
        np.array([-1.0, 9.0, 9.0, -1.0]) / 16.0,
        np.array([1.0, -27.0, 27.0, -1.0]) / 24.0,
        [0.5, -0.5, -0.5, 0.5],
        [-1.0, 3.0, -3.0, 1.0],
    ]
)
"""Value and derivatives of a cubic in the middle of four even points, over powers of their distance."""


@dataclass(frozen=True, slots=True)
class SpanPolynomials:
    """The four functions of each span as Taylor series about its middle, in shares s of the distance between edges.

    Knots move with the breaks, and triple knots part the functions there: in s nothing depends on the breaks' times.

    Attributes
    ----------
    segment, begin, middle, length
        Between which edges each span lies, and its begin, middle and length as shares, shape (n_spans,).
    first
        Number of the first of the four functions.
    series
        Derivatives by s of order 0 to 3, shape (4, n_spans, 4).
    """

    segment: IntArray
    begin: FloatArray
    middle: FloatArray
    length: FloatArray
    first: IntArray
    series: FloatArray


@dataclass(frozen=True, slots=True)
class SplineSeries:
    """B and its derivatives at some times.

    Attributes
    ----------
    value
        Derivatives of order 0 to 3 of the four functions that are not zero there, shape (4, n, 4).
    first
        Number of the first of them (`BandedRows`).
    low_s, high_s
        Between these the series of Taylor is the spline itself, shape (n,).
    size
        Number of coefficients.
    """

    value: FloatArray
    first: IntArray
    low_s: FloatArray
    high_s: FloatArray
    size: int

    def rows(self, order: int = 0) -> BandedRows:
        """Return the rows of a derivative."""
        return BandedRows(self.value[order], self.first, self.size)

    def beyond(self, time_s: FloatArray) -> BoolArray:
        """Return which times, (..., n), lie where the series are no longer the spline."""
        return np.asarray((time_s < self.low_s) | (time_s > self.high_s))

    def motion(self, coefficients: FloatArray) -> FloatArray:
        """Return p - p(start), velocity, acceleration and jerk for coefficients (size, 3), shape (4, 3, n)."""
        padded = np.concatenate([np.zeros_like(coefficients[:1]), coefficients]).T.copy()
        out = self.value[:, None, :, 0] * padded[:, self.first]
        for k in range(1, 4):
            out += self.value[:, None, :, k] * padded[:, self.first + k]
        return np.asarray(out)


@dataclass(frozen=True)
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

    @cached_property
    def spans(self) -> tuple[int, ...]:
        """Number of knot spans between neighbouring edges."""
        return tuple(share.size - 1 for share in self.fractions)

    @cached_property
    def size(self) -> int:
        """Number of coefficients per coordinate."""
        return int(sum(self.spans) + 2 * (len(self.spans) - 1) + 2)

    @property
    def break_s(self) -> FloatArray:
        """Times of the breaks, shape (n_breaks,)."""
        return self.edge_s[1:-1]

    def knots(self) -> FloatArray:
        """Return the knots with multiplicities 4, 3, ..., 3, 4, shape (size + 5,)."""
        return np.repeat(self._span_edges(), self._multiplicities)

    def rows(self, time_s: FloatArray) -> BandedRows:
        """Return B at times, (n, size); rows before the start are zero, after the end constant."""
        return self.series(time_s).rows()

    def design(self, time_s: FloatArray) -> csr_matrix:
        """Return B at times (n,) as a matrix, shape (n, size)."""
        return self.rows(time_s).matrix

    def offset(self, time_s: FloatArray, coefficients: FloatArray) -> FloatArray:
        """Return B(t) c = p(t) - p(start) for coefficients (size, k), shape (n, k)."""
        return self._derivative(time_s, coefficients, 0)

    def with_breaks(self, break_s: FloatArray) -> MotionSpline:
        """Return the spline with its breaks moved to times, shape (n_breaks,)."""
        moved = MotionSpline(np.concatenate([self.edge_s[:1], break_s, self.edge_s[-1:]]), self.fractions)
        # the same shares: found once for all times of the breaks
        same = ("spans", "size", "polynomials", "_multiplicities")
        moved.__dict__.update((name, getattr(self, name)) for name in same)
        return moved

    def break_shares(self, time_s: FloatArray) -> tuple[FloatArray, IntArray]:
        """Return dp/dtau over the velocity for the breaks before and after each time, and their numbers, both (n, 2).

        Between edges a and b the motion is a function of s = (t - a) / (b - a) alone, because the knots move with the
        breaks: dp/da = -(1 - s) v, dp/db = -s v. The start and the end do not move: their share is zero, their number
        that of some break.
        """
        share, _, number, moves = self._between_edges(time_s)
        out = np.stack([share - 1.0, -share], axis=1) * moves
        return out, np.clip(number, 0, max(self.break_s.size - 1, 0))

    def break_share_rates(self, time_s: FloatArray) -> FloatArray:
        """Return what the shares of `break_shares` change by in a second, shape (n, 2)."""
        _, lasts_s, _, moves = self._between_edges(time_s)
        return np.asarray(np.stack([1.0 / lasts_s, -1.0 / lasts_s], axis=1) * moves)

    def _between_edges(self, time_s: FloatArray) -> tuple[FloatArray, FloatArray, IntArray, BoolArray]:
        """Return s of times (n,), b - a, the numbers of the breaks at a and b, (n, 2), and which of them are breaks."""
        part = np.clip(np.searchsorted(self.edge_s, time_s) - 1, 0, self.edge_s.size - 2)
        lasts_s = np.diff(self.edge_s)[part]
        share, number = (time_s - self.edge_s[part]) / lasts_s, np.stack([part - 1, part], axis=1)
        inside = (share > 0.0) & (share <= 1.0)
        return share, lasts_s, number, inside[:, None] & (number >= 0) & (number < self.break_s.size)

    def break_slopes(self, time_s: FloatArray, coefficients: FloatArray) -> csr_matrix:
        """Return dp/dtau of each break at fixed coefficients, x, y, z interleaved, shape (3 n, n_breaks)."""
        # exact, at the cost of a velocity: without it impact times would need numerical columns
        if not self.break_s.size:
            return csr_matrix((3 * time_s.size, 0))
        share, number = self.break_shares(time_s)
        values = self.velocity(time_s, coefficients)[:, :, None] * share[:, None, :]
        columns = np.repeat(number[:, None], 3, axis=1)
        return csr_matrix(
            (values.ravel(), columns.ravel(), np.arange(0, values.size + 1, 2)),
            shape=(3 * time_s.size, self.break_s.size),
        )

    def velocity(self, time_s: FloatArray, coefficients: FloatArray) -> FloatArray:
        """Return the velocity for coefficients (size, k), shape (n, k)."""
        return self._derivative(time_s, coefficients, 1)

    @cached_property
    def polynomials(self) -> SpanPolynomials:
        """The functions of each span, from their values at four even points."""
        segment = np.repeat(np.arange(len(self.spans)), self.spans)
        begin = np.concatenate([share[:-1] for share in self.fractions])
        length = np.concatenate([np.diff(share) for share in self.fractions])
        # inside the span: no knot between them, so that differences of a cubic are exact
        points = segment[:, None] + begin[:, None] + (0.5 + np.arange(4)) * (length[:, None] / 4.0)
        knots = np.repeat(np.append(segment + begin, len(self.spans)), self._multiplicities)
        matrix = BSpline.design_matrix(points.ravel(), knots, 3)
        series = np.moveaxis(_STENCILS @ matrix.data.reshape(-1, 4, 4), 1, 0)
        series = series / (length[:, None] / 4.0) ** np.arange(4)[:, None, None]
        return SpanPolynomials(
            segment, begin, begin + 0.5 * length, length, matrix.indices[::16].astype(np.intp), series
        )

    def series(self, time_s: FloatArray) -> SplineSeries:
        """Return B and its derivatives at times, (n,); before the start and after the end the motion stands still."""
        unit, edges = self.polynomials, self._span_edges()
        # before the release it hangs, after the record nobody asks
        clipped = np.clip(time_s, edges[0], edges[-1])
        span = np.clip(np.searchsorted(edges, clipped, side="right") - 1, 0, edges.size - 2)
        segment = unit.segment[span]
        scale = 1.0 / np.diff(self.edge_s)[segment]
        away = ((clipped - self.edge_s[segment]) * scale - unit.middle[span])[:, None]
        # a cubic is its own series of Taylor: exact, about the middle of its span
        f, slope, second, third = unit.series[:, span]
        value = np.stack(
            [
                f + away * (slope + away / 2.0 * (second + away / 3.0 * third)),
                slope + away * (second + away / 2.0 * third),
                second + away * third,
                third,
            ]
        )
        value[1:] *= (scale ** np.arange(1, 4)[:, None])[:, :, None]
        low, high = edges[span], edges[span + 1]
        still = clipped != time_s
        if still.any():
            value[1:, still] = 0.0
            before = time_s < edges[0]
            low = np.where(still, np.where(before, -np.inf, edges[-1]), low)
            high = np.where(still, np.where(before, edges[0], np.inf), high)
        return SplineSeries(value, unit.first[span], low, high, self.size)

    def span_middles(self) -> FloatArray:
        """Return the middles of the spans, shape (n_spans,)."""
        unit = self.polynomials
        return np.asarray(self.edge_s[unit.segment] + np.diff(self.edge_s)[unit.segment] * unit.middle)

    def jerk(self) -> tuple[BandedRows, FloatArray, FloatArray]:
        """Return the rows of the third derivative in each span, their middles and lengths in s, (n_spans,) each."""
        unit, length = self.polynomials, np.diff(self.edge_s)[self.polynomials.segment]
        third = unit.series[3] / length[:, None] ** 3
        return BandedRows(third, unit.first, self.size), self.span_middles(), length * unit.length

    def at_ends(self, span: IntArray, is_end: BoolArray) -> tuple[BandedRows, BandedRows]:
        """Return the rows of velocity and acceleration at the begin or end of spans (n,), seen from inside them."""
        unit = self.polynomials
        _, slope, second, third = unit.series[:, span]
        away = (np.where(is_end, 0.5, -0.5) * unit.length[span])[:, None]
        length = np.diff(self.edge_s)[unit.segment[span], None]
        velocity, acceleration = slope + away * (second + 0.5 * away * third), second + away * third
        first = unit.first[span]
        return BandedRows(velocity / length, first, self.size), BandedRows(acceleration / length**2, first, self.size)

    def _span_edges(self) -> FloatArray:
        unit = self.polynomials
        begin = self.edge_s[unit.segment] + np.diff(self.edge_s)[unit.segment] * unit.begin
        return np.append(begin, self.edge_s[-1])

    @cached_property
    def _multiplicities(self) -> IntArray:
        """Of the knots at the edges of the spans."""
        # a triple knot leaves the position continuous and frees velocity: an impact
        out = np.ones(sum(self.spans) + 1, dtype=np.intp)
        out[np.cumsum(self.spans)[:-1]] = 3
        out[[0, -1]] = 4
        return out

    def _derivative(self, time_s: FloatArray, coefficients: FloatArray, order: int) -> FloatArray:
        # before the release it hangs, after the record nobody asks
        clipped = np.clip(time_s, self.edge_s[0], self.edge_s[-1])
        first = np.zeros_like(coefficients[:1])
        # knots and coefficients belong together: nothing to check at each of thousands of calls
        spline = BSpline.construct_fast(self.knots(), np.concatenate([first, coefficients]), 3)
        return np.asarray(spline(clipped, nu=order))


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
) -> MotionSpline:
    """Return a spline with knots about every 10 ms between start, breaks (n_breaks,), end; 2.5 ms around `sharp_s`."""
    edge = np.concatenate([[start_s], break_s, [end_s]])
    sharp = np.zeros(0) if sharp_s is None else sharp_s
    fractions = []
    for first, last in pairwise(edge):
        # evenly in each flight: knots as shares move with the breaks, and impact times have exact derivatives
        count = max(1, int(np.ceil((last - first) / SPLINE.knot_s - 1e-9)))
        coarse = np.linspace(0.0, 1.0, count + 1)
        middle = first + (last - first) * (coarse[:-1] + coarse[1:]) / 2.0
        # neighbours too: a push begins before its largest residual
        close = (np.abs(middle[:, None] - sharp[None]) < SPLINE.knot_s).any(axis=1)
        parts = np.where(close, SPLINE.parts_where_sharp, 1)
        within = np.arange(parts.sum()) - np.repeat(np.cumsum(parts) - parts, parts)
        finer = np.repeat(coarse[:-1], parts) + within * np.repeat(np.diff(coarse) / parts, parts)
        fractions.append(np.append(finer, 1.0))
    return MotionSpline(edge, tuple(fractions))
