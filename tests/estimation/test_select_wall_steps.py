"""How the search for a wall and its walk go on or end: each rule on trials made for it."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from support.small_problem import FLOOR_PLANE, WALL_PLANE, small_problem

from radargui.estimation.forward.mirrors import MirrorPlane
from radargui.estimation.forward.position_map import make_basis
from radargui.estimation.select import wall_walk, walls
from radargui.estimation.select.race import best_started, last_image, same_place, score_of
from radargui.estimation.select.wall_grid import WALLS, upright_planes, wall_grid, wall_towards
from radargui.estimation.select.wall_walk import WalkSettings, walked
from radargui.estimation.select.walls import (
    WallSearch,
    WallTrial,
    _run_off,
    peaks,
    place_of_last,
    search_wall,
    without_last_mirror,
)
from radargui.estimation.solve.changed_problem import positions_at_bins, problem_with_mirrors
from radargui.estimation.solve.minimise import Solution, solved_at
from radargui.estimation.solve.problem import Start, State

UP = np.array([0.0, 0.0, 1.0])


def nothing() -> None:
    """Report no progress."""


@pytest.fixture(scope="module")
def beside() -> Solution:
    """A wall 14 cm along +x, in data and model."""
    made = small_problem((WALL_PLANE,), reflection=0.1)
    return solved_at(made.start)


def with_plane(solution: Solution, *unknown: float) -> Solution:
    """Return the solution with its last mirror tilted (rad) and shifted (m)."""
    theta = solution.state.theta.copy()
    theta[solution.problem.layout.planes][-3:] = unknown
    return replace(solution, state=State(solution.state.coefficients, theta))


@pytest.mark.parametrize(
    ("turned_rad", "gained", "steps"),
    [(0.2, 3.0, 3), (0.2, 1.0, 1), (0.0, 3.0, 1), (0.0, 1.0, 1)],
    ids=["it moves and gains", "it moves and gains nothing", "it stays and gains", "it stays"],
)
def test_a_wall_walks_on_while_a_step_moves_it_and_gains(
    beside: Solution, monkeypatch: pytest.MonkeyPatch, turned_rad: float, gained: float, steps: int
) -> None:
    found, races = [beside], []

    def race(starts: list[Start], *given: object) -> list[Solution]:
        races.append(starts)
        # there and back: as far from where it was sought as before, so that its prior does not hold it
        found.append(with_plane(beside, turned_rad * (len(races) % 2), 0.0, 0.0))
        return found[-1:]

    monkeypatch.setattr(wall_walk, "_elsewhere", lambda *given: [])
    monkeypatch.setattr(wall_walk, "bent_by_maps", lambda one: False)
    monkeypatch.setattr(wall_walk, "log_evidence", lambda one: gained * [one is it for it in found].index(True))
    monkeypatch.setattr(wall_walk, "race", race)
    best, *_ = walked(beside, UP, nothing, WalkSettings(steps=3))
    assert len(races) == steps
    assert best is found[-1]


def test_a_walk_begins_at_the_walls_own_place_turned_by_each_angle_and_nearer_and_farther(
    beside: Solution, monkeypatch: pytest.MonkeyPatch
) -> None:
    raced: list[list[Start]] = []
    monkeypatch.setattr(wall_walk, "_elsewhere", lambda *given: [])
    monkeypatch.setattr(wall_walk, "bent_by_maps", lambda one: False)
    monkeypatch.setattr(wall_walk, "race", lambda starts, *given: raced.append(starts) or [])
    settings = WalkSettings(turns_deg=(0.0, 20.0), nearer_or_farther=(0.5, 0.2, 2.0))
    walked(beside, UP, nothing, settings)
    middle = positions_at_bins(beside).mean(axis=1)
    azimuth, distance = place_of_last(beside, middle, UP)
    assert distance == pytest.approx(0.14 - middle[0])
    places = [wall_towards(one.problem.inputs.planes[-1].image(middle, np.zeros(3)) - middle, UP) for one in raced[0]]
    turns = [np.angle(np.exp(1j * (place[0] - azimuth))) for place in places]
    # a fifth of its distance is nearer than any wall stands
    assert np.degrees(turns) == pytest.approx([0.0, 20.0, 0.0, 0.0], abs=1e-9)
    assert [place[1] / distance for place in places] == pytest.approx([1.0, 1.0, 0.5, 2.0])


def test_elsewhere_begins_beyond_half_the_distance_of_the_walls_own_image(
    beside: Solution, monkeypatch: pytest.MonkeyPatch
) -> None:
    release, looked = beside.problem.inputs.release_m, []
    away = last_image(beside, release) - release
    own_rad, distance = wall_towards(away, UP)
    # images as far away, turned by a: 2 sin(a / 2) times as far apart, half as far at 29 degrees
    turned = own_rad + np.radians([-60.0, -31.0, 0.0, 27.0, 60.0])
    monkeypatch.setattr(wall_walk, "wall_grid", lambda: (turned, np.array([distance])))
    monkeypatch.setattr(
        wall_walk, "upright_planes", lambda middle, *where: upright_planes(np.append(release[:2], middle[2]), *where)
    )
    monkeypatch.setattr(wall_walk, "WALLS", replace(WALLS, azimuths=5))
    monkeypatch.setattr(wall_walk, "peaks", lambda table, *, around: [2, 3, 1, 0, 4])
    monkeypatch.setattr(wall_walk, "linearised_gains", lambda base, planes, done: np.zeros(len(planes)))
    monkeypatch.setattr(wall_walk, "best_started", lambda starts, most, done: looked.append((starts, most)) or [])
    assert wall_walk._elsewhere(beside, UP, nothing, WalkSettings()) == []
    ((starts, most),) = looked
    normals = [start.problem.inputs.planes[-1].normal for start in starts]
    angles = [np.degrees(np.arccos(normal @ upright(own_rad))) for normal in normals]
    assert (angles, most) == (pytest.approx([31.0, 60.0]), 1)
    # the wall is taken out of the motion that it has straightened
    assert all(start.state.coefficients is beside.state.coefficients for start in starts)


def upright(azimuth_rad: float) -> np.ndarray:
    return upright_planes(np.zeros(3), UP, np.array([azimuth_rad]), np.array([1.0]))[0].normal


@pytest.mark.parametrize(
    ("shift_m", "behind", "same"), [(0.0095, 14.0, True), (0.0105, 0.0, False), (0.0, 16.0, False)]
)
def test_walls_are_the_same_by_their_images_and_evidence(
    beside: Solution, shift_m: float, behind: float, same: bool
) -> None:
    # an image moves by twice as much as its wall: 2 cm count as one place
    one, other = score_of(beside, 0.0), score_of(with_plane(beside, 0.0, 0.0, shift_m), -behind)
    assert same_place(one, other) is same_place(other, one) is same


def test_maxima_two_places_apart_are_two() -> None:
    table = np.zeros((8, 6))
    table[2, 1], table[4, 1], table[2, 3] = 5.0, 4.0, 3.0
    assert [divmod(k, 6) for k in peaks(table, around=True)[:3]] == [(2, 1), (4, 1), (2, 3)]
    # one that lies beside a higher one is none, in either direction, nor is a place that gains nothing finite
    table[3, 1], table[2, 2], table[6, 5] = 4.5, 4.4, -np.inf
    assert not {(3, 1), (2, 2), (4, 1), (2, 3), (6, 5)} & {divmod(k, 6) for k in peaks(table, around=True)}


def trial(gain: float) -> WallTrial:
    solution: Any = SimpleNamespace(problem=object(), state=object(), evidence=100.0 + gain)
    return WallTrial(solution, gain)


def test_trials_nearly_as_good_as_the_best_go_on_and_the_others_stay(monkeypatch: pytest.MonkeyPatch) -> None:
    search, raced = WallSearch((trial(30.0), trial(15.5), trial(14.5))), []

    def race(starts: list[Start], rounds: int, *given: object) -> list[Any]:
        raced.append((starts, rounds))
        return [trial(31.0).solution, None]

    monkeypatch.setattr(walls, "race", race)
    monkeypatch.setattr(walls, "log_evidence", lambda one: one.evidence)
    found = _run_off(search, nothing, WALLS)
    assert [one.gain for one in found.tried] == [31.0, 14.5]
    ((starts, rounds),) = raced
    assert [start.state for start in starts] == [one.solution.state for one in search.tried[:2]]
    assert rounds == WALLS.last_rounds
    alone = WallSearch((trial(30.0), trial(14.5)))
    assert _run_off(alone, nothing, WALLS) is alone
    assert len(raced) == 1


@pytest.mark.parametrize(("thorough", "carried"), [(True, [4, 2]), (False, [2, 2])])
def test_a_thorough_search_carries_more_of_the_first_grid_and_the_second_looks_from_the_best_without_its_wall(
    beside: Solution, monkeypatch: pytest.MonkeyPatch, thorough: bool, carried: list[int]
) -> None:
    bare = solved_at(problem_with_mirrors(beside, ()))
    asked, looked, evidence = [], [], {id(bare): 0.0}
    kept = [bare]

    def race(starts: list[Start], *given: object) -> list[Solution]:
        # each search gains ten more than the one before
        kept.append(replace(beside))
        evidence[id(kept[-1])] = 10.0 * (len(kept) - 1) + 1.0
        return kept[-1:]

    def gains(base: Solution, planes: list[MirrorPlane], *given: object) -> np.ndarray:
        looked.append(base)
        return np.arange(len(planes), dtype=float)

    monkeypatch.setattr(walls, "linearised_gains", gains)
    monkeypatch.setattr(walls, "best_started", lambda starts, most, done: asked.append((len(starts), most)) or [])
    monkeypatch.setattr(walls, "race", race)
    monkeypatch.setattr(walls, "converge", lambda *given: bare)
    monkeypatch.setattr(walls, "log_evidence", lambda one: evidence.get(id(one), 0.0))
    monkeypatch.setattr(walls, "bent_by_maps", lambda one: False)
    monkeypatch.setattr(walls, "_run_off", lambda search, *given: search)
    search = search_wall(bare, UP, nothing, thorough=thorough)
    assert [most for _, most in asked] == carried
    assert [one.gain for one in search.tried] == [21.0, 11.0]
    assert looked[0] is bare
    # what the wall has straightened stays straight
    assert looked[1].state.coefficients is beside.state.coefficients
    assert looked[1].problem.inputs.planes == ()
    # gains that rise towards one place have one maximum
    assert asked[0][0] == 1
    assert search.foretold.size == wall_grid()[0].size * wall_grid()[1].size


@pytest.mark.parametrize(("gained", "searches"), [(1.9, 1), (2.1, 2)])
def test_another_look_is_taken_while_it_gains_what_is_worth_it(
    beside: Solution, monkeypatch: pytest.MonkeyPatch, gained: float, searches: int
) -> None:
    bare = solved_at(problem_with_mirrors(beside, ()))
    looked, evidence, kept = [], {id(bare): 0.0}, [bare]

    def race(starts: list[Start], *given: object) -> list[Solution]:
        kept.append(replace(beside))
        # the first gains fifteen, each further one so much more
        evidence[id(kept[-1])] = 15.0 + gained * (len(kept) - 2)
        return kept[-1:]

    def gains(base: Solution, planes: list[MirrorPlane], *given: object) -> np.ndarray:
        looked.append(base)
        return np.zeros(len(planes))

    monkeypatch.setattr(walls, "linearised_gains", gains)
    monkeypatch.setattr(walls, "best_started", lambda *given: [])
    monkeypatch.setattr(walls, "race", race)
    monkeypatch.setattr(walls, "converge", lambda *given: bare)
    monkeypatch.setattr(walls, "log_evidence", lambda one: evidence.get(id(one), 0.0))
    monkeypatch.setattr(walls, "bent_by_maps", lambda one: False)
    monkeypatch.setattr(walls, "_run_off", lambda search, *given: search)
    search_wall(bare, UP, nothing, thorough=True, settings=replace(WALLS, searches=3))
    assert len(looked) == searches + 1


def test_who_is_told_of_rounds_hears_of_each_start(beside: Solution) -> None:
    told: list[int] = []
    bare = solved_at(problem_with_mirrors(beside, ()))
    starts = [Start(bare.problem, bare.state)] * 3
    assert len(best_started(starts, 2, lambda: told.append(1))) == 2
    assert len(told) == 3


def test_taken_out_a_wall_leaves_everything_else_as_it_stands() -> None:
    made = small_problem((FLOOR_PLANE, WALL_PLANE), reflection=0.1)
    solution = solved_at(made.start)
    floored = problem_with_mirrors(solution, (FLOOR_PLANE,)).problem
    without = without_last_mirror(solution, floored)
    assert without.problem.inputs.planes == (FLOOR_PLANE,)
    assert without.state.coefficients is solution.state.coefficients
    theta, layout = without.state.theta, without.problem.layout
    assert theta[layout.transmitter_reflection].tolist() == [0.1, 0.0]
    for own, was in zip(layout.receivers, solution.problem.layout.receivers, strict=True):
        assert theta[own.constants].tolist() == solution.state.theta[was.constants].tolist()
        assert theta[own.receiver_reflection].tolist() == [0.1, 0.0]
    # a problem that has what the solution has not: at nothing
    wide = make_basis(positions_at_bins(solution), 0.04)
    other = problem_with_mirrors(solved_at(problem_with_mirrors(solution, (FLOOR_PLANE,))), (FLOOR_PLANE,), wide)
    assert wide.size > solution.problem.bias_basis.size
    found = without_last_mirror(solution, other.problem)
    (first, *_), was = other.problem.layout.receivers, solution.problem.layout.receivers[0]
    more = found.state.theta[first.bias_i][was.bias_i.stop - was.bias_i.start :]
    assert more.size > 0
    assert not more.any()
