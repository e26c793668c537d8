"""What the evidence decides: floor, lengths, drift, alternatives, on small problems made for each decision."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from support.small_problem import (
    BOUNCE_S,
    CONSTANTS,
    FLOOR_PLANE,
    START_S,
    WALL_PLANE,
    SmallProblem,
    no_drift,
    positions,
    small_problem,
)

from radargui.estimation.adaptive.rounds import first_round, next_round, still_round
from radargui.estimation.forward.slow_noise import Drift
from radargui.estimation.hardware import LogFrontEnd
from radargui.estimation.select.budget import NoSingleBodyError
from radargui.estimation.select.choose import ChoiceSettings, choose_model
from radargui.estimation.select.chosen_model import ChosenModel
from radargui.estimation.solve.minimise import log_evidence
from radargui.model.errors import SolveError
from radargui.physics.mirrors import has_floor
from radargui.physics.path_length import path_lengths
from radargui.signals.ellipse import Ellipse

UP = np.array([0.0, 0.0, 1.0])


def nothing() -> None:
    """Report no progress."""


def rounds(made: SmallProblem, *, lands: bool = True) -> SimpleNamespace:
    """Return the adaptive rounds on a small problem's bins: all of them that a choice reads."""
    data = made.data
    away = path_lengths(positions(data.bins.time_s), data.antennas)
    counted = 2.0 * np.pi * (away - away[:, :1]) / data.wavelength_m
    ellipses = tuple(
        Ellipse(c.offset_i, c.offset_q, np.exp(c.log_amplitude), np.exp(c.log_gain), c.quadrature_error_rad)
        for c in CONSTANTS
    )
    first = first_round(data, still_round(data, ellipses, counted))
    return SimpleNamespace(
        data=data,
        first=first,
        last=next_round(data, first, 0.13),
        fringes=np.ptp(counted, axis=1) / (2.0 * np.pi),
        impact_s=np.array([BOUNCE_S] if lands else []),
        break_s=np.array([BOUNCE_S]),
        signals=SimpleNamespace(rest_end_s=START_S),
        other_counts=lambda normal: [],
    )


def chosen(made: SmallProblem, drift: Drift | None = None, **settings: Any) -> ChosenModel:
    return choose_model(rounds(made), drift or no_drift(), UP, nothing, None, ChoiceSettings(**settings))


MIRRORS = {"reflection": 0.06, "shown": (FLOOR_PLANE, WALL_PLANE), "sigma": 0.005}


@pytest.fixture(scope="module")
def whole() -> ChosenModel:
    """The data have a floor and a wall 14 cm along +x; what is searched for is all that there is."""
    return chosen(small_problem(**MIRRORS))


@pytest.mark.slow
def test_a_search_that_runs_out_of_its_budget_keeps_what_it_has_and_says_so(whole: ChosenModel) -> None:
    made = small_problem(**MIRRORS)
    assert not whole.ended_early
    spent: list[int] = []
    settings = ChoiceSettings(rounds=(1, 30), bin_rounds=28 * made.data.bins.n_bins)
    ended = choose_model(rounds(made), no_drift(), UP, lambda: spent.append(1), None, settings)
    assert ended.ended_early
    assert any("was ended after 28 rounds" in sentence for sentence in ended.choices)
    # that there is a floor was beyond doubt, and what it chose is no alternative to itself
    assert ended.alternatives == ()
    assert len(spent) <= 28 + 1 + ChoiceSettings().last_rounds


def test_a_search_without_any_model_within_its_budget_is_refused() -> None:
    with pytest.raises(SolveError, match="did not end within 3 rounds"):
        chosen(small_problem(reflection=0.15, shown=(FLOOR_PLANE,), sigma=0.005), rounds=(3, 3))


def test_where_no_body_describes_the_signals_the_search_ends_and_says_how_far_off_each_receiver_is() -> None:
    made = small_problem(reflection=0.15, shown=(FLOOR_PLANE,), sigma=0.005)
    with pytest.raises(NoSingleBodyError, match="chi-square") as caught:
        chosen(made, hopeless_misfit=0.1, max_left=0.001)
    assert caught.value.misfit.shape == (made.data.antennas.n_receivers,)
    assert (caught.value.misfit < 2.0).all()


def test_a_misfit_that_is_next_to_nothing_of_the_wave_is_what_reflectors_leave_in_loud_signals() -> None:
    # laboratory 7304306: a misfit of 120 is 0.01 of the wave, and the wall that explains it is found
    made = small_problem(reflection=0.15, shown=(FLOOR_PLANE,), sigma=0.005, n_bins=60)
    assert chosen(made, hopeless_misfit=0.1, max_left=0.03).solution.settled


def test_a_floor_and_a_wall_that_reflect_are_kept_and_the_wall_is_where_it_stands(whole: ChosenModel) -> None:
    assert "floor that reflects is kept" in whole.choices[0]
    assert any("wall that reflects is kept" in choice for choice in whole.choices)
    problem, theta = whole.solution.problem, whole.solution.state.theta
    assert [plane.name for plane in problem.inputs.planes] == ["floor", "wall"]
    assert theta[problem.layout.transmitter_reflection][0::2] == pytest.approx(0.06, abs=0.01)
    image = problem.inputs.planes[1].image(np.zeros(3), problem.layout.plane_unknowns(theta)[1])
    assert image / 2.0 == pytest.approx([0.14, 0.0, 0.0], abs=0.01)


def test_a_floor_that_does_not_reflect_is_left_out_and_no_wall_is_asked_for() -> None:
    model = chosen(small_problem(sigma=0.005))
    assert "left out" in model.choices[0]
    assert model.solution.problem.inputs.planes == ()
    assert not any("wall" in choice for choice in model.choices)


def test_the_model_without_a_floor_that_hardly_gains_stays_possible() -> None:
    made = small_problem(reflection=0.02, shown=(FLOOR_PLANE,), sigma=0.005)
    # as if its gain were as good as none
    model = chosen(made, max_walls=0, temper=1e9, max_behind=(1e9, 1e9))
    bare = [one for one in model.alternatives if not has_floor(one.solution.problem.inputs.planes)]
    assert has_floor(model.solution.problem.inputs.planes)
    assert bare[0].weight == pytest.approx(1.0, abs=1e-3)


def test_a_floor_that_the_motion_does_not_touch_is_sought_at_several_depths() -> None:
    deep = replace(FLOOR_PLANE, foot_m=FLOOR_PLANE.foot_m - np.array([0.0, 0.0, 0.25]))
    made = small_problem(reflection=0.1, shown=(deep,), sigma=0.005)
    height, evidence = {}, {}
    for lands in (False, True):
        settings = ChoiceSettings(max_walls=0, last_rounds=1)
        solution = choose_model(rounds(made, lands=lands), no_drift(), UP, nothing, None, settings).solution
        (plane,) = solution.problem.inputs.planes
        unknown = solution.problem.layout.plane_unknowns(solution.state.theta)[0]
        height[lands] = 0.5 * float(plane.image(np.zeros(3), unknown)[2])
        evidence[lands] = log_evidence(solution)
    # where it lands there is one start, just below the lowest place, and 25 cm to go
    assert abs(height[False] + 0.36) < 0.5 * abs(height[True] + 0.36)
    assert evidence[False] > evidence[True] + 5.0


def test_drift_and_flicker_noise_are_told() -> None:
    made = small_problem()
    slow = Drift(0.0, 0.45, 4, np.full((6, 4), 0.01), np.zeros(6))
    assert "The offsets drift" in " ".join(chosen(made, slow, max_walls=0).choices)
    flicker = Drift(0.0, 0.45, 4, np.full((6, 4), 0.01), np.full(6, 1e-6))
    assert "1/f noise found" in " ".join(chosen(made, flicker, max_walls=0).choices)


def test_a_known_front_end_is_believed_where_the_run_says_little() -> None:
    made = small_problem(sigma=0.2)
    known = [LogFrontEnd(c.log_gain, 1e-4, c.quadrature_error_rad, 1e-4) for c in CONSTANTS]
    model = choose_model(rounds(made), no_drift(), UP, nothing, known, ChoiceSettings(max_walls=0))
    for own, constants in zip(model.solution.problem.layout.receivers, CONSTANTS, strict=True):
        assert model.solution.state.theta[own.log_gain] == pytest.approx(constants.log_gain, abs=5e-4)
