"""A solution on fewer bins says what it says on all of them, and comes back unchanged."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.small_problem import BOUNCE_S, FLOOR_PLANE, SmallProblem, small_problem

from radargui.estimation.forward.bins import weighted_means
from radargui.estimation.select.fewer_bins import with_bins_of, with_fewer_bins
from radargui.estimation.solve.minimise import Solution, log_evidence, solved_at
from radargui.estimation.solve.problem import Start


@pytest.fixture(scope="module")
def made() -> SmallProblem:
    """Bins of 0.3 ms, 1/24 fringe where it is fastest."""
    return small_problem((FLOOR_PLANE,), reflection=0.2, n_bins=1500)


@pytest.fixture(scope="module")
def fewer(made: SmallProblem) -> Solution:
    return solved_at(with_fewer_bins(made.start, 3))


def test_what_fewer_bins_should_show_is_the_mean_of_what_the_bins_should(made: SmallProblem, fewer: Solution) -> None:
    whole, bins = solved_at(made.start), fewer.problem.bins
    begin = np.searchsorted(made.data.bins.first_s, bins.first_s)
    assert bins.n_bins < 0.4 * made.data.bins.n_bins
    for many, few in zip(whole.at.signals, fewer.at.signals, strict=True):
        mean = weighted_means(many.value, made.data.bins.count, begin)
        # the two nodes of 1/8 fringe, and maps that count as constant over it
        assert np.abs(few.value - mean)[:, fewer.problem.use].max() < 3e-4


def test_a_bin_that_does_not_count_stays_apart_and_so_does_what_lies_behind_a_break(
    made: SmallProblem, fewer: Solution
) -> None:
    use, bins = fewer.problem.use, fewer.problem.bins
    assert bins.count[~use].sum() == made.data.bins.count[~made.start.problem.use].sum()
    assert ((bins.last_s < BOUNCE_S) | (bins.first_s > BOUNCE_S))[use].all()


def test_bins_stay_as_they_are_where_the_noise_would_show_what_fewer_are_off_by() -> None:
    quiet = small_problem(n_bins=600, sigma=1e-5)
    assert with_fewer_bins(quiet.start, 3).problem.bins.n_bins == 600


def test_what_a_change_costs_is_the_same_on_fewer_bins(made: SmallProblem) -> None:
    def cost(most: int) -> float:
        at_truth = made.start
        theta = at_truth.state.theta.copy()
        theta[at_truth.problem.layout.transmitter_reflection] *= 0.98
        beside = Start(at_truth.problem, replace(at_truth.state, theta=theta))
        first, second = (log_evidence(solved_at(with_fewer_bins(one, most))) for one in (at_truth, beside))
        return first - second

    assert 20.0 < cost(3) == pytest.approx(cost(1), rel=0.05)


def test_back_on_all_bins_a_solution_is_what_it_was(made: SmallProblem, fewer: Solution) -> None:
    back, whole = with_bins_of(fewer, made.start.problem), solved_at(made.start)
    assert back.problem.bins is made.data.bins
    assert back.at.cost == pytest.approx(whole.at.cost, abs=0.01)
    assert log_evidence(back) == pytest.approx(log_evidence(whole), abs=0.01)
