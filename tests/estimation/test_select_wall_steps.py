"""How the search for a wall and its walk go on or end: each rule on trials made for it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.small_problem import FLOOR_PLANE, WALL_PLANE, small_problem

from radargui.estimation.forward.position_map import make_basis
from radargui.estimation.select.race import best_started, same_place, score_of
from radargui.estimation.select.walls import (
    peaks,
    without_last_mirror,
)
from radargui.estimation.solve.changed_problem import positions_at_bins, problem_with_mirrors
from radargui.estimation.solve.minimise import Solution, solved_at
from radargui.estimation.solve.problem import Start, State


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
