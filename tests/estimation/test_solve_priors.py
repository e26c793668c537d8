"""Priors of the global parameters and how their deviations are re-estimated."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.small_problem import ANTENNAS, CONSTANTS, FLOOR_PLANE, WALL_PLANE, small_problem

from radargui.estimation.forward.parameters import Sizes, make_layout
from radargui.estimation.hardware import LogFrontEnd
from radargui.estimation.solve.changed_problem import problem_with_flights
from radargui.estimation.solve.lobe_prior import with_lobes_of_walls
from radargui.estimation.solve.minimise import minimise
from radargui.estimation.solve.prior_deviations import (
    DeviationSettings,
    reestimated,
    update_priors,
    updated_noise_scale,
)
from radargui.estimation.solve.priors import PriorSettings, make_prior, with_known_front_ends
from radargui.estimation.solve.problem import linearise

LAYOUT = make_layout(Sizes(breaks=2, mirrors=2, receivers=3, bias=4, amplitude_map=3, drift=2, walls=1))
PLANES = (FLOOR_PLANE, WALL_PLANE)


def prior_of(settings: PriorSettings | None = None):
    return make_prior(LAYOUT, PLANES, np.array([0.2, 0.3]), CONSTANTS, settings or PriorSettings())


def test_lobes_are_those_of_ordinary_antennas_and_stay_as_wide() -> None:
    prior = prior_of()
    assert prior.mean[LAYOUT.transmitter_lobe].tolist() == [0.0, -0.9, 0.0] * 2
    assert prior.sd[LAYOUT.receivers[1].receiver_lobe].tolist() == [0.3, 2.0, 2.0, 0.3, 0.6, 2.0]


def test_the_main_lobes_let_expect_those_over_a_wall() -> None:
    theta = np.zeros(LAYOUT.size)
    for own in LAYOUT.receivers:
        theta[own.receiver_lobe][1] = -1.0
    prior = with_lobes_of_walls(prior_of(), LAYOUT, theta, PLANES, ANTENNAS, np.zeros(3))
    for place, antenna in zip(
        [LAYOUT.transmitter_lobe, *(own.receiver_lobe for own in LAYOUT.receivers)],
        [ANTENNAS.transmitter_m, *ANTENNAS.receivers_m],
        strict=True,
    ):
        image, aim = (WALL_PLANE.image(one, np.zeros(3)) for one in (antenna, np.zeros(3)))
        cosine = (aim - image) @ -image / np.linalg.norm(aim - image) / np.linalg.norm(image)
        strength = lambda c: 0.5 * np.log(c**20 + 0.01)  # noqa: E731
        slope = -(strength(cosine + 1e-6) - strength(cosine - 1e-6)) / 2e-6
        assert prior.mean[place][4] == pytest.approx(0.1 * slope, abs=1e-4)
        assert prior.mean[place][1] == -0.9
    narrow = with_lobes_of_walls(prior_of(), LAYOUT, 2.0 * theta, PLANES, ANTENNAS, np.zeros(3))
    for lobes, main in ((prior, 1.0), (narrow, 2.0)):
        # the least, and half or three tenths of the main lobe's slope
        assert lobes.sd[LAYOUT.transmitter_lobe][4] == pytest.approx(0.1 + 0.5 * main)
        assert lobes.sd[LAYOUT.receivers[0].receiver_lobe][4] == pytest.approx(0.1 + 0.3 * main)
    # without a floor the direct way tells the same
    alone = with_lobes_of_walls(prior_of(), LAYOUT, theta, (WALL_PLANE,), ANTENNAS, np.zeros(3))
    assert alone.mean.tolist() == prior.mean.tolist()
    assert alone.sd.tolist() == prior.sd.tolist()


def test_known_front_ends_take_the_place_of_the_wide_ones_alone() -> None:
    before = prior_of()
    known = [LogFrontEnd(0.1, 0.002, -0.05, 0.003)] * 3
    after = with_known_front_ends(before, LAYOUT, known)
    for own in LAYOUT.receivers:
        assert (after.mean[own.log_gain], after.sd[own.log_gain]) == (0.1, 0.002)
        assert (after.mean[own.quadrature_error], after.sd[own.quadrature_error]) == (-0.05, 0.003)
    assert (after.sd != before.sd).sum() == 6


def test_a_deviation_is_that_from_the_prior_mean() -> None:
    prior = prior_of()
    group = prior.groups[0]
    mean = prior.mean.copy()
    mean[group.index] = 0.05
    off = 0.03 * np.resize([1.0, -1.0], group.index.size)
    theta = mean.copy()
    theta[group.index] += off
    shifted = reestimated(replace(prior, mean=mean), theta, np.zeros(LAYOUT.size))
    theta[group.index] = off
    centred = reestimated(prior, theta, np.zeros(LAYOUT.size))
    assert shifted.sd[group.index] == pytest.approx(centred.sd[group.index], rel=1e-12)


@pytest.mark.parametrize("planes", [(), (FLOOR_PLANE,)])
def test_a_map_that_nobody_needs_shrinks_by_mackays_rule_within_its_limits(planes) -> None:
    made = small_problem(planes)
    solution = minimise(made.start, 4)
    variance, old = solution.normal.global_variances(), solution.problem.prior
    new = update_priors(solution).prior
    for group in old.groups:
        w, sd = solution.state.theta[group.index], old.sd[group.index[0]]
        gamma = max(group.index.size - (variance[group.index] / sd**2).sum(), 1e-2)
        # beside a floor s itself has the prior exp(-s / scale)
        wanted = np.sqrt(w @ w / (gamma + sd / group.scale))
        wanted = np.clip(wanted, max(sd / 10.0, group.lowest), min(sd * 10.0, group.highest))
        assert new.sd[group.index] == pytest.approx(wanted)
    bias = made.problem.layout.receivers[0].bias_i.start
    scales = {group.scale for group in old.groups if bias in group.index}
    assert scales == {PriorSettings().bias_beside_floor.scale if planes else np.inf}
    assert new.sd[bias] < 0.5 * old.sd[bias]
    frozen = update_priors(solution, DeviationSettings(largest_change=1.0)).prior
    assert frozen.sd == pytest.approx(old.sd)


def test_the_jerk_may_be_large_at_the_bounce_and_becomes_small_in_the_fall() -> None:
    made = small_problem()
    problem, state = made.problem, made.truth
    for _ in range(3):
        solution = minimise(replace(made.start, problem=problem, state=state), 4)
        problem, state = update_priors(solution), solution.state
    _, middle, _ = solution.at.spline.jerk()
    falling = (middle > 0.08) & (middle < 0.23)
    assert np.median(problem.equation_sd[falling]) < 20.0
    assert problem.equation_sd.min() >= 0.3


def test_what_no_sample_says_of_a_deviation_from_the_law_of_flight_is_that_there_is_none() -> None:
    start = problem_with_flights(minimise(small_problem().start, 2))
    assert start is not None
    problem, state = start.problem, start.state
    for _ in range(4):
        solution = minimise(replace(start, problem=problem, state=state), 4)
        problem, state = update_priors(solution), solution.state
    # 0.014 where every deviation is as likely as another
    in_flight = solution.at.equation.rows.is_flight
    assert np.median(problem.equation_sd[in_flight]) == pytest.approx(DeviationSettings().lowest_off_m_s2)


def test_the_noise_scale_follows_the_typical_misfit_not_a_short_one() -> None:
    made = small_problem(sigma=0.01)
    quieter = replace(made.problem, bins=replace(made.problem.bins, sigma=0.5 * made.problem.bins.sigma))
    start = replace(made.start, problem=quieter)
    assert updated_noise_scale(minimise(start, 2)) == pytest.approx(1.3)  # limited; 2 in the end
    unlimited = DeviationSettings(largest_noise_step=10.0)
    assert updated_noise_scale(minimise(start, 2), unlimited) == pytest.approx(2.0, abs=0.3)
    value = made.problem.bins.value.copy()
    value[:, 100:108] += 0.2
    short = replace(made.start, problem=replace(made.problem, bins=replace(made.problem.bins, value=value)))
    solution = replace(minimise(made.start, 2), at=linearise(short.problem, made.truth), problem=short.problem)
    assert updated_noise_scale(solution).max() < 1.15
