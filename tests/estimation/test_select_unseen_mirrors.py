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
    states, weight = unseen_mirrors(solution, UP, TEMPER, foretold, UnseenSettings(least_weight=1e-9))
    assert len(states) == 3
    assert 3.0 * weight == pytest.approx(1.0 + 0.32 / 320.0)


def test_no_more_places_stand_for_all_than_hold_the_share_asked_for(solution: Solution) -> None:
    def moved(likely: dict[int, float], settings: UnseenSettings) -> np.ndarray:
        states, _ = unseen_mirrors(solution, UP, TEMPER, foretold_of(likely), settings)
        steps = np.array([(one.coefficients - solution.state.coefficients).ravel() for one in states])
        return np.asarray(steps.T @ steps)

    # half of all weight, and three tenths, are more than seven: the third place moves nothing
    some = moved({7: 0.2, 100: 0.5, 300: 0.3}, UnseenSettings(stand_for=0.7, least_weight=1e-9))
    two = moved({100: 0.5, 300: 0.3}, UnseenSettings(stand_for=1.0, least_weight=1e-9))
    assert some == pytest.approx(two, abs=1e-9 * np.abs(two).max())
    # nor does it where no more than two places are taken
    most = moved({7: 0.2, 100: 0.5, 300: 0.3}, UnseenSettings(places=2, stand_for=1.0, least_weight=1e-9))
    assert most == pytest.approx(two, abs=1e-9 * np.abs(two).max())
    every = moved({7: 0.2, 100: 0.5, 300: 0.3}, UnseenSettings(stand_for=1.0, least_weight=1e-9))
    assert np.abs(every - two).max() > 0.01 * np.abs(two).max()


def test_what_is_less_likely_than_the_least_weight_is_nothing(solution: Solution) -> None:
    assert unseen_mirrors(solution, UP, TEMPER, foretold_of({100: 0.0099})) == ([], 0.0)
    states, weight = unseen_mirrors(solution, UP, TEMPER, foretold_of({100: 0.0101}))
    assert (len(states), weight) == (3, pytest.approx(0.0101 / 3.0))


def test_maxima_go_round_the_circle_of_azimuths_and_the_highest_four_count_as_much_as_none(solution: Solution) -> None:
    # the first is beside the last: one maximum, not two
    foretold = foretold_of({3: 0.5, 39 * 8 + 3: 0.4, 80: 0.3, 167: 0.2, 244: 0.1, 281: 0.05})
    _, weight = unseen_mirrors(solution, UP, TEMPER, foretold, UnseenSettings(least_weight=1e-9))
    assert 3.0 * weight == pytest.approx(0.5 + 0.3 + 0.2 + 0.1 + (0.4 + 0.05) / 320.0)
