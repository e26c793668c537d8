"""What the samples alone say about the first flights: the posterior without the smoothness prior, for restitution.

Method 5, Flights.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.linalg import cho_solve, cholesky, solve_triangular
from scipy.sparse import block_array, csr_matrix
from scipy.sparse.linalg import SuperLU, splu

from radargui.estimation.readout.free_motion import FreeMotion
from radargui.estimation.solve.assemble import Assembled, DataSums, assemble, diagonal, equation_slopes
from radargui.estimation.solve.block_tridiagonal import BlockTridiagonal, lower_band
from radargui.estimation.solve.minimise import Solution
from radargui.model.arrays import FloatArray, IntArray
from radargui.model.errors import SolveError

_JITTER = 1e-13
"""Share by which the diagonal of what is eliminated is raised: a hundred times the rounding of its entries."""
_UNSEEN = 1e-10
"""Least curvature of a coefficient against the typical one: what no bin sees stays where it is."""
_UNDETERMINED = "The samples do not determine the motion of the flights."


@dataclass(frozen=True)
class _MotionAfter:
    """The motion's unknowns from `kept` on, eliminated by their block tridiagonal factor L.

    Attributes
    ----------
    kept, touched
        How many unknowns stay, and which of them are coupled.
    factor
        L L^T.
    near, far
        L^-1 of the coupling to those touched and to the global parameters.
    """

    kept: int
    touched: IntArray
    factor: BlockTridiagonal
    near: FloatArray
    far: FloatArray

    @staticmethod
    def of(blocks: Assembled, kept: int) -> _MotionAfter:
        """Eliminate; SolveError where the samples do not determine it."""
        # a cubic spline couples neighbours only: few of those that stay are touched
        coupling = blocks.s[kept:, :kept].tocsc()
        touched = np.flatnonzero(np.diff(coupling.indptr))
        after = blocks.s[kept:, kept:]
        try:
            factor = BlockTridiagonal(lower_band(csr_matrix(after + _JITTER * diagonal(after.diagonal()))))
        except np.linalg.LinAlgError as error:
            raise SolveError(_UNDETERMINED) from error
        half = factor.half_solve(np.concatenate([coupling[:, touched].toarray(), blocks.coupling[kept:]], axis=1))
        return _MotionAfter(kept, touched, factor, half[:, : touched.size], half[:, touched.size :])

    def taken_off(self, blocks: Assembled) -> tuple[csr_matrix, FloatArray, FloatArray]:
        """Return the blocks S, C and M with these unknowns marginalised."""
        kept, touched = self.kept, self.touched
        place = np.repeat(touched, touched.size), np.tile(touched, touched.size)
        near = csr_matrix(((self.near.T @ self.near).ravel(), place), shape=(kept, kept))
        c = blocks.coupling[:kept].copy()
        c[touched] -= self.near.T @ self.far
        return csr_matrix(blocks.s[:kept, :kept] - near), c, blocks.m - self.far.T @ self.far


@dataclass(frozen=True)
class Eliminated:
    """What was eliminated to leave the quadratic form of the first coefficients and breaks.

    Attributes
    ----------
    kept, n_breaks
        Unknowns of the motion and breaks that stay.
    after
        The motion after them; None where all stays.
    root, lost
        Cholesky factor of the global parameters but the breaks, and P.
    """

    kept: int
    n_breaks: int
    after: _MotionAfter | None
    root: FloatArray
    lost: FloatArray

    def marginal(self, slope_motion: FloatArray, slope_global: FloatArray) -> FloatArray:
        """Return what a slope over all unknowns leaves for x: s_x - H_xo H_oo^-1 s_o, o the others, shape (n,)."""
        motion, rest = slope_motion[: self.kept].copy(), slope_global
        if self.after is not None:
            half = self.after.factor.half_solve(slope_motion[self.kept :, None])[:, 0]
            motion[self.after.touched] -= self.after.near.T @ half
            rest = rest - self.after.far.T @ half
        lower = solve_triangular(self.root, rest[self.n_breaks :], lower=True)
        return np.asarray(np.concatenate([motion, rest[: self.n_breaks]]) - self.lost @ lower)


@dataclass(frozen=True)
class QuadraticForm:
    """Lambda = K - P P^T: a band K with columns for the breaks, were the mismatch known, less what that costs.

    Attributes
    ----------
    known, lost
        K and P, shapes (n, n) and (n, n_mismatch).
    """

    known: csr_matrix
    lost: FloatArray

    def times(self, vectors: FloatArray) -> FloatArray:
        """Return Lambda applied to vectors, shape (n,) or (n, m)."""
        return np.asarray(self.known @ vectors - self.lost @ (self.lost.T @ vectors))

    def solve(self, right: FloatArray) -> FloatArray:
        """Return Lambda^-1 of some columns, shape (n, m); what the samples do not see stays near zero.

        (K - P P^T)^-1 = K^-1 + K^-1 P (1 - P^T K^-1 P)^-1 P^T K^-1 (Woodbury).

        Raises
        ------
        SolveError
            K, or what is left of it, is not positive definite.
        """
        factor, lost, root = self._factored
        solved = factor.solve(right)
        return np.asarray(solved + lost @ cho_solve((root, True), self.lost.T @ solved))

    @cached_property
    def _factored(self) -> tuple[SuperLU, FloatArray, FloatArray]:
        """K factored, K^-1 P, and the Cholesky factor of 1 - P^T K^-1 P."""
        scale = self.known.diagonal() - (self.lost**2).sum(axis=1)
        scale = np.maximum(scale, _UNSEEN * float(np.median(scale)))  # no bin may lie under a coefficient
        try:
            factor = splu((self.known + _UNSEEN * diagonal(scale)).tocsc(), permc_spec="MMD_AT_PLUS_A")
        except RuntimeError as error:  # scipy's word for an exactly singular factor
            raise SolveError(_UNDETERMINED) from error
        lost = factor.solve(self.lost)
        return factor, lost, _root(np.eye(lost.shape[1]) - self.lost.T @ lost)


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
        How what is not in x was eliminated.
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
        """Return the same where a solution, and with it its motion, has moved, and the rest of H is what it was."""
        tau, before = solution.state.theta[: self.n_breaks], self.x0[3 * self.size :]
        slope = self.slope.copy()
        slope[3 * self.size :] -= solution.problem.prior.sd[: self.n_breaks] ** -2.0 * (tau - before)
        x0 = np.concatenate([solution.state.coefficients[: self.size].ravel(), tau])
        return replace(self, free=free, x0=x0, slope=slope)


def motion_information(
    solution: Solution, sums: DataSums, free: FreeMotion, size: int, n_breaks: int, lifted: slice
) -> MotionInformation:
    """Marginalise the mismatch and the motion after the first part, and lift the jerk prior from some spans.

    The motion is a band: what lies beyond x is eliminated by its block tridiagonal factor (Schur complement), with a
    cost linear in the record's length; the mismatch is eliminated densely after it. Both are exact.

    Parameters
    ----------
    solution, sums, free
        Converged, what the data say there, and its motion.
    size, n_breaks
        Coefficients per coordinate and breaks to keep.
    lifted
        Spans whose smoothness the caller replaces by an equation of motion; the kept breaks lose their prior too.

    Raises
    ------
    SolveError
        What is marginalised is not determined.
    """
    problem, state = solution.problem, solution.state
    equation = solution.at.equation
    # the equation of flight takes the place of the prior: both would count the same knowledge twice
    replaced = (equation.rows.span >= lifted.start) & (equation.rows.span < lifted.stop)
    without_equation = replace(problem, equation_sd=np.where(replaced, np.inf, problem.equation_sd))
    # an infinite deviation weighs nothing: the prior is lifted there
    blocks = assemble(without_equation, state, solution.at, sums)
    kept, breaks = 3 * size, slice(0, n_breaks)
    band, coupling, constants = blocks.s[:kept, :kept], blocks.coupling[:kept], blocks.m
    after = None
    if kept < blocks.s.shape[0]:
        after = _MotionAfter.of(blocks, kept)
        band, coupling, constants = after.taken_off(blocks)
    # an impact is where two flights meet: its prior, from the adaptive rounds, has done its work
    precision = problem.prior.sd[breaks] ** -2.0
    between = csr_matrix(coupling[:, breaks])
    at_breaks = constants[breaks, breaks] - np.diag(precision)
    known = block_array([[band, between], [between.T, csr_matrix(at_breaks)]], format="csr")
    pulls = np.concatenate([coupling[:, n_breaks:], constants[breaks, n_breaks:]])
    root = _root(constants[n_breaks:, n_breaks:])
    lost = np.ascontiguousarray(solve_triangular(root, pulls.T, lower=True).T)
    tau = state.theta[breaks]
    eliminated = Eliminated(kept, n_breaks, after, root, lost)
    # what is left where a solution is not quite at its minimum counts, too, but not of the breaks: where one passes the
    # node of a bin the cost has a kink, and the slope on one side of it is no pull
    whole = equation_slopes(replace(problem, equation_sd=np.where(replaced, problem.equation_sd, np.inf)), solution.at)
    left = blocks.slope_global + whole[1]
    left[problem.layout.breaks] = 0.0
    slope = eliminated.marginal(blocks.slope_motion, left - whole[1])
    # with the breaks' prior goes its pull
    slope[kept:] -= precision * (tau - problem.prior.mean[breaks])
    x0 = np.concatenate([state.coefficients[:size].ravel(), tau])
    return MotionInformation(free, size, n_breaks, x0, QuadraticForm(csr_matrix(known), lost), slope, eliminated)


def _root(matrix: FloatArray) -> FloatArray:
    try:
        return np.asarray(cholesky(matrix, lower=True))
    except np.linalg.LinAlgError as error:
        raise SolveError(_UNDETERMINED) from error
