"""Which of the mirrors that nothing excludes count, and by how much: against closed forms of their weights."""

from __future__ import annotations

import numpy as np
import pytest
from support.small_problem import FLOOR_PLANE, small_problem

from radargui.estimation.select.unseen_mirrors import UnseenSettings, unseen_mirrors
from radargui.estimation.solve.minimise import Solution, minimise

UP = np.array([0.0, 0.0, 1.0])
TEMPER = 5.0


@pytest.fixture(scope="module")
def solution() -> Solution:
    return minimise(small_problem((FLOOR_PLANE,), sigma=0.2).start, 3)


def foretold_of(likely: dict[int, float]) -> np.ndarray:
    """Return gains of the grid's walls by which some weigh so much where each is as likely as none."""
    grid = np.full(320, -1e9)
    grid[list(likely)] = TEMPER * np.log(list(likely.values()))
    return grid


def test_all_places_together_weigh_what_each_does_and_three_states_stand_for_them(solution: Solution) -> None:
    # three maxima of the grid are each as likely beforehand as no wall, what lies beside one as one place of 320
    foretold = foretold_of({7: 0.2, 100: 0.5, 101: 0.32, 300: 0.3})
    states, weight = unseen_mirrors(solution, UP, TEMPER, foretold, UnseenSettings(min_weight=1e-9))
    assert len(states) == 3
    assert 3.0 * weight == pytest.approx(1.0 + 0.32 / 320.0)


def test_what_is_less_likely_than_the_least_weight_is_nothing(solution: Solution) -> None:
    assert unseen_mirrors(solution, UP, TEMPER, foretold_of({100: 0.0099})) == ([], 0.0)
    states, weight = unseen_mirrors(solution, UP, TEMPER, foretold_of({100: 0.0101}))
    assert (len(states), weight) == (3, pytest.approx(0.0101 / 3.0))
