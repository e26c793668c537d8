"""The normal matrix and the slope of the joint problem (method 4, Minimum)."""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from scipy.sparse import bsr_matrix, csc_matrix, csr_matrix

from radargui.estimation.forward.banded_rows import PAIRS
from radargui.estimation.forward.equation_of_motion import EquationDeviation
from radargui.estimation.forward.segments import Segments
from radargui.estimation.forward.signal_model import EVERY, nodes_of
from radargui.estimation.forward.signal_slopes import receiver_slopes
from radargui.estimation.solve.normal import NormalBlocks, NormalMatrix, Reduced
from radargui.estimation.solve.problem import BINS_TOGETHER, JointProblem, Linearised, State
from radargui.model.arrays import FloatArray, IntArray, pieces
from radargui.model.errors import SolveError

BENT_ALONE = (0.0, 1e-3, 0.03, 0.9)
"""Shares of the diagonal of M by which breaks and mirrors alone are damped; with the last they are as good as held."""
OF_ALL = tuple(10.0**power for power in range(-4, 4))
"""Shares of the whole diagonal, from which damping goes on where these do not do."""
MOST_DAMPING = len(BENT_ALONE) + len(OF_ALL) - 1
"""The last of these shares, counted through both; beyond it there is no step."""
_JITTERS = (0.0, 1e-13, 1e-11, 1e-9, 1e-7)  # of the diagonal: rounding of coefficients that hardly any bin sees


@dataclass(frozen=True)
class Assembled:
    """Blocks of the normal matrix H = [[S, C], [C^T, M]] and the slope: motion S, global parameters M, coupling C.

    `blocks` (j, j + d) of S have the shape (4, size, 3, 3); C stands in `beside` and `c` (`NormalBlocks`); `bent` are
    the places of the breaks and the mirrors among the global parameters.
    """

    blocks: FloatArray
    beside: FloatArray
    c: FloatArray
    m: FloatArray
    segments: Segments
    slope_motion: FloatArray
    slope_global: FloatArray
    bent: IntArray

    def factor(self, damping: int = 0) -> NormalMatrix:
        """Factor H with its diagonal raised by a share; the least share that makes it positive definite is added.

        `damping` counts the shares: first of the breaks and the mirrors alone, which signals are least linear in
        (`BENT_ALONE`), then of all (`OF_ALL`; Marquardt 1963).

        Raises
        ------
        SolveError
            None does.
        """
        if damping >= len(BENT_ALONE):
            return self._damped(OF_ALL[damping - len(BENT_ALONE)])[1]
        reduced, undamped = self._undamped
        if damping == 0:
            return undamped
        # places of breaks and mirrors lie in M alone: the motion need not be eliminated again
        added = np.zeros(len(self.m))
        added[self.bent] = BENT_ALONE[damping] * np.diagonal(self.m)[self.bent]
        return reduced.factor(added)

    @cached_property
    def _undamped(self) -> tuple[Reduced, NormalMatrix]:
        # a step, one with less freedom, and what is known at its end ask for it
        return self._damped(0.0)

    @cached_property
    def s(self) -> csr_matrix:
        """S as a matrix."""
        return _symmetric(self.blocks)

    @cached_property
    def coupling(self) -> FloatArray:
        """All of C, shape (n_motion, n_global)."""
        n_breaks, segments = self.segments.n_breaks, self.segments
        by_function = np.zeros((segments.n_functions, 3, n_breaks + 2))
        every = np.arange(segments.n_functions)
        for side in range(2):
            # a break more at either end, which none of the functions has
            by_function[every, :, segments.segment + side] = self.beside[:, :, side]
        by_breaks = segments.folded(by_function)[1:, :, 1:-1].reshape(len(self.c), n_breaks)
        return np.concatenate([by_breaks, self.c], axis=1)

    @property
    def normal_blocks(self) -> NormalBlocks:
        """H as it is factored."""
        return NormalBlocks(_lower_band(self.blocks), self.beside, self.c, self.m, self.segments)

    def _damped(self, damping: float) -> tuple[Reduced, NormalMatrix]:
        failed: SolveError | None = None
        blocks = self.normal_blocks
        # as little as will do: jitter is a prior that nobody chose
        for jitter in _JITTERS:
            share = damping + jitter
            try:
                reduced = Reduced.of(blocks.diagonal_raised(share) if share else blocks)
                return reduced, reduced.factor()
            except SolveError as error:
                failed = error
        raise failed or SolveError("The normal matrix of the joint estimate cannot be factored.")


def assemble(problem: JointProblem, state: State, at: Linearised, sums: DataSums | None = None) -> Assembled:
    """Build H = J^T W J + priors and the slope J^T W r + priors, interleaving x, y, z in the motion.

    Parameters
    ----------
    problem, state, at
        The problem linearised at a state.
    sums
        What the data say there, where it was summed for a problem that differs in its priors alone.
    """
    layout, prior, sums = problem.layout, problem.prior, sums or sum_data(problem, state, at)
    beside, c, m = sums.beside, sums.c[3:], sums.m.copy()
    m[np.diag_indices(layout.size)] += 1.0 / prior.sd**2
    slope = sums.slope + (state.theta - prior.mean) / prior.sd**2
    # a prior of each coordinate alike: outside of flights gravity and drag are no jerk to speak of
    band = sums.band + at.equation.rows.rows.gram(problem.equation_sd**-2.0)[:, :, None, None] * np.eye(3)
    by_motion, by_global = equation_slopes(problem, at)
    if layout.sizes.flight:
        beside, c = beside.copy(), c.copy()
        _add_flight(beside, c, m, problem, at)
    bent, slope_motion = np.r_[layout.breaks, layout.planes], sums.slope_motion[3:] + by_motion
    return Assembled(band[:, 1:], beside, c, m, at.spline.segments, slope_motion, slope + by_global, bent)


def sum_data(problem: JointProblem, state: State, at: Linearised) -> DataSums:
    """Return what the data make of H and of the slope at a state, the priors left out."""
    sums = DataSums(problem, state, at)
    for part in pieces(problem.bins.n_bins, BINS_TOGETHER):
        sums.add(part)
    # written once above; a symmetric matrix must be so to the last bit, or Cholesky takes the wrong half
    breaks = problem.layout.breaks
    sums.m[breaks.stop :, breaks] = sums.m[breaks, breaks.stop :].T
    return sums


class DataSums:
    """Sums over the bins; what belongs to the motion has the release itself, which does not move, at its head.

    Attributes
    ----------
    band
        Blocks (j, j + d) of S, shape (4, size + 1, 3, 3).
    beside, c, m, slope, slope_motion
        As of `Assembled`.
    """

    def __init__(self, problem: JointProblem, state: State, at: Linearised) -> None:
        self.problem, self.state, self.at = problem, state, at
        n_coefficients, n_global, segments = at.spline.size + 1, problem.layout.size, at.spline.segments
        self.band, self.beside = np.zeros((4, n_coefficients, 3, 3)), np.zeros((segments.n_functions, 3, 2))
        self.c, self.m = np.zeros((3 * n_coefficients, n_global - segments.n_breaks)), np.zeros((n_global, n_global))
        self.slope, self.slope_motion = np.zeros(n_global), np.zeros(3 * n_coefficients)
        # a break acts through the motion alone: its columns are the motion's times dp/dtau
        self.share, self.number = at.spline.break_shares(problem.bins.time_s)

    def moved(self, coefficients: FloatArray, theta: FloatArray) -> DataSums:
        """Return the sums where the state has moved by so much, (n, 3) and (n_global,), if the model is linear."""
        motion = np.concatenate([np.zeros((1, 3)), coefficients])
        along = np.zeros_like(motion)
        for distance, blocks in enumerate(self.band):
            here, other = motion[: len(motion) - distance, :, None], motion[distance:, :, None]
            between = blocks[: len(here)]
            along[: len(here)] += (between @ other)[..., 0]
            if distance:
                along[distance:] += (between.transpose(0, 2, 1) @ here)[..., 0]
        segments, n_breaks = self.at.spline.segments, self.problem.layout.breaks.stop
        moved = segments.breaks_beside(theta[:n_breaks])[segments.segment]
        along += segments.folded((self.beside @ moved[:, :, None])[..., 0])
        by_function = np.einsum("fas,fa->fs", self.beside, motion[segments.coefficient])
        out = copy(self)
        out.slope_motion = self.slope_motion + along.ravel() + self.c @ theta[n_breaks:]
        # of a linear model: slope(x + d) = slope(x) + H d
        out.slope = self.slope + self.m @ theta
        out.slope[:n_breaks] += segments.of_breaks(_by_segment(segments.segment, by_function, segments))
        out.slope[n_breaks:] += self.c.T @ motion.ravel()
        return out

    def add(self, part: slice) -> None:
        """Add some of the bins."""
        problem, at, theta = self.problem, self.at, self.state.theta
        layout, inputs, n_receivers = problem.layout, problem.inputs.of_bins(part), problem.n_receivers
        touched = _Touched(
            at.series.first[part], self.number[part], layout.sizes.breaks > 0, 1 if layout.sizes.drift else 2
        )
        shared, n_bins = layout.shared, part.stop - part.start
        node_m = nodes_of(at.node_m[..., part])
        excess, weight = (one[:, part].reshape(n_receivers, 2, n_bins) for one in (at.excess, at.weight))
        slopes = receiver_slopes(node_m, theta, layout, inputs, EVERY, excess, at.waves)
        # of J and of the misfit alike: their products are then J^T W J and J^T W r
        root = np.sqrt(weight)
        model = np.stack([one.value[:, part] for one in at.signals])
        misfit = root * (model - problem.bins.value[:, part].reshape(model.shape))
        by_motion = self._by_motion(slopes.by_position * root[:, :, None], part)
        n_own, n_drift = slopes.columns.shape[-1], layout.sizes.drift
        columns = np.empty((n_receivers, 2, n_bins, n_own + n_drift + 1))
        np.multiply(slopes.columns, root[..., None], out=columns[..., :n_own])
        functions = inputs.drift.reshape(n_receivers, 2, n_bins, n_drift)
        np.multiply(functions, root[..., None], out=columns[..., n_own:-1])
        # the misfit as one more column: its products with the others are the slope
        columns[..., -1] = misfit
        for moving, own_columns, own in zip(by_motion, columns, layout.receivers, strict=True):
            if not n_drift:
                self._add_columns(touched, moving, own_columns, (shared, own.without_drift))
                continue
            # slow noise apart: its functions are many and touch one channel each
            for channel, drift in enumerate((own.drift_i, own.drift_q)):
                one = slice(channel, channel + 1)
                self._add_columns(touched, moving[one], own_columns[one], (shared, own.without_drift, drift))
        self._add_motion(touched, by_motion.reshape(2 * n_receivers, n_bins, -1))

    def _by_motion(self, by_position: FloatArray, part: slice) -> FloatArray:
        """Return slopes by coefficients and breaks from those by position, (..., 3, n), shape (..., n, 12 or 14)."""
        value = self.at.series.value[0, part]
        out = value[:, :, None] * by_position.swapaxes(-1, -2)[..., None, :]
        out = out.reshape(*out.shape[:-2], 12)
        if not self.problem.layout.sizes.breaks:
            return np.asarray(out)
        # dp/dtau = share times the velocity (method 4, Minimum)
        along = (by_position * self.at.motion[1, :, part]).sum(axis=-2)
        return np.concatenate([out, along[..., None] * self.share[part]], axis=-1)

    def _add_columns(
        self, touched: _Touched, by_motion: FloatArray, columns: FloatArray, places: tuple[slice, ...]
    ) -> None:
        """Add what slopes by global parameters, (n_channels, n_bins, n), do to each other and to the motion.

        The last column is the misfit.
        """
        flat = columns.reshape(-1, columns.shape[2])
        among, coupled = flat.T @ flat, touched.transposed(by_motion, flat)
        breaks, n_breaks = touched.breaks, self.problem.layout.breaks.stop
        self.slope_motion[touched.rows] += coupled[: 3 * touched.width, -1]
        self.slope[breaks] += coupled[3 * touched.width :, -1]
        ends = np.cumsum([0, *(own.stop - own.start for own in places)]).tolist()
        parts = [slice(first, last) for first, last in pairwise(ends)]
        # slices, not lists of places: these would be copied there and back
        for place, own in zip(places, parts, strict=True):
            self.slope[place] += among[own, -1]
            self.c[touched.rows, place.start - n_breaks : place.stop - n_breaks] += coupled[: 3 * touched.width, own]
            self.m[breaks, place] += coupled[3 * touched.width :, own]
            for other, beside in zip(places, parts, strict=True):
                self.m[place, other] += among[own, beside]

    def _add_motion(self, touched: _Touched, by_motion: FloatArray) -> None:
        """Add what motion and breaks do to each other from their slopes, (n_channels, n_bins, 12 or 14)."""
        # bins that touch the same coefficients are neighbours
        start = np.flatnonzero(np.diff(touched.first, prepend=-1))
        first = touched.first[start]
        rows = np.ascontiguousarray(by_motion.swapaxes(0, 1))
        runs = [rows[a:b].reshape(-1, touched.per_bin) for a, b in pairwise([*start.tolist(), len(rows)])]
        among = np.array([run.T @ run for run in runs])
        for k, other in PAIRS:
            # each first of a run occurs once, so that no addition is lost
            self.band[other - k, first + k] += among[:, 3 * k : 3 * k + 3, 3 * other : 3 * other + 3]
        if touched.per_bin == 12:
            return
        functions = first + self.at.spline.segments.of(first)
        for k in range(4):
            self.beside[functions + k] += among[:, 3 * k : 3 * k + 3, 12:]
        # a span lies between two breaks; that before it is the release has a share of zero
        places = np.maximum.reduceat(touched.number, start, axis=0)
        np.add.at(self.m, (places[:, :, None], places[:, None]), among[:, 12:, 12:])


class _Touched:
    """Which coefficients and breaks some bins touch.

    Parameters
    ----------
    first
        See `BandedRows`, shape (n_bins,).
    number
        The breaks beside each bin, shape (n_bins, 2).
    has_breaks
        Whether there are any.
    n_channels
        How many channels are looked at together.
    """

    def __init__(self, first: IntArray, number: IntArray, has_breaks: bool, n_channels: int) -> None:
        self.first, self.number = first, number
        self.breaks = slice(int(number.min()), int(number.max()) + 1) if has_breaks else slice(0, 0)
        low, n_breaks = int(first[0]), self.breaks.stop - self.breaks.start
        self.width = int(first[-1]) - low + 4
        self.rows = slice(3 * low, 3 * (low + self.width))
        columns = 3 * (first - low)[:, None] + np.arange(12)
        if has_breaks:
            columns = np.concatenate([columns, 3 * self.width + number - self.breaks.start], axis=1)
        self.per_bin, n_rows = columns.shape[1], n_channels * len(columns)
        index, pointer = np.tile(columns.ravel(), n_channels), self.per_bin * np.arange(n_rows + 1)
        # the same places for every receiver: only the values are new; rows are the columns of what is transposed
        self._columns = csc_matrix((np.zeros(index.size), index, pointer), shape=(3 * self.width + n_breaks, n_rows))

    def transposed(self, by_motion: FloatArray, columns: FloatArray) -> FloatArray:
        """Return (motion, breaks)^T applied to columns, (n_channels n_bins, k), for slopes (n_channels, n_bins, n)."""
        self._columns.data = by_motion.ravel()
        return np.asarray(self._columns @ columns)


def _lower_band(blocks: FloatArray) -> FloatArray:
    """Return the `lower_band` of the matrix of blocks (j, j + d), (4, size, 3, 3)."""
    size = blocks.shape[1]
    out = np.zeros((12, 3 * size))
    for distance, one in enumerate(blocks):
        for a in range(3):
            for b in range(3):
                # the element (3 j + a, 3 (j + d) + b) stands above the diagonal, and as much below it
                if (below := 3 * distance + b - a) >= 0:
                    out[below, a::3] = one[:, a, b]
    return out


def _symmetric(band: FloatArray) -> csr_matrix:
    """Return the matrix of blocks (j, j + d), (4, size, 3, 3), and their transposes."""
    size = band.shape[1]
    blocks = np.zeros((size, 7, 3, 3))
    for distance in range(min(4, size)):
        here = band[distance, : size - distance]
        blocks[: size - distance, 3 + distance] = here
        blocks[distance:, 3 - distance] = here.transpose(0, 2, 1)
    column = np.arange(size)[:, None] + np.arange(-3, 4)
    kept = (column >= 0) & (column < size)
    pointer = np.concatenate([[0], np.cumsum(kept.sum(axis=1))])
    return bsr_matrix((blocks[kept], column[kept], pointer), shape=(3 * size, 3 * size)).tocsr()


def equation_slopes(problem: JointProblem, at: Linearised) -> tuple[FloatArray, FloatArray]:
    """Return the slope of the equation's part of the cost, by the motion, (3 size,), and by the global parameters.

    Outside of flights a jerk goes with the duration of its segment to the power -3; that share of a break's slope, a
    nanosecond of its time, is left out.
    """
    weighted = problem.equation_sd[:, None] ** -2.0 * at.equation.value
    layout, slope = problem.layout, np.zeros(problem.layout.size)
    if layout.sizes.flight:
        equation, segments = at.equation, at.spline.segments
        pulls = np.einsum("nak,na->nk", equation.by_breaks, weighted)
        slope[layout.breaks] = segments.of_breaks(_by_segment(equation.rows.segment, pulls, segments))
        slope[layout.flight] = np.einsum("nak,na->k", _by_gravity_and_drag(equation), weighted)
    return at.equation.rows.rows.transposed(weighted).ravel(), slope


def _by_segment(segment: IntArray, values: FloatArray, segments: Segments) -> FloatArray:
    """Return values, (n, k), summed over each segment, shape (n_breaks + 1, k)."""
    out = np.zeros((segments.n_breaks + 1, values.shape[1]))
    np.add.at(out, segment, values)
    return out


def _by_gravity_and_drag(equation: EquationDeviation) -> FloatArray:
    """Return the slopes of the equation's rows with respect to gravity and drag, shape (n_rows, 3, 4)."""
    return np.concatenate([equation.rows.is_flight[:, None, None] * np.eye(3), equation.drag[:, :, None]], axis=2)


def _add_flight(beside: FloatArray, c: FloatArray, m: FloatArray, problem: JointProblem, at: Linearised) -> None:
    """Add to C and M what gravity, drag and the breaks' times do to the equation of flight."""
    equation, layout, segments = at.equation, problem.layout, at.spline.segments
    flight = layout.flight
    # by the breaks before and after, then by gravity and drag
    slopes = np.concatenate([equation.by_breaks, _by_gravity_and_drag(equation)], axis=2)
    weighted = problem.equation_sd[:, None, None] ** -2.0 * slopes
    # neighbouring segments share a place: even and odd ones apart
    is_odd = (equation.rows.segment % 2 == 1)[:, None, None]
    by_breaks = [np.where(is_odd, 0.0, weighted[:, :, :2]), np.where(is_odd, weighted[:, :, :2], 0.0)]
    columns = np.concatenate([weighted[:, :, 2:], *by_breaks], axis=2)
    coupled = equation.rows.rows.transposed(columns.reshape(len(columns), -1)).reshape(-1, 3, 8)
    # x, y and z interleaved, as the motion has them
    c[:, flight.start - segments.n_breaks : flight.stop - segments.n_breaks] += coupled[:, :, :4].reshape(-1, 4)
    moving = segments.coefficient > 0
    of_function = coupled[segments.coefficient[moving] - 1, :, 4:].reshape(-1, 3, 2, 2)
    beside[moving] += of_function[np.arange(len(of_function)), :, segments.segment[moving] % 2]
    among = np.zeros((segments.n_breaks + 1, 6, 6))
    np.add.at(among, equation.rows.segment, weighted.transpose(0, 2, 1) @ slopes)
    m[flight, flight] += among[:, 2:, 2:].sum(axis=0)
    number = np.arange(segments.n_breaks)
    # start and end of the record are no breaks, and stand in none of the slopes
    for places, segment, side in ((number, number + 1, 0), (number, number, 1)):
        m[places, places] += among[segment, side, side]
        m[places, flight] += among[segment, side, 2:]
        m[flight, places] += among[segment, side, 2:].T
    between, next_one = among[1:-1, 0, 1], number[1:]
    m[next_one - 1, next_one] += between
    m[next_one, next_one - 1] += between


def diagonal(values: FloatArray) -> csr_matrix:
    """Return a sparse diagonal matrix of values, (n,)."""
    n = values.size
    return csr_matrix((values, np.arange(n), np.arange(n + 1)), shape=(n, n))
