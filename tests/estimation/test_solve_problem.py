"""Cost, slope and normal matrix of the joint problem against finite differences and dense algebra."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.normal_matrices import dense_normal
from support.small_problem import FLOOR_PLANE, SmallProblem, small_problem

from radargui.estimation.forward.slow_noise import Drift
from radargui.estimation.solve.assemble import assemble
from radargui.estimation.solve.problem import State, linearise
from radargui.model.errors import SolveError


def stacked(state: State) -> np.ndarray:
    return np.concatenate([state.coefficients.ravel(), state.theta])


def unstacked(vector: np.ndarray, like: State) -> State:
    count = like.coefficients.size
    return State(vector[:count].reshape(-1, 3), vector[count:])


@pytest.fixture(scope="module")
def made() -> SmallProblem:
    drift = Drift(0.0, 0.45, 4, np.full((6, 4), 0.05), np.zeros(6))
    return small_problem((FLOOR_PLANE,), reflection=0.1, delay_s=5e-5, drift=drift, n_bins=120)


@pytest.fixture(scope="module")
def fine() -> SmallProblem:
    """Bins of a tenth of a knot: B at their middle is B at their nodes."""
    return small_problem((FLOOR_PLANE,), reflection=0.1, n_bins=450)


def test_the_slope_of_the_cost_equals_finite_differences_in_every_global_parameter(fine: SmallProblem) -> None:
    start = fine.away(0.3)
    # coefficients drawn like these jerk a thousand times as much as the prior allows, and what the prior then says of a
    # break's time is left out of the slope; in a motion that it allows it would move a break by a nanosecond
    problem = replace(start.problem, equation_sd=1e3 * start.problem.equation_sd)
    at = linearise(problem, start.state)
    blocks = assemble(problem, start.state, at)
    theta = start.state.theta
    for place in range(theta.size):
        step = 1e-7 * np.eye(theta.size)[place]
        up, down = (linearise(problem, State(start.state.coefficients, theta + sign * step)).cost for sign in (1, -1))
        # half the cost's curvature in this place is how far one sigma reaches: a slope is known against it
        scale = np.sqrt(blocks.normal.corner[place, place])
        assert blocks.slope[start.state.coefficients.size + place] == pytest.approx(
            (up - down) / 2e-7, rel=2e-3, abs=0.05 * scale
        )


def test_the_slope_of_the_cost_equals_finite_differences_in_the_motion(fine: SmallProblem) -> None:
    start = fine.away(0.3)
    at = linearise(start.problem, start.state)
    vector = start.state.coefficients.ravel()
    slope = assemble(start.problem, start.state, at).slope[: vector.size]
    for place in np.random.default_rng(2).choice(vector.size, 25, replace=False):
        step = 1e-8 * np.eye(vector.size)[place]
        up, down = (
            linearise(start.problem, State((vector + sign * step).reshape(-1, 3), start.state.theta)).cost
            for sign in (1, -1)
        )
        assert slope[place] == pytest.approx((up - down) / 2e-8, rel=5e-3, abs=2e-3 * np.abs(slope).max())


def test_the_normal_matrix_is_that_of_a_dense_jacobian(made: SmallProblem) -> None:
    problem, state = made.problem, made.truth
    at = linearise(problem, state)
    vector, columns = stacked(state), []
    for place in range(vector.size):
        step = np.zeros(vector.size)
        step[place] = 1e-7
        values = [
            np.concatenate([s.value for s in linearise(problem, unstacked(vector + sign * step, state)).signals])
            for sign in (1, -1)
        ]
        columns.append(((values[0] - values[1]) / 2e-7).ravel())
    jacobian = np.array(columns).T
    wanted = jacobian.T @ (at.weight.ravel()[:, None] * jacobian)
    equation = at.equation.rows.rows.matrix.toarray()
    jerk = np.kron(equation.T @ np.diag(problem.equation_sd**-2.0) @ equation, np.eye(3))
    count = state.coefficients.size
    wanted[:count, :count] += jerk
    wanted[count:, count:] += np.diag(problem.prior.sd**-2.0)
    found = dense_normal(assemble(problem, state, at).normal)
    scale = np.sqrt(np.outer(np.diag(wanted), np.diag(wanted)))
    # B is taken at the middle of a bin, not at its nodes: some per cent where bins are as long as a third of a knot
    assert np.abs((found - wanted) / scale).max() < 0.05
    assert np.abs((found - wanted) / scale)[count + 1 :, count + 1 :].max() < 1e-5


def test_outliers_count_by_their_size_and_bins_that_hold_a_break_not_at_all(made: SmallProblem) -> None:
    problem = made.problem
    value = problem.bins.value.copy()
    value[0, 30] += 1.0
    shifted = replace(problem, bins=replace(problem.bins, value=value))
    before, after = linearise(problem, made.truth), linearise(shifted, made.truth)
    sigmas = abs(after.residual[0, 30])
    assert sigmas > 50.0
    assert after.cost - before.cost == pytest.approx(4.0 * sigmas - 8.0, rel=0.05)
    assert after.weight[0, 30] * problem.bins.sigma[0, 30] ** 2 == pytest.approx(4.0 / sigmas)
    unused = replace(shifted, use=np.arange(problem.bins.n_bins) != 30)
    assert linearise(unused, made.truth).weight[0, 30] == 0.0


def test_a_matrix_that_cannot_be_factored_raises_the_solvers_own_error(made: SmallProblem) -> None:
    blocks = assemble(made.problem, made.truth, linearise(made.problem, made.truth))
    normal = blocks.normal
    with pytest.raises(SolveError, match="not positive definite"):
        replace(blocks, normal=replace(normal, corner=-normal.corner)).factor()
    with pytest.raises(SolveError, match="not positive definite"):
        replace(blocks, normal=replace(normal, band=-normal.band)).factor(5)
