"""How walls are asked for, kept, moved on and weighed: each rule of the choice on searches made for it."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from support.small_problem import FLOOR_PLANE, WALL_PLANE

from radargui.estimation.select import choose
from radargui.estimation.select.choose import ChoiceSettings, _decided, _Selection
from radargui.estimation.select.chosen_model import Alternative
from radargui.estimation.select.walls import WallSearch, WallTrial

UP = np.array([0.0, 0.0, 1.0])


def solution_of(evidence: float, *planes: object) -> Any:
    """Return what the choice asks of a solution."""
    inputs = SimpleNamespace(planes=planes)
    return SimpleNamespace(evidence=evidence, problem=SimpleNamespace(inputs=inputs), settled=True)


@pytest.fixture
def selection(monkeypatch: pytest.MonkeyPatch) -> _Selection:
    """A selection without data: solutions carry their evidence, misfits and breaks are what a test makes them."""
    made: Any = object.__new__(_Selection)
    made.settings, made.normal, made.round_done, made.rough = ChoiceSettings(temper=10.0), UP, lambda: None, None
    made.foretold, made.compared, made.whole = None, [], SimpleNamespace(bins=SimpleNamespace(value=np.zeros(4)))
    made.found = SimpleNamespace(data=SimpleNamespace(onset_s=0.0))
    made.data = SimpleNamespace(surface=None)
    monkeypatch.setattr(choose, "is_lost", lambda one, onset_s: False)
    monkeypatch.setattr(choose, "log_evidence", lambda one: one.evidence)
    monkeypatch.setattr(choose, "settle_breaks", lambda data, one, *given: one)
    return made  # type: ignore[no-any-return]


def search_of(*trials: tuple[float, Any], foretold: float = -5.0) -> WallSearch:
    return WallSearch(tuple(WallTrial(one, gain) for gain, one in trials), np.array([foretold]))


def searching(
    monkeypatch: pytest.MonkeyPatch, selection: Any, searches: list[WallSearch], misfits: list[float], *, asks: bool
) -> list[bool]:
    """Let searches find these one after the other, at these misfits; return how thorough each was asked to be."""
    asked: list[bool] = []

    def search_wall(*given: object, thorough: bool, **_: object) -> WallSearch:
        asked.append(thorough)
        return searches[len(asked) - 1]

    monkeypatch.setattr(choose, "search_wall", search_wall)
    monkeypatch.setattr(selection, "misfit", lambda one: np.array([misfits[min(len(asked), len(misfits) - 1)]]))
    monkeypatch.setattr(selection, "_asks_for_walls", lambda one: asks)
    return asked


def test_beside_a_mirror_a_wall_is_looked_for_coarsely_though_nothing_asks_for_it(
    monkeypatch: pytest.MonkeyPatch, selection: _Selection
) -> None:
    bare, floored = solution_of(0.0), solution_of(0.0, FLOOR_PLANE)
    weak = search_of((4.0, solution_of(4.0)), (-10.0, solution_of(-10.0)), (-100.0, solution_of(-100.0)))
    thorough = searching(monkeypatch, selection, [weak, weak], [1.0], asks=False)
    assert selection.walls(bare) == (bare, [], [])
    assert thorough == []
    solution, undecided, (said,) = selection.walls(floored)
    assert solution is floored
    assert thorough == [False]
    assert said == "A wall that reflects is left out: log evidence +4."
    # too weak to convince they stay possible, by their tempered evidence; e^-10 is nothing
    assert [one.weight for one in undecided] == pytest.approx([1.0, np.exp(-1.0)])
    assert selection.foretold is None


def test_where_none_was_tried_what_the_grid_foretells_is_kept(
    monkeypatch: pytest.MonkeyPatch, selection: _Selection
) -> None:
    thorough = searching(monkeypatch, selection, [search_of(foretold=-20.0)], [1.0], asks=True)
    _, undecided, (said,) = selection.walls(solution_of(0.0, FLOOR_PLANE))
    assert (undecided, thorough) == ([], [True])
    assert said == "A wall that reflects is left out: log evidence -20."
    assert selection.foretold is not None
    assert selection.foretold.tolist() == [-20.0]


@pytest.mark.parametrize(("misfit", "searches"), [(1.14, 1), (1.16, 2)])
def test_a_second_wall_is_sought_where_residuals_are_left_and_no_third(
    monkeypatch: pytest.MonkeyPatch, selection: Any, misfit: float, searches: int
) -> None:
    found = [solution_of(20.0, FLOOR_PLANE, WALL_PLANE), solution_of(40.0, FLOOR_PLANE, WALL_PLANE, WALL_PLANE)]
    each = [search_of((20.0, one)) for one in found]
    thorough = searching(monkeypatch, selection, each, [1.5, misfit, 1.5], asks=True)
    left = [[Alternative(found[0], 0.3)], [Alternative(found[1], 0.4)]]
    monkeypatch.setattr(selection, "moved_on", lambda one: (one.tried[0].solution, left[len(thorough) - 1]))
    solution, undecided, sentences = selection.walls(solution_of(0.0, FLOOR_PLANE))
    assert thorough == [True] * searches
    assert solution is found[searches - 1]
    # a wall's other places are counted beside that wall
    assert undecided == left[searches - 1]
    assert sentences == ["A wall that reflects is kept: log evidence +20."] * searches


def test_a_wall_found_without_a_floor_has_the_floor_compared_again_and_its_other_places_lack_it(
    monkeypatch: pytest.MonkeyPatch, selection: Any
) -> None:
    walled, both = solution_of(20.0, WALL_PLANE), solution_of(35.0, FLOOR_PLANE, WALL_PLANE)
    searching(monkeypatch, selection, [search_of((20.0, walled))], [1.0], asks=True)
    place, bare = Alternative(walled, 0.5), Alternative(walled, 0.2)
    monkeypatch.setattr(selection, "moved_on", lambda one: (walled, [place]))
    monkeypatch.setattr(selection, "floor_compared_again", lambda one: (both, 15.0, (bare,)))
    solution, undecided, sentences = selection.walls(solution_of(0.0))
    assert solution is both
    # e^-1.5 as likely as those with the floor
    assert [one.weight for one in undecided] == pytest.approx([0.2, 0.5 * np.exp(-1.5)])
    assert sentences[1] == "Beside it a floor that reflects is kept: log evidence +15."


def test_other_places_of_a_wall_are_weighed_against_where_it_has_walked(
    monkeypatch: pytest.MonkeyPatch, selection: Any
) -> None:
    # the search gained 20 over what had 100; the walk led to 135
    first, second, third = solution_of(120.0), solution_of(115.0), solution_of(70.0)
    best, passed = solution_of(135.0), solution_of(130.0)
    settled: list[Any] = []
    monkeypatch.setattr(choose, "walked", lambda one, *given: [best, passed, one])
    monkeypatch.setattr(choose, "settle_breaks", lambda data, one, *given: settled.append(one) or one)
    found, undecided = selection.moved_on(search_of((20.0, first), (15.0, second), (-30.0, third)))
    assert found is best
    assert [one.solution for one in undecided] == [second, passed, first]
    assert [one.weight for one in undecided] == pytest.approx(np.exp([-2.0, -0.5, -1.5]))
    # what walked has bounces that a wall out of place hid
    assert settled == [first, best]
    settled.clear()
    monkeypatch.setattr(choose, "walked", lambda one, *given: [one])
    selection.moved_on(search_of((20.0, first)))
    assert settled == [first]


def test_a_solution_with_all_slow_noise_is_asked_for_once(monkeypatch: pytest.MonkeyPatch, selection: Any) -> None:
    few, every = np.zeros((6, 10, 2)), np.zeros((6, 10, 4))
    data = SimpleNamespace(drift=every)
    monkeypatch.setattr(choose, "fewer_bins", lambda whole, breaks: data)
    monkeypatch.setattr(choose, "with_bins_of", lambda solution, data: "start")
    monkeypatch.setattr(choose, "solved_at", lambda start: f"solved at {start}")
    selection.whole = None

    def solution(drift: np.ndarray) -> Any:
        inputs, at = SimpleNamespace(drift=drift), SimpleNamespace(spline=SimpleNamespace(break_s=np.zeros(0)))
        return SimpleNamespace(problem=SimpleNamespace(inputs=inputs), at=at)

    has_all = solution(every)
    assert selection.with_all_noise(has_all) is has_all
    assert selection.with_all_noise(solution(few)) == "solved at start"


@pytest.mark.parametrize(("found_m", "length_m"), [(None, 0.09), (0.06, 0.09), (0.2, 0.2)])
def test_no_bias_map_beside_a_floor_is_shorter_than_what_mirrors_do(
    monkeypatch: pytest.MonkeyPatch, selection: Any, found_m: float | None, length_m: float
) -> None:
    asked: list[float] = []
    bias = None if found_m is None else SimpleNamespace(length_m=found_m)
    place = np.zeros((3, 4))
    selection.found = SimpleNamespace(
        last=SimpleNamespace(bias=bias, place=place), impact_s=np.array([0.2]), other_counts=lambda normal: []
    )
    solution = solution_of(0.0)
    monkeypatch.setattr(selection, "from_rounds", lambda found, length, planes: asked.append(length))
    monkeypatch.setattr(choose, "best_started", lambda *given: [])
    monkeypatch.setattr(selection, "raced", lambda starts: [solution, solution_of(-1.0)])
    monkeypatch.setattr(selection, "misfit", lambda one: np.array([1.0]))
    found, gain, others = selection.floor()
    assert asked == [length_m, length_m]
    assert (found, gain) == (solution, -1.0)
    assert [one.weight for one in others] == pytest.approx([np.exp(-0.1)])


@pytest.mark.parametrize(
    ("gain", "misfit", "again"),
    [(-1.0, 1.0, False), (50.0, 1.0, True), (101.0, 1.0, False), (-1.0, 2.1, True), (500.0, 2.1, True)],
)
def test_a_doubtful_gain_or_a_misfit_that_blinds_has_the_floor_compared_again(
    monkeypatch: pytest.MonkeyPatch, selection: Any, gain: float, misfit: float, again: bool
) -> None:
    selection.found = SimpleNamespace(
        last=SimpleNamespace(bias=None, place=np.zeros((3, 4))), impact_s=np.zeros(1), other_counts=lambda normal: []
    )
    asked: list[object] = []
    monkeypatch.setattr(selection, "from_rounds", lambda *given: None)
    monkeypatch.setattr(choose, "best_started", lambda *given: [])
    monkeypatch.setattr(selection, "raced", lambda starts: [solution_of(0.0), solution_of(gain)])
    # the worst receiver decides
    monkeypatch.setattr(selection, "misfit", lambda one: np.array([1.0, misfit, 1.0]))
    monkeypatch.setattr(selection, "floor_compared_again", lambda one: asked.append(one) or (one, 0.0, ()))
    selection.floor()
    assert bool(asked) is again


def test_what_was_decided_is_said_with_its_gain_and_none_beyond_what_is_found_out() -> None:
    assert _decided("A floor", 12.4) == "A floor is kept: log evidence +12."
    assert _decided("A wall", 9.9, 10.0) == "A wall is left out: log evidence +10."
    assert _decided("A floor", -59.4) == "A floor is left out: log evidence -59."
    assert _decided("A floor", -61.0) == "A floor is left out: log evidence beyond -60."
    assert _decided("A floor", 1e5) == "A floor is kept: log evidence beyond +60."
    # a wall's gain is told to what a race follows
    assert choose.WALLS.most_behind[-1] == 60.0
