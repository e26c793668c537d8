"""A solution on fewer bins says what it says on all of them, and comes back unchanged."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.small_problem import BOUNCE_S, END_S, FLOOR_PLANE, SmallProblem, small_problem

from radargui.estimation.forward.bins import BinnedData, weighted_means
from radargui.estimation.forward.parameters import Layout
from radargui.estimation.forward.slow_noise import Drift, strongest
from radargui.estimation.select.fewer_bins import NEAR_BREAK_S, fewer_bins, in_full, with_bins_of
from radargui.estimation.solve.changed_problem import positions_at_bins, problem_with_slow_noise
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


def test_a_bin_that_holds_a_break_stays_apart_and_so_do_what_lies_behind_it_and_the_rest(
    made: SmallProblem, fewer: Solution
) -> None:
    use, data = fewer.problem.use, together(made, 3)
    bins = data.bins
    assert bins.count[~use].sum() == made.data.bins.count[~made.start.problem.use].sum() > 0
    assert ((bins.last_s < BOUNCE_S) | (bins.first_s > BOUNCE_S))[use].all()
    # while it is settled it moves: near it nothing is put together
    near = np.abs(bins.time_s - BOUNCE_S) < NEAR_BREAK_S
    assert (bins.count[near] == made.data.bins.count[0]).all()
    assert (bins.count[~near] > made.data.bins.count[0]).mean() > 0.9
    assert bins.count[data.rest].sum() == made.data.bins.count[made.data.rest].sum()


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


def test_back_on_all_bins_a_solution_is_what_it_was(made: SmallProblem, whole: Solution, fewer: Solution) -> None:
    back = solved_at(with_bins_of(fewer, made.data))
    assert back.problem.bins is made.data.bins
    assert back.problem.inputs.drift is made.data.drift
    assert back.at.cost == pytest.approx(whole.at.cost, abs=0.01)
    assert log_evidence(back) == pytest.approx(log_evidence(whole), abs=0.01)


def test_in_full_maps_say_what_they_said_and_are_whole_where_fewer_functions_left_a_remainder(
    made: SmallProblem, whole: Solution
) -> None:
    layout, rng = whole.problem.layout, np.random.default_rng(5)
    theta, prior = whole.state.theta.copy(), whole.problem.prior
    sd = prior.sd.copy()
    for number, own in enumerate(layout.receivers):
        sd[own.amplitude_map] = 0.01 * (number + 1)
        for places in (own.bias_i, own.bias_q, own.amplitude_map):
            theta[places] = sd[places] * rng.standard_normal(places.stop - places.start)
    problem = replace(whole.problem, prior=replace(prior, sd=sd))
    before = solved_at(Start(problem, replace(whole.state, theta=theta)))
    after = in_full(before, made.data)
    place = positions_at_bins(before)[:, ~made.data.rest]
    for was, now in zip(layout.receivers, after.problem.layout.receivers, strict=True):
        for name, basis in (("bias_i", "bias_basis"), ("bias_q", "bias_basis"), ("amplitude_map", "amplitude_basis")):
            a, b = getattr(was, name), getattr(now, name)
            said, says = (
                getattr(one, basis)(place) @ values
                for one, values in ((before.problem, theta[a]), (after.problem, after.state.theta[b]))
            )
            assert np.abs(says - said).max() < 2e-3 * sd[a.start]
            assert (after.problem.prior.sd[b] == sd[a.start]).all()
        assert after.state.theta[now.constants].tolist() == theta[was.constants].tolist()
    # a group has all the coefficients of its kind, and others are as they were
    theirs = {a.start: (b.start, c.stop) for a, b, c in _groups_of_maps(layout, after.problem.layout)}
    for was_group, group in zip(problem.prior.groups, after.problem.prior.groups, strict=True):
        if was_group.index[0] in theirs:
            assert group.index.tolist() == list(range(*theirs[was_group.index[0]]))
        else:
            assert group.index.size == was_group.index.size


def _groups_of_maps(was: Layout, now: Layout) -> list[tuple[slice, slice, slice]]:
    """Return where a group of maps began, and its first and last map now."""
    pairs = list(zip(was.receivers, now.receivers, strict=True))
    bias = [(a.bias_i, b.bias_i, b.bias_q) for a, b in pairs]
    return bias + [(a.amplitude_map, b.amplitude_map, b.amplitude_map) for a, b in pairs]


def test_the_functions_of_the_chosen_model_leave_less_than_two_parts_in_a_thousand(
    made: SmallProblem, whole: Solution
) -> None:
    place = positions_at_bins(whole)[:, ~made.data.rest]

    def left(start: Start) -> float:
        bases = (start.problem.bias_basis, start.problem.amplitude_basis)
        return max(float(np.sqrt(np.abs(1.0 - np.square(one(place)).sum(axis=1)).max())) for one in bases)

    coarse, fine = left(Start(whole.problem, whole.state)), left(in_full(whole, made.data))
    assert fine < 2e-3 < coarse


def test_of_slow_noise_the_strongest_functions_stay_and_the_variance_of_the_others_goes_to_the_bins() -> None:
    sd = np.geomspace(0.1, 1e-4, 8) * np.ones((6, 1))
    data = small_problem(drift=Drift(0.0, END_S, 8, sd, np.zeros(6))).data
    rough = strongest(data, 5.0)
    kept = rough.drift.shape[2]
    assert 0 < kept < data.drift.shape[2]
    felt = ((data.drift / data.bins.sigma[:, :, None]) ** 2).sum(axis=1)
    assert (felt[:, :kept].max(axis=0) > 5.0).all()
    assert (felt[:, kept:] <= 5.0).all()
    variance = [one.bins.sigma**2 + (one.drift**2).sum(axis=2) for one in (rough, data)]
    assert variance[0] == pytest.approx(variance[1], rel=1e-12)
    # white noise below, and what is there in full above it
    white = data.bins.sigma**2 * data.bins.expected
    assert rough.bins.sigma**2 * rough.bins.expected == pytest.approx(white + rough.bins.sigma**2 - data.bins.sigma**2)
    assert strongest(data, 0.0) is data


def test_with_fewer_functions_of_slow_noise_all_else_stays_and_back_again_the_others_are_nothing(
    made: SmallProblem, whole: Solution
) -> None:
    few = problem_with_slow_noise(Start(whole.problem, whole.state), made.data.drift[:, :, :2])
    old, new = whole.problem.layout, few.problem.layout
    assert new.sizes.drift == 2
    assert new.size == old.size - 6 * 2
    back = problem_with_slow_noise(few, made.data.drift)
    assert back.problem.layout == old
    expected = whole.state.theta.copy()
    for was, now in zip(old.receivers, new.receivers, strict=True):
        for all_of_it, rest in ((was.drift_i, now.drift_i), (was.drift_q, now.drift_q)):
            expected[all_of_it.start + 2 : all_of_it.stop] = 0.0
            assert few.state.theta[rest].tolist() == whole.state.theta[all_of_it][:2].tolist()
    assert back.state.theta == pytest.approx(expected, abs=0.0)
    assert back.problem.prior.sd == pytest.approx(whole.problem.prior.sd, abs=0.0)
    assert back.problem.prior.mean == pytest.approx(whole.problem.prior.mean, abs=0.0)
    # what belongs to one deviation still does
    for before, between, after in zip(
        whole.problem.prior.groups, few.problem.prior.groups, back.problem.prior.groups, strict=True
    ):
        assert few.problem.prior.sd[between.index] == pytest.approx(whole.problem.prior.sd[before.index])
        assert after.index.tolist() == before.index.tolist()
