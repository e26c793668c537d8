"""What the samples alone say about the motion: the posterior without the smoothness prior, for restitution."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve
from scipy.sparse import eye_array, kron

from radargui.correction.joint.minimise import Solution
from radargui.correction.joint.motion_spline import MotionSpline
from radargui.correction.joint.problem import diagonal
from radargui.model.arrays import BoolArray, FloatArray


@dataclass(frozen=True)
class MotionInformation:
    """Quadratic form of the log likelihood over spline coefficients and break times, mismatch marginalised.

    -ln L(x) = (x - x0)^T Lambda (x - x0) / 2 + g^T (x - x0), x = (coefficients x, y, z interleaved; breaks). A motion
    that obeys an equation is fitted by inserting its coefficients: no smoothness prior takes part where it is lifted.

    Attributes
    ----------
    spline
        The motion at x0.
    release_m
        What the coefficients are relative to, shape (3,).
    x0
        Shape (3 size + n_breaks,).
    matrix, slope
        Lambda and g.
    span_jerk
        Root mean square jerk of each span, m/s^3.
    """

    spline: MotionSpline
    release_m: FloatArray
    x0: FloatArray
    matrix: FloatArray
    slope: FloatArray
    span_jerk: FloatArray


def motion_information(solution: Solution, lifted: BoolArray) -> MotionInformation:
    """Marginalise the mismatch and lift the jerk prior from some spans.

    Parameters
    ----------
    solution
        Converged.
    lifted
        Spans (n_spans,) whose smoothness the caller replaces by an equation of motion.
    """
    problem, state, blocks = solution.problem, solution.state, solution.assembled
    size, breaks = blocks.s.shape[0], problem.layout.breaks
    n_breaks = breaks.stop - breaks.start
    nuisance = np.arange(breaks.stop, problem.layout.size)
    matrix = np.empty((size + n_breaks, size + n_breaks))
    matrix[:size, :size] = blocks.s.toarray()
    matrix[:size, size:] = blocks.c[:, breaks]
    matrix[size:, :size] = blocks.c[:, breaks].T
    matrix[size:, size:] = blocks.m[breaks, breaks]
    coupling = np.concatenate([blocks.c[:, nuisance], blocks.m[breaks, nuisance]])
    matrix -= coupling @ cho_solve(cho_factor(blocks.m[np.ix_(nuisance, nuisance)], lower=True), coupling.T)
    jerk, _, _ = solution.at.spline.jerk()
    stiff = jerk.T @ diagonal(np.where(lifted, problem.jerk_sd**-2.0, 0.0)) @ jerk
    matrix[:size, :size] -= kron(stiff, eye_array(3)).toarray()
    precision = problem.prior.sd[breaks] ** -2.0
    matrix[np.arange(size, size + n_breaks), np.arange(size, size + n_breaks)] -= precision
    tau = state.theta[breaks]
    slope = np.concatenate([-(stiff @ state.coefficients).ravel(), -precision * (tau - problem.prior.mean[breaks])])
    value = jerk @ state.coefficients
    return MotionInformation(
        solution.at.spline,
        problem.stage.release_m,
        np.concatenate([state.coefficients.ravel(), tau]),
        matrix,
        slope,
        np.sqrt((value**2).mean(axis=1)),
    )
