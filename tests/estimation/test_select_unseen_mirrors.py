"""Which of the mirrors that nothing excludes count, and by how much: against closed forms of their weights."""

from __future__ import annotations

import numpy as np
import pytest
from support.small_problem import FLOOR_PLANE, small_problem

from radargui.estimation.forward.mirrors import FLOOR, MirrorPlane
from radargui.estimation.select import unseen_mirrors as unseen_module
from radargui.estimation.select.unseen_mirrors import UnseenSettings, unseen_mirrors
from radargui.estimation.select.wall_grid import LinearisedSearch, wall_grid
from radargui.estimation.solve.changed_problem import positions_at_bins
from radargui.estimation.solve.minimise import Solution, minimise

UP = np.array([0.0, 0.0, 1.0])
TEMPER = 5.0


@pytest.fixture(scope="module")
def solution() -> Solution:
    return minimise(small_problem((FLOOR_PLANE,), sigma=0.2).start, 3)


def shares_of(
    solution: Solution, likely: dict[int, float], settings: UnseenSettings, monkeypatch: pytest.MonkeyPatch
) -> tuple[dict[int, float], float]:
    """Return the shares of the grid's walls where some weigh so much times the prior of a place, others nothing."""
    grid, taken, asked = np.full(320, -1e9), [], []
    grid[list(likely)] = TEMPER * np.log(list(likely.values()))

    def gains(self: LinearisedSearch, planes: list[MirrorPlane]) -> np.ndarray:
        first = sum(asked)
        asked.append(len(planes))
        return grid[first : first + len(planes)]

    moved = unseen_module._moved

    def seen(search: LinearisedSearch, planes: list[MirrorPlane], share: np.ndarray) -> np.ndarray:
        taken.append(share)
        return moved(search, planes, share)

    monkeypatch.setattr(LinearisedSearch, "gains", gains)
    monkeypatch.setattr(unseen_module, "_moved", seen)
    _, weight = unseen_mirrors(solution, UP, TEMPER, settings=settings)
    assert sum(asked) == 320
    (share,) = taken
    return {int(k): float(share[k]) for k in np.flatnonzero(share)}, weight


def test_no_more_places_stand_for_all_than_hold_the_share_asked_for(
    solution: Solution, monkeypatch: pytest.MonkeyPatch
) -> None:
    settings = UnseenSettings(stand_for=0.7, least_weight=1e-9)
    # half of all weight, and three tenths, are more than seven
    shares, weight = shares_of(solution, {7: 0.2, 100: 0.5, 319: 0.3}, settings, monkeypatch)
    assert shares == pytest.approx({100: 0.625, 319: 0.375})
    # all places together are as likely beforehand as no mirror, each alike, and three states stand for them
    assert weight == pytest.approx(1.0 / 320.0 / 3.0)


def test_of_the_places_that_would_count_the_likeliest_are_taken(
    solution: Solution, monkeypatch: pytest.MonkeyPatch
) -> None:
    settings = UnseenSettings(places=2, stand_for=1.0, least_weight=1e-9)
    shares, _ = shares_of(solution, {7: 0.2, 100: 0.6, 319: 0.2001}, settings, monkeypatch)
    assert shares == pytest.approx({100: 0.6 / 0.8001, 319: 0.2001 / 0.8001})


def test_what_is_less_likely_than_the_least_weight_is_nothing(
    solution: Solution, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(LinearisedSearch, "gains", lambda self, planes: np.full(len(planes), TEMPER * np.log(0.0099)))
    assert unseen_mirrors(solution, UP, TEMPER) == ([], 0.0)
    monkeypatch.setattr(LinearisedSearch, "gains", lambda self, planes: np.full(len(planes), TEMPER * np.log(0.0101)))
    states, weight = unseen_mirrors(solution, UP, TEMPER)
    assert (len(states), weight) == (3, pytest.approx(0.0101 / 3.0))


def test_second_moments_of_what_moves_are_those_of_the_states(
    solution: Solution, monkeypatch: pytest.MonkeyPatch
) -> None:
    kept: list[np.ndarray] = []
    moved = unseen_module._moved

    def seen(search: LinearisedSearch, planes: list[MirrorPlane], share: np.ndarray) -> np.ndarray:
        kept.append(moved(search, planes, share))
        return kept[-1]

    monkeypatch.setattr(unseen_module, "_moved", seen)
    # mean and eight deviations of T and R, of each of four places: as many directions, and nothing is left out
    states, _ = unseen_mirrors(solution, UP, TEMPER, settings=UnseenSettings(places=4, directions=36))
    (columns,), n_motion = kept, solution.state.coefficients.size
    steps = np.array([(one.coefficients - solution.state.coefficients).ravel() for one in states])
    assert columns.shape[1] == len(states) == 36
    wanted = columns[:n_motion] @ columns[:n_motion].T
    assert steps.T @ steps / 36.0 == pytest.approx(wanted, abs=1e-9 * wanted.max())
    globally = np.array([one.theta - solution.state.theta for one in states])
    wanted = columns[n_motion:] @ columns[n_motion:].T
    assert globally.T @ globally / 36.0 == pytest.approx(wanted, abs=1e-9 * wanted.max())
    # what moves together stays together
    wanted = columns[:n_motion] @ columns[n_motion:].T
    assert steps.T @ globally / 36.0 == pytest.approx(wanted, abs=1e-9 * np.abs(wanted).max())
    # of few directions those that move the places most
    three, _ = unseen_mirrors(solution, UP, TEMPER, settings=UnseenSettings(places=4, directions=3))
    at_bins = np.stack([solution.at.design @ one.reshape(-1, 3) for one in columns[:n_motion].T]).reshape(36, -1)
    largest = np.sort(np.linalg.eigvalsh(at_bins @ at_bins.T))[-3:]
    few = [solution.at.design @ (one.coefficients - solution.state.coefficients) for one in three]
    assert [float((one**2).sum()) / 3.0 for one in few] == pytest.approx(largest)


def test_of_walls_that_were_not_tried_the_highest_maxima_round_the_circle_count_as_much_as_none(
    solution: Solution, monkeypatch: pytest.MonkeyPatch
) -> None:
    taken: list[np.ndarray] = []
    moved = unseen_module._moved
    monkeypatch.setattr(
        unseen_module, "_moved", lambda search, planes, share: taken.append(share) or moved(search, planes, share)
    )
    foretold = np.full((40, 8), -1e9)
    # the first is beside the last: one maximum, not two
    foretold[0, 3], foretold[39, 3] = 0.0, -0.1
    foretold[10, 0], foretold[20, 7], foretold[30, 4], foretold[35, 1] = -0.2, -0.3, -0.4, -0.5
    settings = UnseenSettings(stand_for=1.0, least_weight=1e-9)
    unseen_mirrors(solution, UP, TEMPER, foretold.ravel(), settings)
    (share,) = taken
    weight = np.exp(foretold.ravel() / TEMPER)
    # four of the maxima are each as likely as no wall, all else as one place of 320
    weight *= np.where(np.isin(np.arange(320), [3, 80, 167, 244]), 1.0, 1.0 / 320.0)
    assert share[:48] == pytest.approx((weight / weight.sum())[:48], abs=1e-12)
    assert share[[80, 167, 244, 281, 315]] == pytest.approx((weight / weight.sum())[[80, 167, 244, 281, 315]])


def test_floors_are_sought_below_the_lowest_place_at_small_depths_and_those_of_walls(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    bare, asked = minimise(small_problem(sigma=0.2).start, 2), []
    monkeypatch.setattr(
        LinearisedSearch, "gains", lambda self, planes: asked.append((self, planes)) or np.zeros(len(planes))
    )
    unseen_mirrors(bare, UP, TEMPER)
    ((search, planes),) = asked
    lowest = positions_at_bins(bare)[2].min()
    depths = [lowest - plane.foot_m[2] for plane in planes]
    assert depths == pytest.approx([*UnseenSettings().floor_below_m, *wall_grid()[1]])
    assert {plane.name for plane in planes} == {FLOOR}
    assert search.reflection == UnseenSettings().floor_reflection
