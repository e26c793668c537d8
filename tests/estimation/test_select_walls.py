"""A wall is found where it stands, and none is invented, on a small problem made for it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.small_problem import FLOOR_PLANE, WALL_PLANE, SmallProblem, small_problem

from radargui.estimation.select.converge import converge
from radargui.estimation.select.unseen_mirrors import unseen_mirrors
from radargui.estimation.select.wall_grid import WALLS, linearised_gains, upright_planes, wall_grid
from radargui.estimation.select.wall_walk import WalkSettings, walked
from radargui.estimation.select.walls import (
    bent_by_maps,
    place_of_last,
    search_wall,
    with_stiff_maps,
)
from radargui.estimation.solve.changed_problem import positions_at_bins, problem_with_mirrors
from radargui.estimation.solve.minimise import Solution, log_evidence, solved_at
from radargui.physics.mirrors import MirrorPlane

UP = np.array([0.0, 0.0, 1.0])


def nothing() -> None:
    """Report no progress."""


def converged(made: SmallProblem) -> Solution:
    return converge(made.start, 3, nothing)


@pytest.fixture(scope="module")
def hidden() -> Solution:
    """The data have a wall 14 cm along +x; the model has none."""
    return converged(small_problem(reflection=0.06, shown=(WALL_PLANE,), sigma=0.005))


@pytest.fixture(scope="module")
def clean() -> Solution:
    return converged(small_problem(sigma=0.005))


def gains(solution: Solution) -> tuple[np.ndarray, list]:
    azimuth, distance = wall_grid()
    planes = upright_planes(positions_at_bins(solution).mean(axis=1), UP, azimuth, distance)
    return linearised_gains(solution, planes, nothing), planes


def test_the_linearised_evidence_of_the_grid_is_highest_at_the_wall(hidden: Solution) -> None:
    gain, planes = gains(hidden)
    best = planes[int(np.argmax(gain))]
    assert best.normal @ WALL_PLANE.normal > np.cos(np.radians(20.0))
    assert gain.max() > np.median(gain) + 50.0


def test_without_a_wall_the_grid_is_flat(clean: Solution, hidden: Solution) -> None:
    gain, _ = gains(clean)
    assert np.ptp(gain) < 0.2 * np.ptp(gains(hidden)[0])


def test_a_wall_is_found_where_it_stands_and_convinces(hidden: Solution) -> None:
    search = search_wall(hidden, UP, nothing, thorough=True)
    assert search.gain > WALLS.convincing
    assert [trial.gain for trial in search.tried] == sorted((t.gain for t in search.tried), reverse=True)
    best = search.tried[0].solution
    image = best.problem.inputs.planes[-1].image(np.zeros(3), best.problem.layout.plane_unknowns(best.state.theta)[-1])
    assert image[0] / 2.0 == pytest.approx(0.14, abs=0.02)
    assert abs(np.arctan2(image[1], image[0])) < np.radians(8.0)


def test_no_wall_is_invented_where_none_reflects(clean: Solution) -> None:
    assert search_wall(clean, UP, nothing, thorough=False).gain < WALLS.convincing


@pytest.mark.slow
def test_a_wall_that_stopped_short_of_its_place_walks_there(hidden: Solution) -> None:
    middle = positions_at_bins(hidden).mean(axis=1)
    aside = upright_planes(middle, UP, np.radians([235.0]), np.array([0.14]))
    stopped = converge(problem_with_mirrors(hidden, tuple(aside)), 3, nothing)
    assert abs(np.degrees(place_of_last(stopped, middle, UP)[0]) % 360.0 - 180.0) > 20.0
    best, *_ = walked(stopped, UP, nothing, WalkSettings(steps=2))
    assert abs(np.degrees(place_of_last(best, middle, UP)[0]) % 360.0 - 180.0) < 3.0
    assert log_evidence(best) > log_evidence(stopped) + 100.0


@pytest.mark.parametrize("planes", [(), (FLOOR_PLANE,)], ids=["a floor", "walls beside a floor"])
def test_what_nothing_excludes_moves_the_solution_and_what_the_samples_exclude_does_not(
    planes: tuple[MirrorPlane, ...],
) -> None:
    assert unseen_mirrors(converged(small_problem(planes, sigma=0.001)), UP, 5.0) == ([], 0.0)
    # so much noise that they exclude hardly any place
    noisy = converged(small_problem(planes, sigma=0.2))
    moved, weight = unseen_mirrors(noisy, UP, 5.0)
    assert 0.1 < len(moved) * weight < 1.0
    solutions = [replace(noisy, state=one) for one in moved]
    away_m = [np.sqrt(((positions_at_bins(one) - positions_at_bins(noisy)) ** 2).mean()) for one in solutions]
    assert all(1e-5 < one < 3e-4 for one in away_m)


def loosened(solution: Solution) -> Solution:
    """Return a solution with bias maps as loose as where they stand for a wall, and a motion that no flight holds."""
    sd = solution.problem.prior.sd.copy()
    for own in solution.problem.layout.receivers:
        sd[own.bias_i] = sd[own.bias_q] = 0.1
    prior = replace(solution.problem.prior, sd=sd)
    flown = np.zeros_like(solution.problem.in_flight)
    return replace(solution, problem=replace(solution.problem, prior=prior, in_flight=flown))


def test_maps_bend_a_motion_only_where_they_are_loose_and_nothing_flies(hidden: Solution) -> None:
    loose = loosened(hidden)
    assert bent_by_maps(loose)
    assert not bent_by_maps(replace(loose, problem=replace(loose.problem, in_flight=~loose.problem.in_flight)))
    assert not bent_by_maps(with_stiff_maps(loose))


def test_maps_that_are_loose_beside_a_wall_are_begun_again_stiff(hidden: Solution) -> None:
    loose = loosened(solved_at(problem_with_mirrors(hidden, (WALL_PLANE,))))
    best, *others = walked(loose, UP, nothing, WalkSettings(steps=0))
    assert others == [loose]
    assert not bent_by_maps(best)
    assert log_evidence(best) > log_evidence(loose) + WALLS.worthwhile
