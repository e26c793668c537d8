"""What the samples alone say about the first flights: the posterior without the smoothness prior, for restitution."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve, cholesky, solve_triangular
from scipy.sparse import block_array, csr_matrix, eye_array, kron
from scipy.sparse.linalg import splu

from radargui.correction.joint.minimise import Solution
from radargui.correction.joint.motion_spline import MotionSpline
from radargui.correction.joint.normal import BlockTridiagonal
from radargui.correction.joint.problem import Assembled, assemble, diagonal
from radargui.model.arrays import FloatArray

_JITTER = 1e-13
_UNSEEN = 1e-10


@dataclass(frozen=True)
class MotionInformation:
    """Quadratic form of the log likelihood over the first coefficients and break times, all else marginalised.

    -ln L(x) = (x - x0)^T Lambda (x - x0) / 2 + g^T (x - x0), x = (coefficients x, y, z interleaved; breaks). A motion
    that obeys an equation is fitted by inserting its coefficients: no smoothness prior takes part where it is lifted.
    Lambda = K - P P^T: a band K with columns for the breaks, were the mismatch known, less what not knowing it costs.

    Attributes
    ----------
    spline
        The whole motion at x0.
    release_m
        What the coefficients are relative to, shape (3,).
    size, n_breaks
        How many of the spline's first coefficients per coordinate, and of its first breaks, x holds.
    x0
        Shape (3 size + n_breaks,).
    known, lost
        K and P, shapes (n, n) and (n, n_mismatch).
    slope
        g.
    """

    spline: MotionSpline
    release_m: FloatArray
    size: int
    n_breaks: int
    x0: FloatArray
    known: csr_matrix
    lost: FloatArray
    slope: FloatArray

    def times(self, vectors: FloatArray) -> FloatArray:
        """Return Lambda applied to vectors, shape (n,) or (n, m)."""
        return np.asarray(self.known @ vectors - self.lost @ (self.lost.T @ vectors))

    def minimum(self) -> FloatArray:
        """Return x - x0 where -ln L is least; what the samples do not see stays near zero.

        (K - P P^T)^-1 = K^-1 + K^-1 P (1 - P^T K^-1 P)^-1 P^T K^-1.
        """
        scale = self.known.diagonal() - (self.lost**2).sum(axis=1)
        scale = np.maximum(scale, _UNSEEN * float(np.median(scale)))  # no bin may lie under a coefficient
        factor = splu((self.known + _UNSEEN * diagonal(scale)).tocsc(), permc_spec="MMD_AT_PLUS_A")
        solved = factor.solve(np.column_stack([self.slope, self.lost]))
        inner = np.eye(self.lost.shape[1]) - self.lost.T @ solved[:, 1:]
        return np.asarray(
            -solved[:, 0] - solved[:, 1:] @ cho_solve(cho_factor(inner, lower=True), self.lost.T @ solved[:, 0])
        )


def motion_information(solution: Solution, size: int, n_breaks: int, lifted: slice) -> MotionInformation:
    """Marginalise the mismatch and the motion after the first part, and lift the jerk prior from some spans.

    The motion is a band: what lies beyond x is eliminated by its block tridiagonal factor (Schur complement), with a
    cost linear in the record's length; the mismatch is eliminated densely after it. Both are exact.

    Parameters
    ----------
    solution
        Converged.
    size, n_breaks
        Coefficients per coordinate and breaks to keep.
    lifted
        Spans whose smoothness the caller replaces by an equation of motion; the kept breaks lose their prior too.
    """
    problem, state = solution.problem, solution.state
    # made anew: kept with every rival, C would be most of the memory that a long record takes
    blocks = assemble(problem, state, solution.at)
    kept, breaks = 3 * size, slice(0, n_breaks)
    band, coupling, border = blocks.s[:kept, :kept], blocks.c[:kept], blocks.m
    if kept < blocks.s.shape[0]:
        band, coupling, border = _without_motion_after(blocks, kept)
    jerk, _, _ = solution.at.spline.jerk()
    stiffness = np.zeros(problem.jerk_sd.size)
    stiffness[lifted] = problem.jerk_sd[lifted] ** -2.0
    stiff = csr_matrix(jerk.T @ diagonal(stiffness) @ jerk)[:size, :size]
    precision = problem.prior.sd[breaks] ** -2.0
    between = csr_matrix(coupling[:, breaks])
    at_breaks = border[breaks, breaks] - np.diag(precision)
    known = block_array([[band - kron(stiff, eye_array(3)), between], [between.T, csr_matrix(at_breaks)]], format="csr")
    pulls = np.concatenate([coupling[:, n_breaks:], border[breaks, n_breaks:]])
    root = cholesky(border[n_breaks:, n_breaks:], lower=True)
    lost = np.ascontiguousarray(solve_triangular(root, pulls.T, lower=True).T)
    tau = state.theta[breaks]
    slope = np.concatenate(
        [-(stiff @ state.coefficients[:size]).ravel(), -precision * (tau - problem.prior.mean[breaks])]
    )
    x0 = np.concatenate([state.coefficients[:size].ravel(), tau])
    return MotionInformation(
        solution.at.spline, problem.stage.release_m, size, n_breaks, x0, csr_matrix(known), lost, slope
    )


def _without_motion_after(blocks: Assembled, kept: int) -> tuple[csr_matrix, FloatArray, FloatArray]:
    """Return the blocks S, C and M with the motion's unknowns from `kept` on marginalised."""
    coupling = blocks.s[kept:, :kept].tocsc()
    touched = np.flatnonzero(np.diff(coupling.indptr))
    after = blocks.s[kept:, kept:]
    factor = BlockTridiagonal(csr_matrix(after + _JITTER * diagonal(after.diagonal())))
    half = factor.half_solve(np.concatenate([coupling[:, touched].toarray(), blocks.c[kept:]], axis=1))
    near, far = half[:, : touched.size], half[:, touched.size :]
    place = np.repeat(touched, touched.size), np.tile(touched, touched.size)
    band = csr_matrix(blocks.s[:kept, :kept] - csr_matrix(((near.T @ near).ravel(), place), shape=(kept, kept)))
    c = blocks.c[:kept].copy()
    c[touched] -= near.T @ far
    return band, c, blocks.m - far.T @ far
