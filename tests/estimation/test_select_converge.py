"""Rounds of a model: when noise follows the misfit, when they end, which solution of several is kept."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from support.small_problem import SmallProblem, small_problem

from radargui.estimation.select import converge as converge_module
from radargui.estimation.select.converge import (
    COARSE,
    _away,
    _best,
    _bounced_on,
    _impacts,
    converge,
    convergence,
    settle_breaks,
)
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
        SimpleNamespace(settled=True, misfit=1.000, impacts=(1, -0.1)),
        SimpleNamespace(settled=True, misfit=1.019, impacts=(2, -0.3)),
        SimpleNamespace(settled=True, misfit=1.010, impacts=(2, -0.2)),
        # one more, and worse than what another knot changes
        SimpleNamespace(settled=True, misfit=1.021, impacts=(3, -0.1)),
        # and one that came to no minimum
        SimpleNamespace(settled=False, misfit=1.010, impacts=(4, -0.1)),
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


def broken(*break_s: float, misfit: float = 1.0) -> Any:
    """Return what settling asks of a solution with breaks."""
    breaks = np.array(break_s)
    spline = SimpleNamespace(break_s=breaks, edge_s=np.array([0.0, 1.0]))
    problem = SimpleNamespace(prior=SimpleNamespace(mean=breaks), layout=SimpleNamespace(breaks=slice(0, breaks.size)))
    state, at = SimpleNamespace(coefficients=None), SimpleNamespace(spline=spline)
    return SimpleNamespace(problem=problem, state=state, at=at, misfit=misfit)


def settling(monkeypatch: pytest.MonkeyPatch, turns: Any, good: Any) -> tuple[Any, list[list[float]]]:
    """Settle breaks where turns are seen in a solution, and breaks at moments are good; return the end and each try."""
    tried: list[list[float]] = []

    def converged(breaks: np.ndarray, *given: object) -> Any:
        tried.append(breaks.tolist())
        return broken(*breaks)

    def speeds(solution: Any, normal: object) -> Any:
        break_s = solution.at.spline.break_s
        are = np.array([good(one) for one in break_s], dtype=bool)
        return SimpleNamespace(time_s=break_s, are_kinks=lambda: are, are_kicks=lambda: are)

    for name, stand_in in {
        "_bounced_on": lambda data, solution, *given: solution,
        "break_speeds": speeds,
        "sharp_turns": lambda solution, normal: np.array(turns(solution)),
        "side_kicks": lambda solution, normal: np.zeros(0),
        "kicks_beside": lambda motion, normal, *given: (np.zeros(0), np.zeros(0)),
        "misfit_times": lambda solution: np.zeros(0),
        "respline": lambda old, coefficients, breaks, fine: breaks,
        "_with_breaks": lambda data, solution, motion: motion,
        "converge": converged,
        "_best": lambda seen, normal: seen[-1],
        "SplineMotion": lambda spline, coefficients: None,
    }.items():
        monkeypatch.setattr(converge_module, name, stand_in)
    data: Any = SimpleNamespace(onset_s=0.05, gravity_m_s2=9.81)
    return settle_breaks(data, broken(0.3), UP, nothing), tried


def test_a_break_that_was_dropped_is_not_tried_again(monkeypatch: pytest.MonkeyPatch) -> None:
    # a ripple that always looks like a turn, and never jumps
    found, tried = settling(monkeypatch, lambda solution: [0.15], lambda moment: moment == 0.3)
    assert tried == [[0.15, 0.3], [0.3]]
    assert found.at.spline.break_s.tolist() == [0.3]


def test_breaks_are_added_at_most_five_times_and_kept_where_they_are_good(monkeypatch: pytest.MonkeyPatch) -> None:
    # each solution shows one more turn
    found, tried = settling(monkeypatch, lambda one: [0.4 + 0.01 * one.at.spline.break_s.size], lambda moment: True)
    assert len(tried) == COARSE.break_rounds - 1
    assert found.at.spline.break_s == pytest.approx([0.3, 0.41, 0.42, 0.43, 0.44, 0.45])


@pytest.mark.parametrize(
    ("more", "misfit", "kept"), [(True, 1.0, True), (True, 1.019, True), (True, 1.021, False), (False, 0.5, False)]
)
def test_a_body_is_let_bounce_on_where_that_finds_impacts_and_fits_no_worse(
    monkeypatch: pytest.MonkeyPatch, more: bool, misfit: float, kept: bool
) -> None:
    start, tried = broken(0.2, 0.3, 0.45), []

    def speeds(solution: Any, normal: object) -> Any:
        # the second break is the last impact; the body lands again at 0.4 and 0.48, once
        expected = np.array([0.4, 0.48]) if solution is start else np.zeros(0)
        impacts = np.array([True, True, False]) if solution is start else np.ones(3 if more else 2, dtype=bool)
        return SimpleNamespace(
            time_s=solution.at.spline.break_s,
            u_jump_m_s=np.zeros(impacts.size),
            are_impacts=lambda: impacts,
            expected_impacts=lambda end_s: expected,
        )

    def converged(breaks: np.ndarray, *given: object) -> Any:
        tried.append(breaks.tolist())
        return broken(*breaks, misfit=misfit)

    monkeypatch.setattr(converge_module, "break_speeds", speeds)
    monkeypatch.setattr(converge_module, "respline", lambda old, coefficients, breaks, fine: breaks)
    monkeypatch.setattr(converge_module, "_with_breaks", lambda data, solution, motion: motion)
    monkeypatch.setattr(converge_module, "converge", converged)
    monkeypatch.setattr(converge_module, "_misfit", lambda one: one.misfit)
    data: Any = SimpleNamespace(onset_s=0.05, gravity_m_s2=9.81)
    found = _bounced_on(data, start, UP, nothing)
    # what came after the last impact is begun again
    assert tried == [[0.2, 0.3, 0.4, 0.48]]
    assert (found is not start) is kept
