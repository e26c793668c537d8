"""Assemble the normal matrix and the slope of the joint problem."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from scipy.sparse import csc_matrix

from radargui.estimation.forward.signal_model import EVERY, nodes_of
from radargui.estimation.forward.signal_slopes import receiver_slopes
from radargui.estimation.forward.stated_floor import stated_term
from radargui.estimation.solve.normal import WIDTH, FactoredNormal, NormalMatrix
from radargui.estimation.solve.problem import BINS_TOGETHER, JointProblem, Linearised, State
from radargui.model.arrays import FloatArray, IntArray, pieces
from radargui.model.errors import SolveError

BENT_ALONE = (0.0, 1e-3, 0.03, 0.9)
"""Shares of the diagonal of M by which breaks and mirrors alone are damped; with the last they are as good as held."""
OF_ALL = tuple(10.0**power for power in range(-4, 4))
"""Shares of the whole diagonal, from which damping goes on where these do not do."""
MAX_DAMPING = len(BENT_ALONE) + len(OF_ALL) - 1
"""The last of these shares, counted through both; beyond it there is no step."""
_JITTERS = (0.0, 1e-13, 1e-11, 1e-9, 1e-7)  # of the diagonal: rounding of coefficients that hardly any bin sees


@dataclass(frozen=True)
class Assembled:
    """The normal matrix and the slope; `bent` are the places of breaks and mirrors among the global parameters.

    The slope has the motion first, x, y and z interleaved, and the global parameters after it.
    """

    normal: NormalMatrix
    slope: FloatArray
    bent: IntArray

    def factor(self, damping: int = 0) -> FactoredNormal:
        """Factor H with its diagonal raised by a share; the least share that makes it positive definite is added.

        `damping` counts the shares: first of the breaks and the mirrors alone, which signals are least linear in
        (`BENT_ALONE`), then of all (`OF_ALL`; Marquardt 1963).

        Raises
        ------
        SolveError
            None does.
        """
        if damping >= len(BENT_ALONE):
            return self._damped(OF_ALL[damping - len(BENT_ALONE)])
        if damping == 0:
            return self._undamped
        # times of breaks and places of mirrors lie in M alone: the motion need not be eliminated again
        corner = self.normal.corner
        added = np.zeros(len(corner))
        added[self.bent] = BENT_ALONE[damping] * np.diagonal(corner)[self.bent]
        return self._undamped.with_added(added)

    @cached_property
    def _undamped(self) -> FactoredNormal:
        # a step, one with less freedom, and what is known at its end ask for it
        return self._damped(0.0)

    def _damped(self, damping: float) -> FactoredNormal:
        failed: SolveError | None = None
        # as little as will do: jitter is a prior that nobody chose
        for jitter in _JITTERS:
            share = damping + jitter
            try:
                return (self.normal.diagonal_raised(share) if share else self.normal).factor()
            except SolveError as error:
                failed = error
        raise failed or SolveError("The normal matrix of the joint estimate cannot be factored.")


def assemble(problem: JointProblem, state: State, at: Linearised, sums: DataSums | None = None) -> Assembled:
    """Build H = J^T W J + priors and the slope J^T W r + priors.

    Parameters
    ----------
    problem, state, at
        The problem linearised at a state.
    sums
        What the data say there, where it was summed for a problem that differs in its priors alone.
    """
    layout, prior, sums = problem.layout, problem.prior, sums or sum_data(problem, state, at)
    coupling, corner, equation = sums.coupling[3:], sums.corner.copy(), at.equation
    corner[np.diag_indices(layout.size)] += 1.0 / prior.sd**2
    precision = problem.equation_sd**-2.0
    # a prior of each coordinate alike: outside of flights gravity and drag are no jerk to speak of
    band = sums.band[:, 3:].copy()
    band[::3] += np.repeat(equation.rows.rows.gram(precision)[:, 1:], 3, axis=1)
    if layout.sizes.flight:
        flying, moved = slice(equation.rows.n_jerk, None), slice(0, layout.flight.stop)
        weighted = equation.by_global.multiply(np.repeat(precision[flying], 3)[:, None]).tocsr()
        coupling = coupling.copy(order="F")
        coupling[:, moved] += (equation.rows.rows[flying].of_place.T @ weighted).toarray()
        corner[moved, moved] += (equation.by_global.T @ weighted).toarray()
    by_theta = sums.slope + (state.theta - prior.mean) / prior.sd**2
    stated = stated_term(state.theta, layout, problem.placed(state.theta).inputs)
    if stated is not None:
        corner += stated.slopes.T @ stated.slopes
        by_theta += stated.slopes.T @ stated.residual
    slope = np.concatenate([sums.slope_motion[3:], by_theta])
    slope += equation_slope(problem, at)
    return Assembled(NormalMatrix(band, coupling, corner), slope, np.r_[layout.breaks, layout.planes])


def equation_slope(problem: JointProblem, at: Linearised) -> FloatArray:
    """Return the slope of the equation's part of the cost, as of `Assembled`.

    Outside of flights a jerk goes with the duration of its segment to the power -3; that share of a break's slope, a
    nanosecond of its time, is left out.
    """
    equation, layout = at.equation, problem.layout
    weighted, slope = problem.equation_sd[:, None] ** -2.0 * equation.value, np.zeros(layout.size)
    if layout.sizes.flight:
        slope[: layout.flight.stop] = equation.by_global.T @ weighted[equation.rows.n_jerk :].ravel()
    return np.concatenate([equation.rows.rows.transposed(weighted).ravel(), slope])


def sum_data(problem: JointProblem, state: State, at: Linearised) -> DataSums:
    """Return what the data make of H and of the slope at a state, the priors left out."""
    sums = DataSums(problem, state, at)
    for part in pieces(problem.bins.n_bins, BINS_TOGETHER):
        sums.add(part)
    return sums


class DataSums:
    """Sums over the bins; what belongs to the motion has the release itself, which does not move, at its head.

    Attributes
    ----------
    band, coupling, corner
        Of H, as of `NormalMatrix`.
    slope_motion, slope
        By motion and global parameters.
    """

    def __init__(self, problem: JointProblem, state: State, at: Linearised) -> None:
        problem = problem.placed(state.theta)
        self.problem, self.state, self.at = problem, state, at
        n_motion, n_global = 3 * (at.spline.size + 1), problem.layout.size
        self.band, self.coupling = np.zeros((WIDTH, n_motion)), np.zeros((n_motion, n_global), order="F")
        self.corner = np.zeros((n_global, n_global))
        self.slope_motion, self.slope = np.zeros(n_motion), np.zeros(n_global)
        # a break acts through the motion alone: its columns are the motion's times dp/dtau
        self.share, self.number = at.spline.break_shares(problem.bins.time_s)

    def add(self, part: slice) -> None:
        """Add some of the bins."""
        problem, at, theta = self.problem, self.at, self.state.theta
        layout, inputs, n_receivers = problem.layout, problem.inputs.of_bins(part), problem.n_receivers
        shared, n_bins, n_drift = layout.shared, part.stop - part.start, layout.sizes.drift
        touched = _Touched(at.series.first[part], 1 if n_drift else 2)
        breaks, shares = self._shares(part)
        node_m = nodes_of(at.node_m[..., part])
        excess, weight = (one[:, part].reshape(n_receivers, 2, n_bins) for one in (at.excess, at.weight))
        slopes = receiver_slopes(node_m, theta, layout, inputs, EVERY, excess, at.waves)
        # of J and of the misfit alike: their products are then J^T W J and J^T W r
        root = np.sqrt(weight)
        model = np.stack([one.value[:, part] for one in at.signals])
        by_position = slopes.by_position * root[:, :, None]
        by_motion = at.series.value[0, part][:, :, None] * by_position.swapaxes(-1, -2)[..., None, :]
        by_motion = by_motion.reshape(n_receivers, 2, n_bins, 12)
        ends = np.cumsum([0, shares.shape[1], slopes.columns.shape[-1], n_drift, 1]).tolist()
        columns = np.empty((n_receivers, 2, n_bins, ends[-1]))
        # dp/dtau = share times the velocity (method 4, Minimum)
        along = (by_position * at.motion[1, :, part]).sum(axis=-2)
        np.multiply(along[..., None], shares, out=columns[..., : ends[1]])
        np.multiply(slopes.columns, root[..., None], out=columns[..., ends[1] : ends[2]])
        functions = inputs.drift.reshape(n_receivers, 2, n_bins, n_drift)
        np.multiply(functions, root[..., None], out=columns[..., ends[2] : ends[3]])
        # the misfit as one more column: its products with the others are the slope
        columns[..., -1] = root * (model - problem.bins.value[:, part].reshape(model.shape))
        for moving, own_columns, own in zip(by_motion, columns, layout.receivers, strict=True):
            if not n_drift:
                self._add_columns(touched, moving, own_columns, (breaks, shared, own.without_drift))
                continue
            # slow noise apart: its functions are many and touch one channel each
            for channel, drift in enumerate((own.drift_i, own.drift_q)):
                one, places = slice(channel, channel + 1), (breaks, shared, own.without_drift, drift)
                self._add_columns(touched, moving[one], own_columns[one], places)
        self._add_motion(touched, by_motion.reshape(2 * n_receivers, n_bins, 12))

    def _shares(self, part: slice) -> tuple[slice, FloatArray]:
        """Return the breaks beside some bins, and dp/dtau of each over the velocity at them, shape (n_bins, n)."""
        share, number = self.share[part], self.number[part]
        if not self.problem.layout.sizes.breaks:
            return slice(0, 0), np.zeros((len(share), 0))
        breaks = slice(int(number.min()), int(number.max()) + 1)
        out, every = np.zeros((len(share), breaks.stop - breaks.start)), np.arange(len(share))
        for side in range(2):
            # that of the start or the end is zero, and stands at some break
            out[every, number[:, side] - breaks.start] += share[:, side]
        return breaks, out

    def _add_columns(
        self, touched: _Touched, by_motion: FloatArray, columns: FloatArray, places: tuple[slice, ...]
    ) -> None:
        """Add what slopes by global parameters, (n_channels, n_bins, n), do to each other and to the motion.

        The last column is the misfit.
        """
        flat = columns.reshape(-1, columns.shape[2])
        among, coupled = flat.T @ flat, touched.transposed(by_motion, flat)
        self.slope_motion[touched.rows] += coupled[:, -1]
        ends = np.cumsum([0, *(own.stop - own.start for own in places)]).tolist()
        parts = [slice(first, last) for first, last in pairwise(ends)]
        # slices, not lists of places: these would be copied there and back
        for place, own in zip(places, parts, strict=True):
            self.slope[place] += among[own, -1]
            self.coupling[touched.rows, place] += coupled[:, own]
            for other, beside in zip(places, parts, strict=True):
                self.corner[place, other] += among[own, beside]

    def _add_motion(self, touched: _Touched, by_motion: FloatArray) -> None:
        """Add what the motion does to itself from its slopes, (n_channels, n_bins, 12)."""
        # bins that touch the same coefficients are neighbours
        start = np.flatnonzero(np.diff(touched.first, prepend=-1))
        rows = np.ascontiguousarray(by_motion.swapaxes(0, 1))
        runs = [rows[a:b].reshape(-1, 12) for a, b in pairwise([*start.tolist(), len(rows)])]
        row, column = np.tril_indices(12)
        among = np.array([run.T @ run for run in runs])[:, row, column]
        width = touched.rows.stop - touched.rows.start
        place = (row - column) * width + 3 * (touched.first[start] - touched.first[0])[:, None] + column
        total = np.bincount(place.ravel(), weights=among.ravel(), minlength=WIDTH * width)
        self.band[:, touched.rows] += total.reshape(WIDTH, width)


class _Touched:
    """Which coefficients some bins touch.

    Parameters
    ----------
    first
        See `BandedRows`, shape (n_bins,).
    n_channels
        How many channels are looked at together.
    """

    def __init__(self, first: IntArray, n_channels: int) -> None:
        self.first, low, width = first, int(first[0]), int(first[-1] - first[0]) + 4
        self.rows = slice(3 * low, 3 * (low + width))
        columns, n_rows = 3 * (first - low)[:, None] + np.arange(12), n_channels * first.size
        index, pointer = np.tile(columns.ravel(), n_channels), 12 * np.arange(n_rows + 1)
        # the same places for every receiver: only the values are new; rows are the columns of what is transposed
        self._columns = csc_matrix((np.zeros(index.size), index, pointer), shape=(3 * width, n_rows))

    def transposed(self, by_motion: FloatArray, columns: FloatArray) -> FloatArray:
        """Return the motion's slopes, (n_channels, n_bins, 12), transposed, applied to columns, (n_rows, k)."""
        self._columns.data = by_motion.ravel()
        return np.asarray(self._columns @ columns)
