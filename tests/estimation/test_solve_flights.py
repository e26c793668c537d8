"""The normal matrix of a motion with two breaks that flies: data and equation of flight against a dense Jacobian."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.sparse import eye_array, kron
from support.normal_matrices import dense_normal
from support.small_problem import BOUNCE_S, FLOOR_PLANE, small_problem

from radargui.estimation.forward.equation_of_motion import EquationDeviation, EquationRows
from radargui.estimation.forward.signal_slopes import receiver_slopes
from radargui.estimation.forward.slow_noise import Drift
from radargui.estimation.solve.assemble import assemble
from radargui.estimation.solve.changed_problem import problem_with_flights
from radargui.estimation.solve.minimise import Solution, solved_at
from radargui.estimation.solve.problem import Start, State


@pytest.fixture(scope="module", params=[0, 2], ids=["white noise", "slow noise"])
def solution(request: pytest.FixtureRequest) -> Solution:
    """A fall, a bounce, and a flight that a break parts in two; gravity and the motion a little off."""
    drift = Drift(0.0, 0.45, request.param, np.full((6, request.param), 0.05), np.zeros(6)) if request.param else None
    made = small_problem(
        (FLOOR_PLANE,), reflection=0.1, n_bins=160, delay_s=5e-5, breaks_s=(BOUNCE_S, 0.35), drift=drift
    )
    flies = problem_with_flights(solved_at(made.start))
    assert flies is not None
    rng, theta = np.random.default_rng(3), flies.state.theta.copy()
    # without drag: what it changes with the motion itself, a thousandth, Gauss-Newton leaves out
    theta[flies.problem.layout.flight] += [0.1, -0.2, 0.3, 0.0]
    coefficients = flies.state.coefficients + 1e-5 * rng.standard_normal(flies.state.coefficients.shape)
    equation_sd = flies.problem.equation_sd * rng.uniform(0.5, 2.0, flies.problem.equation_sd.size)
    return solved_at(Start(replace(flies.problem, equation_sd=equation_sd), State(coefficients, theta)))


def deviations(solution: Solution, coefficients: np.ndarray, theta: np.ndarray) -> np.ndarray:
    """Return what a motion deviates from its equation, (n_rows, 3), at other breaks, gravity and drag."""
    problem, layout = solution.problem, solution.problem.layout
    spline = problem.spline.with_breaks(theta[layout.breaks])
    rows = EquationRows.of(spline, problem.in_flight)
    return EquationDeviation.of(rows, coefficients, theta[layout.flight], 0.0, spline.break_s.size).value


def dense_of(solution: Solution) -> tuple[np.ndarray, np.ndarray]:
    """Return the dense normal matrix and the slope of data, equation and priors."""
    problem, at, state = solution.problem, solution.at, solution.state
    layout, n_bins, theta = problem.layout, problem.bins.n_bins, state.theta
    motion = kron(at.design, eye_array(3)).toarray().reshape(n_bins, 3, -1)
    breaks = at.spline.break_slopes(problem.bins.time_s, state.coefficients).toarray().reshape(n_bins, 3, -1)
    count, rows, misfit = motion.shape[2], [], []
    for n, own in enumerate(layout.receivers):
        pair = slice(2 * n, 2 * n + 2)
        slopes = receiver_slopes(at.node_m[:, pair], theta, layout, problem.inputs, n, at.excess[pair])
        for channel in range(2):
            row, by_place = np.zeros((n_bins, count + layout.size)), slopes.by_position[channel]
            row[:, :count] = np.einsum("an,nak->nk", by_place, motion)
            of_global = row[:, count:]
            of_global[:, layout.breaks] += np.einsum("an,nak->nk", by_place, breaks)
            of_global[:, layout.shared] += slopes.by_shared[channel]
            of_global[:, own.without_drift] += slopes.by_own[channel]
            of_global[:, (own.drift_i, own.drift_q)[channel]] += problem.inputs.drift[2 * n + channel]
            rows.append(row)
            misfit.append(at.signals[n].value[channel] - problem.bins.value[2 * n + channel])
    jacobian, weight = np.concatenate(rows), at.weight.ravel()
    hessian = jacobian.T @ (weight[:, None] * jacobian)
    slope = jacobian.T @ (weight * np.concatenate(misfit))
    # the equation by differences; a jerk outside of flights is not followed to its breaks
    vector, step = np.concatenate([state.coefficients.ravel(), theta]), 1e-6
    columns = []
    for place in [*range(count), *(count + np.r_[layout.breaks, layout.flight])]:
        sides = []
        for sign in (1.0, -1.0):
            moved = vector.copy()
            moved[place] += sign * step
            sides.append(deviations(solution, moved[:count].reshape(-1, 3), moved[count:]))
        columns.append((sides[0] - sides[1]) / (2.0 * step))
    places = np.r_[np.arange(count), count + np.r_[layout.breaks, layout.flight]]
    by_equation = np.zeros((*at.equation.value.shape, vector.size))
    by_equation[:, :, places] = np.stack(columns, axis=-1)
    of_breaks = slice(count, count + layout.breaks.stop)
    by_equation[~at.equation.rows.is_flight, :, of_breaks] = 0.0
    precision = problem.equation_sd**-2.0
    hessian += np.einsum("nai,n,naj->ij", by_equation, precision, by_equation)
    slope += np.einsum("nai,n,na->i", by_equation, precision, at.equation.value)
    prior = problem.prior
    hessian[count:, count:] += np.diag(prior.sd**-2.0)
    slope[count:] += (theta - prior.mean) / prior.sd**2
    return hessian, slope


def test_the_normal_matrix_of_flights_is_that_of_the_dense_jacobian(solution: Solution) -> None:
    problem, state = solution.problem, solution.state
    assert problem.layout.sizes.breaks == 2
    assert solution.at.equation.rows.is_flight.sum() > 20
    blocks = assemble(problem, state, solution.at)
    found = dense_normal(blocks.normal)
    hessian, slope = dense_of(solution)
    scale = np.sqrt(np.outer(np.diag(hessian), np.diag(hessian)))
    assert np.abs((found - hessian) / scale).max() < 1e-5
    pulls = blocks.slope
    assert (
        np.abs((pulls - slope) / np.sqrt(np.diag(hessian))).max()
        < 1e-4 * np.abs(slope / np.sqrt(np.diag(hessian))).max()
    )
