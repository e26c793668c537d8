"""Damped Gauss-Newton on the joint problem, and its evidence."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import uniform_filter1d

from radargui.correction.joint.normal import NormalMatrix
from radargui.correction.joint.problem import Assembled, JointProblem, Linearised, State, assemble, linearise
from radargui.model.arrays import FloatArray

_LOCAL_BINS = 41
_CLOSE = 0.05
_MOST_DAMPING = 1e3


@dataclass(frozen=True)
class Solution:
    """A state, the problem linearised there, and the factored normal matrix."""

    problem: JointProblem
    state: State
    at: Linearised
    normal: NormalMatrix
    settled: bool


def minimise(problem: JointProblem, state: State, steps: int) -> Solution:
    """Take up to `steps` damped Gauss-Newton steps; stop where a step gains less than 0.05 in cost."""
    at = linearise(problem, state)
    damping, settled = 0.0, False
    assembled = assemble(problem, state, at)
    for _ in range(steps):
        improved, damping = _improve(problem, state, at, assembled, damping)
        if improved is None:
            break
        settled = at.cost - improved[1].cost < _CLOSE
        state, at = improved
        assembled = assemble(problem, state, at)
        if settled:
            break
    return Solution(problem, state, at, assembled.factor(), settled)


def _improve(
    problem: JointProblem, state: State, at: Linearised, assembled: Assembled, damping: float
) -> tuple[tuple[State, Linearised] | None, float]:
    """Return the first of ever more damped steps that lowers the cost, None where none does, and the next damping."""
    while damping <= _MOST_DAMPING:
        trial = _step(problem, state, assembled, damping)
        if trial is not None:
            trial_at = linearise(problem, trial)
            if trial_at.cost <= at.cost:
                return (trial, trial_at), 0.0 if damping <= 1e-4 else damping / 30.0
            if trial_at.cost - at.cost < _CLOSE / 5.0:
                break
        damping = max(10.0 * damping, 1e-4)
    return None, damping


def _step(problem: JointProblem, state: State, assembled: Assembled, damping: float) -> State | None:
    try:
        motion, border = assembled.factor(damping).solve(-assembled.slope_motion, -assembled.slope_border)
    except np.linalg.LinAlgError:
        return None
    theta = state.theta + border
    edge = np.concatenate([problem.spline.edge_s[:1], theta[problem.layout.breaks], problem.spline.edge_s[-1:]])
    if not (np.diff(edge) > 1e-3).all():
        return None
    return State(state.coefficients + motion.reshape(-1, 3), theta)


def log_evidence(solution: Solution) -> float:
    """Return the Laplace approximation of the log evidence, noise scale and jerk deviations included.

    ln E = -cost - ln det H / 2 - sum ln sd_prior - 3 sum ln sd_jerk - sum over the channels' bins of ln noise scale.
    """
    problem = solution.problem
    n_used = int(problem.use.sum())
    return (
        -solution.at.cost
        - 0.5 * solution.normal.log_determinant()
        - float(np.log(problem.prior.sd).sum())
        - 3.0 * float(np.log(problem.jerk_sd).sum())
        - 2.0 * n_used * float(np.log(problem.noise_scale).sum())
    )


def chi_square(solution: Solution) -> FloatArray:
    """Return each receiver's mean squared residual in units of the white noise, shape (n_receivers,)."""
    return np.asarray(local_chi_square(solution)[:, solution.problem.use].mean(axis=1))


def local_chi_square(solution: Solution) -> FloatArray:
    """Return the squared residual of both channels averaged over about 40 bins, shape (n_receivers, n_bins)."""
    problem = solution.problem
    square = np.where(problem.use, solution.at.residual**2 / problem.bins.expected, 1.0)
    pairs = square.reshape(-1, 2, square.shape[1]).mean(axis=1) * problem.noise_scale[:, None] ** 2
    return np.asarray(uniform_filter1d(pairs, _LOCAL_BINS, axis=1, mode="nearest"))
