"""The likelihood of the first flights by the samples alone, without the smoothness prior.

Restitution fits its flights to it. Method 5, Flights.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.linalg import cholesky, solve_triangular
from scipy.linalg.lapack import dpbtrf, dtbtrs

from radargui.estimation.posterior.free_motion import FreeMotion
from radargui.estimation.solve.assemble import DataSums, assemble, equation_slope
from radargui.estimation.solve.minimise import Solution
from radargui.estimation.solve.normal import WIDTH, FactoredNormal, NormalMatrix, band_times
from radargui.model.arrays import FloatArray
from radargui.model.errors import SolveError

_JITTER = 1e-13
"""Share by which the diagonal of what is eliminated is raised: a hundred times the rounding of its entries."""
_UNSEEN = 1e-10
"""Least curvature of a coefficient against the typical one: what no bin sees stays where it is."""
_UNDETERMINED = "The samples do not determine the motion of the flights."


@dataclass(frozen=True)
class _MotionAfter:
    """The motion's unknowns from `kept` on, eliminated: their part of S is L L^T.

    Attributes
    ----------
    kept, touched
        Number of unknowns that stay, and of those among them (the last ones) that are coupled to eliminated ones.
    lower
        L, a band as of `NormalMatrix`.
    near, far
        L^-1 of the coupling to those touched and to the global parameters.
    """

    kept: int
    touched: int
    lower: FloatArray
    near: FloatArray
    far: FloatArray

    @staticmethod
    def of(normal: NormalMatrix, kept: int) -> _MotionAfter:
        """Eliminate; SolveError where the samples do not determine it."""
        band, touched = normal.band[:, kept:].copy(), min(WIDTH - 1, kept)
        band[0] *= 1.0 + _JITTER
        lower, bad = dpbtrf(band, lower=1)
        if bad:
            raise SolveError(_UNDETERMINED)
        near = np.zeros((band.shape[1], touched))
        row, column = np.indices((min(WIDTH - 1, len(near)), touched))
        below = row + touched - column
        is_in = below < WIDTH
        near[row[is_in], column[is_in]] = normal.band[below[is_in], kept - touched + column[is_in]]
        half = dtbtrs(lower, np.concatenate([near, normal.coupling[kept:]], axis=1), uplo="L")[0]
        return _MotionAfter(kept, touched, lower, half[:, :touched], half[:, touched:])

    def taken_off(self, normal: NormalMatrix) -> NormalMatrix:
        """Return H with these unknowns marginalised."""
        band, coupling = normal.band[:, : self.kept].copy(), normal.coupling[: self.kept].copy()
        first = self.kept - self.touched
        row, column = np.tril_indices(self.touched)
        band[row - column, first + column] -= (self.near.T @ self.near)[row, column]
        coupling[first:] -= self.near.T @ self.far
        return NormalMatrix(band, coupling, normal.corner - self.far.T @ self.far)


@dataclass(frozen=True)
class Eliminated:
    """The unknowns that were eliminated, to go back from the quadratic form of the first coefficients and breaks.

    Attributes
    ----------
    n_motion, kept, n_breaks
        Unknowns of the motion, and those of them and of the breaks that stay.
    after
        The motion after them; None where all stays.
    root, lost
        Cholesky factor of the global parameters but the breaks, and P.
    """

    n_motion: int
    kept: int
    n_breaks: int
    after: _MotionAfter | None
    root: FloatArray
    lost: FloatArray

    def marginal(self, slope: FloatArray) -> FloatArray:
        """Return the slope for x, s_x - H_xo H_oo^-1 s_o with o the other unknowns, shape (n,)."""
        motion, rest = slope[: self.kept].copy(), slope[self.n_motion :]
        if self.after is not None:
            half = dtbtrs(self.after.lower, slope[self.kept : self.n_motion], uplo="L")[0]
            motion[self.kept - self.after.touched :] -= self.after.near.T @ half
            rest = rest - self.after.far.T @ half
        lower = solve_triangular(self.root, rest[self.n_breaks :], lower=True)
        return np.asarray(np.concatenate([motion, rest[: self.n_breaks]]) - self.lost @ lower)


@dataclass(frozen=True)
class QuadraticForm:
    """Lambda = K - P P^T, with K for coefficients and breaks at known mismatch, and P P^T lost by marginalising that.

    Attributes
    ----------
    normal
        K with the mismatch as the last of its border.
    lost
        P, shape (n, n_mismatch).
    """

    normal: NormalMatrix
    lost: FloatArray

    def times(self, vectors: FloatArray) -> FloatArray:
        """Return Lambda applied to vectors, shape (n,) or (n, m)."""
        n_motion, n_breaks = self._sizes
        motion, breaks = vectors[:n_motion], vectors[n_motion:]
        coupling = self.normal.coupling[:, :n_breaks]
        known = [
            band_times(self.normal.band, motion) + coupling @ breaks,
            coupling.T @ motion + self.normal.corner[:n_breaks, :n_breaks] @ breaks,
        ]
        return np.asarray(np.concatenate(known) - self.lost @ (self.lost.T @ vectors))

    def solve(self, right: FloatArray) -> FloatArray:
        """Return Lambda^-1 of some columns, shape (n, m); what the samples do not see stays near zero.

        Raises
        ------
        SolveError
            K, or what is left of it, is not positive definite.
        """
        # Lambda is what is left of x where the mismatch is marginalised: it is solved for together with x
        padded = np.concatenate([right, np.zeros((self.lost.shape[1], right.shape[1]))])
        return self._factored.solve(padded)[: len(right)]

    @property
    def _sizes(self) -> tuple[int, int]:
        """How many unknowns of the motion, and how many breaks."""
        n_motion = len(self.normal.coupling)
        return n_motion, len(self.lost) - n_motion

    @cached_property
    def _factored(self) -> FactoredNormal:
        n_motion, n_breaks = self._sizes
        band, corner, breaks = self.normal.band.copy(), self.normal.corner.copy(), np.arange(n_breaks)
        scale = np.concatenate([band[0], corner[breaks, breaks]]) - (self.lost**2).sum(axis=1)
        added = _UNSEEN * np.maximum(scale, _UNSEEN * float(np.median(scale)))  # no bin may lie under a coefficient
        band[0] += added[:n_motion]
        corner[breaks, breaks] += added[n_motion:]
        return replace(self.normal, band=band, corner=corner).factor()


@dataclass(frozen=True)
class MotionInformation:
    """Quadratic form of the log likelihood over the first coefficients and break times, all else marginalised.

    -ln L(x) = (x - x0)^T Lambda (x - x0) / 2 + g^T (x - x0), x = (coefficients x, y, z interleaved; breaks). A motion
    that obeys an equation is fitted by inserting its coefficients: no smoothness prior takes part where it is lifted.

    Attributes
    ----------
    free
        The whole motion at x0.
    size, n_breaks
        How many of the spline's first coefficients per coordinate, and of its first breaks, x holds.
    x0
        Shape (3 size + n_breaks,).
    form
        Lambda.
    slope
        g.
    eliminated
        The elimination of all that is not in x.
    """

    free: FreeMotion
    size: int
    n_breaks: int
    x0: FloatArray
    form: QuadraticForm
    slope: FloatArray
    eliminated: Eliminated

    def minimum(self) -> FloatArray:
        """Return x - x0 where -ln L is least; errors as for `QuadraticForm.solve`."""
        return -self.form.solve(self.slope[:, None])[:, 0]

    def moved(self, solution: Solution, free: FreeMotion) -> MotionInformation:
        """Return the same after a solution and its motion have moved, with H otherwise unchanged."""
        tau, before = solution.state.theta[: self.n_breaks], self.x0[3 * self.size :]
        slope = self.slope.copy()
        slope[3 * self.size :] -= solution.problem.prior.sd[: self.n_breaks] ** -2.0 * (tau - before)
        x0 = np.concatenate([solution.state.coefficients[: self.size].ravel(), tau])
        return replace(self, free=free, x0=x0, slope=slope)


def motion_information(
    solution: Solution, sums: DataSums, free: FreeMotion, size: int, n_breaks: int, lifted: slice
) -> MotionInformation:
    """Marginalise the mismatch and the motion after the first part, and lift the jerk prior from some spans.

    The motion is a band: what lies beyond x is eliminated by its factor (Schur complement), the mismatch densely after
    it. Both are exact.

    Parameters
    ----------
    solution, sums, free
        The converged solution, the sums over the data there, and its motion.
    size, n_breaks
        Coefficients per coordinate and breaks to keep.
    lifted
        Spans whose smoothness the caller replaces by an equation of motion; the kept breaks lose their prior too.

    Raises
    ------
    SolveError
        The samples do not determine what is marginalised.
    """
    problem, state = solution.problem, solution.state
    equation = solution.at.equation
    # the equation of flight takes the place of the prior: both would count the same knowledge twice
    replaced = (equation.rows.span >= lifted.start) & (equation.rows.span < lifted.stop)
    without_equation = replace(problem, equation_sd=np.where(replaced, np.inf, problem.equation_sd))
    # an infinite deviation weighs nothing: the prior is lifted there
    assembled = assemble(without_equation, state, solution.at, sums)
    normal, slope, breaks = assembled.normal, assembled.slope.copy(), slice(0, n_breaks)
    n_motion, kept, after = len(normal.coupling), 3 * size, None
    if kept < n_motion:
        after = _MotionAfter.of(normal, kept)
        normal = after.taken_off(normal)
    # an impact is where two flights meet: its prior, from the adaptive rounds, has done its work
    precision, corner = problem.prior.sd[breaks] ** -2.0, normal.corner.copy()
    corner[np.arange(n_breaks), np.arange(n_breaks)] -= precision
    normal = replace(normal, corner=corner)
    pulls = np.concatenate([normal.coupling[:, n_breaks:], corner[breaks, n_breaks:]])
    root = _root(corner[n_breaks:, n_breaks:])
    lost = np.ascontiguousarray(solve_triangular(root, pulls.T, lower=True).T)
    eliminated = Eliminated(n_motion, kept, n_breaks, after, root, lost)
    # what is left where a solution is not quite at its minimum counts, too, but not of the breaks: where one passes the
    # node of a bin the cost has a kink, and the slope on one side of it is no pull
    whole = equation_slope(replace(problem, equation_sd=np.where(replaced, problem.equation_sd, np.inf)), solution.at)
    at_breaks = n_motion + np.arange(problem.layout.breaks.stop)
    slope[at_breaks] = -whole[at_breaks]
    slope = eliminated.marginal(slope)
    # with the breaks' prior goes its pull
    tau = state.theta[breaks]
    slope[kept:] -= precision * (tau - problem.prior.mean[breaks])
    x0 = np.concatenate([state.coefficients[:size].ravel(), tau])
    return MotionInformation(free, size, n_breaks, x0, QuadraticForm(normal, lost), slope, eliminated)


def _root(matrix: FloatArray) -> FloatArray:
    try:
        return np.asarray(cholesky(matrix, lower=True))
    except np.linalg.LinAlgError as error:
        raise SolveError(_UNDETERMINED) from error
