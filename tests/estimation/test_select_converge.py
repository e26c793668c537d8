"""Rounds of a model: when noise follows the misfit, when they end, which solution of several is kept."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from support.small_problem import SmallProblem, small_problem

from radargui.estimation.select import converge as converge_module
from radargui.estimation.select.converge import COARSE, _away, _best, _impacts, converge, convergence
from radargui.estimation.solve.problem import Start

UP = np.array([0.0, 0.0, 1.0])


def nothing() -> None:
    """Report no progress."""


@pytest.fixture(scope="module")
def louder() -> SmallProblem:
    """Noise of a bin that is twice what its deviation says."""
    made = small_problem(n_bins=120)
    bins = replace(made.problem.bins, sigma=0.5 * made.problem.bins.sigma)
    return replace(made, problem=replace(made.problem, bins=bins))


@pytest.mark.parametrize("first", [0, 2])
def test_the_noise_follows_the_misfit_from_its_round_on_and_never_before(louder: SmallProblem, first: int) -> None:
    settings = replace(COARSE, noise_from_round=first, least_rounds=99)
    scales = [one.problem.noise_scale for one, _ in convergence(louder.start, first + 1, settings)]
    assert len(scales) == first + 2
    assert all(one.tolist() == [1.0] * 3 for one in scales[:-1])
    # by no more than its largest step
    assert scales[-1] == pytest.approx(1.3)


def test_rounds_stop_with_the_first_that_changes_little_once_there_were_enough(monkeypatch: pytest.MonkeyPatch) -> None:
    made = small_problem(n_bins=120)
    evidence = iter([0.0, 10.0, 10.1, 10.2, 11.0, 11.1, 30.0])
    monkeypatch.setattr(converge_module, "log_evidence", lambda one: next(evidence))
    settings = replace(COARSE, least_rounds=3, settled_ln_evidence=0.2)
    # the second round changes as little as the fifth, but is too early
    found = [value for _, value in convergence(made.start, 6, settings)]
    assert found == [0.0, 10.0, 10.1, 10.2, 11.0, 11.1]


def test_of_solutions_that_fit_alike_the_one_with_most_impacts_is_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    made: Any = [
        SimpleNamespace(misfit=1.000, impacts=(1, -0.1)),
        SimpleNamespace(misfit=1.019, impacts=(2, -0.3)),
        SimpleNamespace(misfit=1.010, impacts=(2, -0.2)),
        # one more, and worse than what another knot changes
        SimpleNamespace(misfit=1.021, impacts=(3, -0.1)),
    ]
    monkeypatch.setattr(converge_module, "_misfit", lambda one: one.misfit)
    monkeypatch.setattr(converge_module, "_impacts", lambda one, normal: one.impacts)
    assert _best(made, UP) is made[2]


def test_impacts_count_and_the_least_known_decides(monkeypatch: pytest.MonkeyPatch) -> None:
    speeds = SimpleNamespace(
        u_jump_m_s=np.array([0.9, 0.2, 0.3]), are_impacts=lambda: np.array([False, True, True]), time_s=np.arange(3)
    )
    monkeypatch.setattr(converge_module, "break_speeds", lambda *given: speeds)
    solution: Any = SimpleNamespace()
    assert _impacts(solution, UP) == (2, -0.3)
    speeds.are_impacts = lambda: np.zeros(3, bool)
    assert _impacts(solution, UP) == (0, 0.0)


def test_moments_near_others_are_left_out() -> None:
    moments, others = np.array([0.1, 0.2, 0.3]), np.array([0.2014, 0.3016])
    assert _away(moments, others, 0.0015).tolist() == [0.1, 0.3]
    assert _away(moments, np.zeros(0), 0.0015).tolist() == moments.tolist()


def test_a_round_in_which_nothing_moves_keeps_maps_and_what_the_data_say(monkeypatch: pytest.MonkeyPatch) -> None:
    made, kept = small_problem(n_bins=120), []
    minimise_on = converge_module.minimise_on

    def seen(start: Start, steps: int, settings: Any, *given: Any) -> Any:
        kept.append(len(given) > 1 and given[1] is not None)
        return minimise_on(start, steps, settings, *given)

    monkeypatch.setattr(converge_module, "minimise_on", seen)
    # the first minimum moves from the truth by tenths of a millimetre, the rounds at the minimum by less than a metre
    for within, wanted in ((1.0, [False, True, True]), (0.0, [False, False, False])):
        kept.clear()
        settings = replace(COARSE, same_place_m=within, same_mirrors=1.0, noise_from_round=9, least_rounds=9)
        converge(made.start, 2, nothing, settings)
        assert kept == wanted
