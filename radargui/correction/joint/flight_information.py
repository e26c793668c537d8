"""What the samples alone say about the first flights: the posterior without the smoothness prior, for restitution."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve
from scipy.sparse import csr_matrix, eye_array, kron

from radargui.correction.joint.minimise import Solution
from radargui.correction.joint.motion_spline import MotionSpline
from radargui.correction.joint.normal import BlockTridiagonal
from radargui.correction.joint.problem import diagonal
from radargui.model.arrays import FloatArray

_JITTER = 1e-13


@dataclass(frozen=True)
class MotionInformation:
    """Quadratic form of the log likelihood over the first coefficients and break times, all else marginalised.

    -ln L(x) = (x - x0)^T Lambda (x - x0) / 2 + g^T (x - x0), x = (coefficients x, y, z interleaved; breaks). A motion
    that obeys an equation is fitted by inserting its coefficients: no smoothness prior takes part where it is lifted.

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
    matrix, slope
        Lambda and g.
    """

    spline: MotionSpline
    release_m: FloatArray
    size: int
    n_breaks: int
    x0: FloatArray
    matrix: FloatArray
    slope: FloatArray


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
    problem, state, blocks = solution.problem, solution.state, solution.assembled
    kept, breaks = 3 * size, slice(0, n_breaks)
    stop, whole = kept + n_breaks, kept + problem.layout.size
    matrix = np.empty((whole, whole))
    matrix[:kept, :kept] = blocks.s[:kept, :kept].toarray()
    matrix[:kept, kept:] = blocks.c[:kept]
    matrix[kept:, :kept] = blocks.c[:kept].T
    matrix[kept:, kept:] = blocks.m
    _eliminate_motion_after(solution, kept, matrix)
    matrix = _without_last(matrix, stop)
    jerk, _, _ = solution.at.spline.jerk()
    stiffness = np.zeros(problem.jerk_sd.size)
    stiffness[lifted] = problem.jerk_sd[lifted] ** -2.0
    stiff = csr_matrix(jerk.T @ diagonal(stiffness) @ jerk)[:size, :size]
    matrix[:kept, :kept] -= kron(stiff, eye_array(3)).toarray()
    precision = problem.prior.sd[breaks] ** -2.0
    matrix[np.arange(kept, stop), np.arange(kept, stop)] -= precision
    tau = state.theta[breaks]
    slope = np.concatenate(
        [-(stiff @ state.coefficients[:size]).ravel(), -precision * (tau - problem.prior.mean[breaks])]
    )
    x0 = np.concatenate([state.coefficients[:size].ravel(), tau])
    return MotionInformation(solution.at.spline, problem.stage.release_m, size, n_breaks, x0, matrix, slope)


def _eliminate_motion_after(solution: Solution, kept: int, matrix: FloatArray) -> None:
    """Subtract the Schur complement of the motion's unknowns from `kept` on, in place."""
    blocks = solution.assembled
    if kept == blocks.s.shape[0]:
        return
    coupling = blocks.s[kept:, :kept].tocsc()
    touched = np.flatnonzero(np.diff(coupling.indptr))
    after = blocks.s[kept:, kept:]
    factor = BlockTridiagonal(csr_matrix(after + _JITTER * diagonal(after.diagonal())))
    half = factor.half_solve(np.concatenate([coupling[:, touched].toarray(), blocks.c[kept:]], axis=1))
    place = np.concatenate([touched, np.arange(kept, matrix.shape[0])])
    matrix[np.ix_(place, place)] -= half.T @ half


def _without_last(matrix: FloatArray, stop: int) -> FloatArray:
    """Return the information on the first unknowns, those from `stop` on marginalised."""
    coupling = matrix[:stop, stop:]
    return np.asarray(
        matrix[:stop, :stop] - coupling @ cho_solve(cho_factor(matrix[stop:, stop:], lower=True), coupling.T)
    )
