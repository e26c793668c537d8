"""A solution on fewer bins says what it says on all of them, and comes back unchanged."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.small_problem import BOUNCE_S, END_S, FLOOR_PLANE, SmallProblem, small_problem

from radargui.estimation.forward.bins import BinnedData, weighted_means
from radargui.estimation.forward.slow_noise import Drift
from radargui.estimation.select.fewer_bins import NEAR_BREAK_S, fewer_bins, in_full, with_bins_of
from radargui.estimation.solve.changed_problem import positions_at_bins
from radargui.estimation.solve.minimise import Solution, log_evidence, solved_at
from radargui.estimation.solve.problem import Start

BREAKS_S = np.array([BOUNCE_S])


def together(made: SmallProblem, most: int) -> BinnedData:
    return fewer_bins(made.data, BREAKS_S, most)


@pytest.fixture(scope="module")
def made() -> SmallProblem:
    """Bins of 0.3 ms, 1/24 fringe where it is fastest, and slow noise that the model knows."""
    drift = Drift(0.0, END_S, 4, np.full((6, 4), 0.01), np.zeros(6))
    return small_problem((FLOOR_PLANE,), reflection=0.2, n_bins=1500, drift=drift)


@pytest.fixture(scope="module")
def whole(made: SmallProblem) -> Solution:
    theta = made.start.state.theta.copy()
    for own in made.problem.layout.receivers:
        theta[own.drift_i.start] = theta[own.drift_q.start + 1] = 1.0
    return solved_at(Start(made.problem, replace(made.start.state, theta=theta)))


@pytest.fixture(scope="module")
def fewer(made: SmallProblem, whole: Solution) -> Solution:
    return solved_at(with_bins_of(whole, together(made, 3)))


def test_what_fewer_bins_should_show_is_the_mean_of_what_the_bins_should(
    made: SmallProblem, whole: Solution, fewer: Solution
) -> None:
    bins = fewer.problem.bins
    begin = np.searchsorted(made.data.bins.first_s, bins.first_s)
    away, anew = (np.abs(some.time_s - BOUNCE_S) >= NEAR_BREAK_S for some in (made.data.bins, bins))
    assert anew.sum() < 0.4 * away.sum()
    for many, few in zip(whole.at.signals, fewer.at.signals, strict=True):
        mean = weighted_means(many.value, made.data.bins.count, begin)
        # the two nodes of 1/8 fringe, and maps that count as constant over it
        assert np.abs(few.value - mean)[:, fewer.problem.use].max() < 3e-4


def test_bins_stay_as_they_are_where_the_noise_would_show_what_fewer_are_off_by() -> None:
    quiet = small_problem(n_bins=600, sigma=1e-5)
    assert together(quiet, 3).bins.n_bins == 600


def test_what_a_change_costs_is_the_same_on_fewer_bins(made: SmallProblem) -> None:
    whole = solved_at(made.start)

    def cost(most: int) -> float:
        theta = whole.state.theta.copy()
        theta[whole.problem.layout.transmitter_reflection] *= 0.98
        beside = replace(whole, state=replace(whole.state, theta=theta))
        first, second = (log_evidence(solved_at(with_bins_of(one, together(made, most)))) for one in (whole, beside))
        return first - second

    assert 20.0 < cost(3) == pytest.approx(cost(1), rel=0.05)


def test_the_functions_of_the_chosen_model_leave_less_than_two_parts_in_a_thousand(
    made: SmallProblem, whole: Solution
) -> None:
    place = positions_at_bins(whole)[:, ~made.data.rest]

    def left(start: Start) -> float:
        bases = (start.problem.bias_basis, start.problem.amplitude_basis)
        return max(float(np.sqrt(np.abs(1.0 - np.square(one(place)).sum(axis=1)).max())) for one in bases)

    coarse, fine = left(Start(whole.problem, whole.state)), left(in_full(whole, made.data))
    assert fine < 2e-3 < coarse
