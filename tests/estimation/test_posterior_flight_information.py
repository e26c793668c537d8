"""What the samples say about the first flights: against the dense normal matrix of a small problem."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.normal_matrices import dense_normal
from support.small_problem import FLOOR_PLANE, small_problem

from radargui.estimation.posterior.flight_information import MotionInformation, QuadraticForm
from radargui.estimation.posterior.motion_posterior import MotionPosterior
from radargui.estimation.solve.assemble import assemble
from radargui.estimation.solve.changed_problem import problem_with_flights
from radargui.estimation.solve.minimise import Solution, minimise
from radargui.estimation.solve.normal import NormalMatrix
from radargui.estimation.solve.problem import State
from radargui.model.errors import SolveError


@pytest.fixture(scope="module")
def solution() -> Solution:
    """A fall and a rebound that fly, not quite at the minimum: slopes are left."""
    flies = problem_with_flights(minimise(small_problem((FLOOR_PLANE,), reflection=0.1, n_bins=120).start, 2))
    assert flies is not None
    return minimise(flies, 1)


def dense_of(solution: Solution, lifted: slice) -> tuple[np.ndarray, np.ndarray]:
    """Return the normal matrix and the slope without the equation of some spans, and no pull of a break's kink."""
    problem, rows = solution.problem, solution.at.equation.rows
    off = (rows.span >= lifted.start) & (rows.span < lifted.stop)
    free = replace(problem, equation_sd=np.where(off, np.inf, problem.equation_sd))
    blocks, held = (assemble(one, solution.state, solution.at) for one in (free, problem))
    whole = dense_normal(blocks.normal)
    slope, at_breaks = blocks.slope.copy(), len(blocks.normal.coupling) + np.arange(problem.layout.breaks.stop)
    slope[at_breaks] -= held.slope[at_breaks]
    return whole, slope


def spans_of(solution: Solution) -> slice:
    first = int(np.flatnonzero(solution.problem.in_flight)[0])
    return slice(first, sum(solution.at.spline.spans))


@pytest.mark.parametrize("fewer", [0, 12], ids=["the whole motion", "its first part"])
def test_the_form_and_its_slope_are_the_dense_marginal_over_everything_else(solution: Solution, fewer: int) -> None:
    size, spline = solution.at.spline.size - fewer, solution.at.spline
    information = MotionPosterior(solution, 0.05).information(size, 1, spans_of(solution))
    whole, slope = dense_of(solution, spans_of(solution))
    n_motion, count = 3 * spline.size, 3 * size
    x = np.append(np.arange(count), n_motion)
    rest = np.setdiff1d(np.arange(len(whole)), x)
    through = np.linalg.solve(whole[np.ix_(rest, rest)], whole[np.ix_(rest, x)])
    wanted = whole[np.ix_(x, x)] - whole[np.ix_(x, rest)] @ through
    pull = slope[x] - through.T @ slope[rest]
    # an impact is where two flights meet: its own prior is lifted, too
    precision = solution.problem.prior.sd[0] ** -2.0
    wanted[-1, -1] -= precision
    pull[-1] -= precision * (solution.state.theta[0] - solution.problem.prior.mean[0])
    scale = np.sqrt(np.outer(np.diag(wanted), np.diag(wanted)))
    assert np.abs((information.form.times(np.eye(x.size)) - wanted) / scale).max() < 1e-7
    assert information.slope == pytest.approx(pull, rel=1e-6, abs=1e-6 * np.abs(pull).max())
    assert information.x0[:-1].reshape(-1, 3).tolist() == solution.state.coefficients[:size].tolist()
    assert information.x0[-1] == solution.state.theta[0]
    # any other slope is marginalised the same way
    rng = np.random.default_rng(2)
    other = rng.standard_normal(len(whole))
    found = information.eliminated.marginal(other)
    marginal = other[x] - through.T @ other[rest]
    assert found == pytest.approx(marginal, rel=1e-6, abs=1e-6 * np.abs(marginal).max())


def form_of(band: np.ndarray, lost: np.ndarray) -> QuadraticForm:
    """Return a form without breaks, its mismatch in units of its own deviation."""
    return QuadraticForm(NormalMatrix(band, lost, np.eye(lost.shape[1])), lost)


def test_a_solve_is_that_of_the_dense_form_and_leaves_what_no_bin_sees() -> None:
    rng = np.random.default_rng(4)
    root = rng.standard_normal((12, 12))
    known, lost = root @ root.T + 12.0 * np.eye(12), rng.standard_normal((12, 3))
    band = np.zeros((12, 13))
    for below in range(12):
        band[below, : 12 - below] = np.diagonal(known, -below)
    form = form_of(band[:, :12], lost)
    right = rng.standard_normal((12, 2))
    dense = known - lost @ lost.T
    assert np.linalg.eigvalsh(dense).min() > 0.0
    assert form.solve(right) == pytest.approx(np.linalg.solve(dense, right), rel=1e-6)
    assert form.times(form.solve(right)) == pytest.approx(right, abs=1e-6)
    # a coefficient that nothing touches stays where it is, and the others do not notice
    wider = form_of(band, np.vstack([lost, np.zeros((1, 3))]))
    found = wider.solve(np.vstack([right, np.zeros((1, 2))]))
    assert found[:12] == pytest.approx(np.linalg.solve(dense, right), rel=1e-6)
    assert found[12].tolist() == [0.0, 0.0]
    with pytest.raises(SolveError, match="not positive definite"):
        form_of(band[:, :12], 10.0 * lost).solve(right)


def test_the_minimum_is_where_the_form_and_its_slope_say(solution: Solution) -> None:
    information = MotionPosterior(solution, 0.05).information(solution.at.spline.size, 1, slice(0, 0))
    away = information.minimum()
    assert information.form.times(away) == pytest.approx(-information.slope, abs=1e-5 * np.abs(information.slope).max())
    # nothing was lifted but the break's prior: it is the step of Gauss and Newton from which its pull is missing
    assert np.abs(away).max() > 0.0


def test_a_solution_that_was_moved_keeps_the_form_and_moves_what_the_breaks_prior_pulls(solution: Solution) -> None:
    posterior = MotionPosterior(solution, 0.05)
    information: MotionInformation = posterior.information(solution.at.spline.size - 12, 1, spans_of(solution))
    theta = solution.state.theta.copy()
    theta[0] += 1e-4
    there = replace(solution, state=State(solution.state.coefficients + 1e-5, theta))
    moved = MotionPosterior(there, 0.05, posterior).information(solution.at.spline.size - 12, 1, spans_of(solution))
    assert moved.form is information.form
    assert moved.x0 == pytest.approx(information.x0 + np.append(np.full(information.x0.size - 1, 1e-5), 1e-4))
    pull = moved.slope - information.slope
    assert pull[:-1].tolist() == [0.0] * (pull.size - 1)
    assert pull[-1] == pytest.approx(-(solution.problem.prior.sd[0] ** -2.0) * 1e-4)
    assert moved.free.position_m(np.array([0.2])) != pytest.approx(
        information.free.position_m(np.array([0.2])), abs=1e-9
    )
