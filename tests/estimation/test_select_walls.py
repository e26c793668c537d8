"""A wall is found where it stands, and none is invented, on a small problem made for it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.small_problem import FLOOR_PLANE, WALL_PLANE, SmallProblem, small_problem

from radargui.estimation.forward.mirrors import MirrorPlane
from radargui.estimation.select import wall_walk, walls
from radargui.estimation.select.converge import converge
from radargui.estimation.select.unseen_mirrors import UnseenSettings, unseen_mirrors
from radargui.estimation.select.wall_grid import WALLS, LinearisedSearch, linearised_gains, upright_planes, wall_grid
from radargui.estimation.select.wall_walk import WalkSettings, walked
from radargui.estimation.select.walls import (
    bent_by_maps,
    peaks,
    place_of_last,
    search_wall,
    with_stiff_maps,
)
from radargui.estimation.solve.changed_problem import positions_at_bins, problem_with_mirrors
from radargui.estimation.solve.minimise import Solution, log_evidence, solved_at
from radargui.estimation.solve.problem import Start, State

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


def test_where_no_place_is_foretold_to_come_near_what_convinces_none_is_tried(clean: Solution) -> None:
    foretold, _ = gains(clean)
    hopeless = replace(WALLS, convincing=-float(foretold.max()) - 0.5)
    search = search_wall(clean, UP, nothing, thorough=True, settings=hopeless)
    assert search.tried == ()
    assert search.gain == pytest.approx(float(foretold.max()))
    assert search_wall(clean, UP, nothing, thorough=False, settings=replace(hopeless, convincing=1e3)).tried


def test_upright_planes_face_the_middle_at_their_distance() -> None:
    middle = np.array([0.01, 0.02, 0.0])
    planes = upright_planes(middle, UP, np.array([0.0, 2.0]), np.array([0.1, 0.2]))
    assert [plane.normal @ (middle - plane.foot_m) for plane in planes] == pytest.approx([0.1, 0.2, 0.1, 0.2])
    assert [plane.normal @ UP for plane in planes] == pytest.approx([0.0] * 4)
    assert FLOOR_PLANE.deviations[0] < planes[0].deviations[0] == WALLS.u_azimuth_rad


def test_peaks_of_a_circle_of_azimuths_go_round() -> None:
    table = np.zeros((6, 3))
    table[0, 1], table[5, 1], table[3, 2] = 5.0, 4.0, 3.0
    assert [divmod(k, 3) for k in peaks(table, around=True)[:2]] == [(0, 1), (3, 2)]
    assert [divmod(k, 3) for k in peaks(table, around=False)[:3]] == [(0, 1), (5, 1), (3, 2)]


@pytest.mark.slow
def test_a_wall_that_stopped_short_of_its_place_walks_there(hidden: Solution) -> None:
    middle = positions_at_bins(hidden).mean(axis=1)
    aside = upright_planes(middle, UP, np.radians([235.0]), np.array([0.14]))
    stopped = converge(problem_with_mirrors(hidden, tuple(aside)), 3, nothing)
    assert abs(np.degrees(place_of_last(stopped, middle, UP)[0]) % 360.0 - 180.0) > 20.0
    best, *_ = walked(stopped, UP, nothing, WalkSettings(steps=2))
    assert abs(np.degrees(place_of_last(best, middle, UP)[0]) % 360.0 - 180.0) < 3.0
    assert log_evidence(best) > log_evidence(stopped) + 100.0


@pytest.mark.parametrize(("turned_rad", "steps"), [(0.1, 1), (0.4, 3)])
def test_a_wall_far_from_where_it_was_sought_is_sought_from_where_it_stands(
    monkeypatch: pytest.MonkeyPatch, turned_rad: float, steps: int
) -> None:
    made, tried = small_problem((WALL_PLANE,), reflection=0.1), []
    theta = made.truth.theta.copy()
    theta[made.problem.layout.planes] = turned_rad, 0.0, 0.0
    solution = solved_at(Start(made.problem, State(made.truth.coefficients, theta)))
    monkeypatch.setattr(wall_walk, "_elsewhere", lambda *given: [])
    monkeypatch.setattr(wall_walk, "bent_by_maps", lambda one: False)

    found = [solution]

    def race(starts: list[Start], *given: object) -> list[Solution]:
        tried.append(starts)
        found.append(replace(solution))
        return found[-1:]

    # each is a little better than what was there, by less than is worth a step
    monkeypatch.setattr(wall_walk, "log_evidence", lambda one: 0.1 * [one is other for other in found].index(True))
    monkeypatch.setattr(wall_walk, "race", race)
    walked(solution, UP, nothing, WalkSettings(steps=3))
    assert len(tried) == steps
    # the first trial: the same wall, held by nothing
    start = tried[0][0]
    (plane,), (unknown,) = start.problem.inputs.planes, start.problem.layout.plane_unknowns(start.state.theta)
    assert unknown.tolist() == [0.0, 0.0, 0.0]
    image = plane.image(np.zeros(3), unknown)
    assert np.degrees(np.arctan2(image[1], image[0])) == pytest.approx(
        np.degrees(np.arctan2(*WALL_PLANE.image(np.zeros(3), theta[made.problem.layout.planes])[1::-1])), abs=3.0
    )
    # among the others one nearer and one farther, in the same direction
    middle = positions_at_bins(solution).mean(axis=1)
    feet = [one.problem.inputs.planes[-1].foot_m - middle for one in tried[0]]
    along = [foot for foot in feet if foot @ feet[0] > 0.999 * np.linalg.norm(foot) * np.linalg.norm(feet[0])]
    ratios = sorted(float(np.linalg.norm(foot) / np.linalg.norm(feet[0])) for foot in along)
    assert ratios == pytest.approx([0.82, 1.0, 1.22])


def test_a_walk_that_finds_nothing_better_is_not_gone_again(hidden: Solution, monkeypatch: pytest.MonkeyPatch) -> None:
    aside = upright_planes(positions_at_bins(hidden).mean(axis=1), UP, np.radians([235.0]), np.array([0.14]))
    start = problem_with_mirrors(hidden, tuple(aside))
    # turned by more than where it was sought allows: held, so that a walk would go on
    theta = start.state.theta.copy()
    theta[start.problem.layout.planes] = 0.5, 0.0, 0.0
    held, tried = solved_at(Start(start.problem, State(start.state.coefficients, theta))), []
    monkeypatch.setattr(wall_walk, "_elsewhere", lambda *given: [])
    monkeypatch.setattr(wall_walk, "bent_by_maps", lambda one: False)
    monkeypatch.setattr(wall_walk, "race", lambda starts, *given: tried.append(starts) or [])
    assert walked(held, UP, nothing, WalkSettings(steps=3)) == [held]
    assert len(tried) == 1


def test_a_walk_looks_elsewhere_only_where_its_own_steps_do_not_lead(
    hidden: Solution, monkeypatch: pytest.MonkeyPatch
) -> None:
    middle = positions_at_bins(hidden).mean(axis=1)
    there = converge(
        problem_with_mirrors(hidden, tuple(upright_planes(middle, UP, np.radians([180.0]), np.array([0.14])))),
        1,
        nothing,
    )
    looked: list[Start] = []
    monkeypatch.setattr(wall_walk, "best_started", lambda starts, most, round_done: looked.extend(starts) or [])
    monkeypatch.setattr(wall_walk, "race", lambda *given: [])
    monkeypatch.setattr(wall_walk, "bent_by_maps", lambda one: False)
    settings = WalkSettings(steps=1)
    walked(there, UP, nothing, settings)
    release = hidden.problem.inputs.release_m
    image = there.problem.inputs.planes[-1].image(release, there.problem.layout.plane_unknowns(there.state.theta)[-1])
    away = [np.linalg.norm(one.problem.inputs.planes[-1].image(release, np.zeros(3)) - image) for one in looked]
    assert 0 < len(away) <= settings.tried_elsewhere
    assert min(away) > settings.own_reach * np.linalg.norm(image - release)


def test_walls_that_were_not_tried_weigh_as_those_that_are() -> None:
    noisy = converged(small_problem((FLOOR_PLANE,), sigma=0.2))
    foretold, _ = gains(noisy)
    _, among_all = unseen_mirrors(noisy, UP, 5.0)
    moved, weight = unseen_mirrors(noisy, UP, 5.0, foretold)
    highest = np.sort(np.exp(np.minimum(foretold[peaks(foretold.reshape(40, -1), around=True)[:4]], 0.0) / 5.0))
    assert 3.0 * weight == pytest.approx(3.0 * among_all + highest.sum(), rel=0.05)
    assert len(moved) == 3


@pytest.mark.slow
def test_places_that_weigh_alike_share_one_weight(monkeypatch: pytest.MonkeyPatch) -> None:
    noisy = converged(small_problem((FLOOR_PLANE,), sigma=0.2))
    monkeypatch.setattr(LinearisedSearch, "gains", lambda self, planes: np.ones(len(planes)))

    def moved(places: int) -> float:
        states, weight = unseen_mirrors(noisy, UP, 5.0, settings=UnseenSettings(places=places))
        assert 3.0 * weight == pytest.approx(1.0)
        return float(sum(((one.coefficients - noisy.state.coefficients) ** 2).sum() for one in states))

    # some of 320 stand for all: a mean, not a sum over all that weigh alike, which is 16 times as much
    assert 0.1 < moved(20) / moved(320) < 10.0


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


def test_where_the_best_wall_leaves_maps_loose_the_grid_is_searched_from_stiff_ones_too(
    hidden: Solution, monkeypatch: pytest.MonkeyPatch
) -> None:
    loose, begun = loosened(hidden), []

    def search(solution: Solution, *given: object) -> walls.WallSearch:
        begun.append(solution)
        return walls.WallSearch((walls.WallTrial(trial, 12.0),))

    monkeypatch.setattr(walls, "_search_from", search)
    for left, searches in ((loose, 2), (with_stiff_maps(loose), 1)):
        begun.clear()
        trial = left
        found = search_wall(loose, UP, nothing, thorough=True)
        assert (len(begun), len(found.tried)) == (searches, searches)
        assert [bent_by_maps(one) for one in begun] == [True, False][:searches]
        assert found.gain == pytest.approx(12.0)


def test_maps_that_are_loose_beside_a_wall_are_begun_again_stiff(hidden: Solution) -> None:
    loose = loosened(solved_at(problem_with_mirrors(hidden, (WALL_PLANE,))))
    best, *others = walked(loose, UP, nothing, WalkSettings(steps=0))
    assert others == [loose]
    assert not bent_by_maps(best)
    assert log_evidence(best) > log_evidence(loose) + WALLS.worthwhile
