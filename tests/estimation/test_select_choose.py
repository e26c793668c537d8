"""What the evidence decides: floor, lengths, drift, alternatives, on small problems made for each decision."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

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
from radargui.estimation.adaptive.still_ellipse import StillEllipse
from radargui.estimation.forward.mirrors import MirrorPlane, has_floor
from radargui.estimation.forward.parameters import lobe_places
from radargui.estimation.forward.slow_noise import Drift
from radargui.estimation.hardware import LogFrontEnd
from radargui.estimation.select import budget, choose
from radargui.estimation.select.choose import ChoiceSettings, _Selection, choose_model
from radargui.estimation.select.chosen_model import Alternative, ChosenModel
from radargui.estimation.select.fewer_bins import fewer_bins, with_bins_of
from radargui.estimation.solve.changed_problem import problem_with_mirrors
from radargui.estimation.solve.minimise import Solution, chi_square, log_evidence, minimise, solved_at
from radargui.estimation.solve.problem import State
from radargui.geometry.path_length import path_lengths
from radargui.model.errors import SolveError

UP = np.array([0.0, 0.0, 1.0])


def nothing() -> None:
    """Report no progress."""


def rounds(made: SmallProblem, *, lands: bool = True) -> SimpleNamespace:
    """Return the adaptive rounds on a small problem's bins: all of them that a choice reads."""
    data = made.data
    away = path_lengths(positions(data.bins.time_s), data.antennas)
    counted = 2.0 * np.pi * (away - away[:, :1]) / data.wavelength_m
    ellipses = tuple(
        StillEllipse(c.offset_i, c.offset_q, c.log_gain, c.quadrature_error_rad, float(np.exp(c.log_amplitude)))
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


def chosen(made: SmallProblem, drift: Drift | None = None, **settings: float) -> ChosenModel:
    return choose_model(rounds(made), drift or no_drift(), UP, nothing, None, ChoiceSettings(**settings))


MIRRORS = {"reflection": 0.06, "shown": (FLOOR_PLANE, WALL_PLANE), "sigma": 0.005}


@pytest.fixture(scope="module")
def whole() -> ChosenModel:
    """The data have a floor and a wall 14 cm along +x; what is searched for is all that there is."""
    return chosen(small_problem(**MIRRORS))


@pytest.mark.slow
def test_a_search_that_runs_out_of_its_budget_keeps_what_it_has_and_says_so(
    whole: ChosenModel, monkeypatch: pytest.MonkeyPatch
) -> None:
    made = small_problem(**MIRRORS)
    assert not whole.ended_early
    spent: list[int] = []
    monkeypatch.setattr(budget, "ROUNDS", (1, 30))
    monkeypatch.setattr(budget, "BIN_ROUNDS", 28 * made.data.bins.n_bins)
    ended = choose_model(rounds(made), no_drift(), UP, lambda: spent.append(1), None)
    assert ended.ended_early
    assert any("was ended after 28 rounds" in sentence for sentence in ended.choices)
    # that there is a floor was beyond doubt, and what it chose is no alternative to itself
    assert ended.alternatives == ()
    assert len(spent) <= 28 + 1 + ChoiceSettings().last_rounds


def test_a_search_without_any_model_within_its_budget_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(budget, "ROUNDS", (3, 3))
    with pytest.raises(SolveError, match="did not end within 3 rounds"):
        chosen(small_problem(reflection=0.15, shown=(FLOOR_PLANE,), sigma=0.005))


def test_where_no_body_describes_the_signals_the_search_ends_and_says_how_far_off_each_receiver_is() -> None:
    made = small_problem(reflection=0.15, shown=(FLOOR_PLANE,), sigma=0.005)
    with pytest.raises(budget.NoSingleBodyError, match="chi-square") as caught:
        chosen(made, hopeless_misfit=0.1, most_left=0.001)
    assert caught.value.misfit.shape == (made.data.antennas.n_receivers,)
    assert (caught.value.misfit < 2.0).all()


def test_a_misfit_that_is_next_to_nothing_of_the_wave_is_what_reflectors_leave_in_loud_signals() -> None:
    # laboratory 7304306: a misfit of 120 is 0.01 of the wave, and the wall that explains it is found
    made = small_problem(reflection=0.15, shown=(FLOOR_PLANE,), sigma=0.005, n_bins=60)
    assert chosen(made, hopeless_misfit=0.1, most_left=0.03).solution.settled


def test_what_looks_lost_is_refused_only_where_no_wall_puts_it_right(monkeypatch: pytest.MonkeyPatch) -> None:
    # laboratory hands 24013644 and 24014226: maps as large as waves, and 0.02 and 0.009 mm with the wall that was found
    asked: list[int] = []

    def lacks_wall(solution: Solution, onset_s: float) -> bool:
        asked.append(len(solution.problem.inputs.planes))
        return asked[-1] < 2

    monkeypatch.setattr(choose, "is_lost", lacks_wall)
    assert len(chosen(small_problem(**MIRRORS)).solution.problem.inputs.planes) == 2
    assert asked == [2, 2]
    monkeypatch.setattr(choose, "is_lost", lambda solution, onset_s: True)
    with pytest.raises(budget.LooseMapsError):
        chosen(small_problem(reflection=0.15, shown=(FLOOR_PLANE,), sigma=0.005, n_bins=60))


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


def test_a_doubtful_floor_is_compared_again_once_the_breaks_are_settled(monkeypatch: pytest.MonkeyPatch) -> None:
    made = small_problem(reflection=0.15, shown=(FLOOR_PLANE,), sigma=0.005)
    asked = []
    again = _Selection.floor_compared_again
    monkeypatch.setattr(_Selection, "floor_compared_again", lambda *args: asked.append(1) or again(*args))
    chosen(made, beyond_doubt=1e9, most_walls=0)
    chosen(made, beyond_doubt=0.0, most_walls=0)
    assert asked == [1]


def test_a_floor_is_compared_again_beside_a_wall_that_was_found_without_it_and_begins_its_place_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    made = small_problem((WALL_PLANE,), reflection=0.15, shown=(FLOOR_PLANE, WALL_PLANE), sigma=0.005)
    selection = _Selection(rounds(made), no_drift(), UP, nothing, None, ChoiceSettings())
    alone, again = selection.converged(made.start, 2), []
    converged = selection.converged
    monkeypatch.setattr(selection, "converged", lambda start, rounds: again.append(start) or converged(start, rounds))
    best, gain, others = selection.floor_compared_again(alone)
    assert [plane.name for plane in best.problem.inputs.planes] == ["floor", "wall"]
    # more than the race goes on for
    assert gain == ChoiceSettings().most_behind[-1] * made.data.bins.value.size
    assert others == ()
    # what it leans by for want of its reflection is not kept
    (start,) = again
    layout, theta = start.problem.layout, start.state.theta
    assert theta[layout.planes][:3].tolist() == [0.0, 0.0, 0.0]
    assert theta[layout.transmitter_reflection][0] == pytest.approx(0.15, abs=0.05)


def test_the_model_without_a_floor_that_hardly_gains_stays_possible() -> None:
    made = small_problem((FLOOR_PLANE,), reflection=0.15)
    floored = minimise(made.start, 12)
    bare = minimise(problem_with_mirrors(floored, ()), 12)
    gain = log_evidence(floored) - log_evidence(bare)
    # as if it gained one
    selection = _Selection(rounds(made), no_drift(), UP, nothing, None, ChoiceSettings(temper=gain))
    assert selection.preferred(bare, floored) is floored
    (other,) = selection._alternatives(floored, [bare, floored])
    assert other.solution is bare
    assert other.weight == pytest.approx(np.exp(-1.0))


def test_lobes_of_the_direct_wave_are_no_floor() -> None:
    # antennas of 23 dB, where the prior expects 16
    model = chosen(small_problem(sigma=0.005, lobe=-4.0), most_walls=0)
    assert "left out" in model.choices[0]
    lobes = lobe_places(model.solution.problem.layout)
    assert model.solution.state.theta[lobes[1::3]] == pytest.approx([-4.0] * 4, abs=0.3)


def test_few_fringes_make_other_lengths_tried() -> None:
    made = small_problem(sigma=0.005)
    selection = _Selection(rounds(made), no_drift(), UP, nothing, None, ChoiceSettings())
    alone = selection.converged(selection.from_rounds(selection.found, 0.09, ()), 4)
    # breaks that were settled have parted the bins otherwise
    alone = solved_at(with_bins_of(alone, fewer_bins(selection.whole, np.array([0.15, 0.2]))))
    assert alone.problem.bins.n_bins != selection.data.bins.n_bins
    solution, others = selection.other_lengths(alone)
    lengths = {solution.problem.bias_basis.length_m, *(one.solution.problem.bias_basis.length_m for one in others)}
    assert lengths <= {0.09, 0.14, 0.22}
    # of shorter and longer ones the likeliest is kept: all three went through the same rounds
    assert all(log_evidence(solution) >= log_evidence(one.solution) for one in others)
    assert all(0.01 < other.weight <= 1.0 for other in others)


def test_a_floor_that_the_motion_does_not_touch_is_sought_at_several_depths() -> None:
    deep = replace(FLOOR_PLANE, foot_m=FLOOR_PLANE.foot_m - np.array([0.0, 0.0, 0.25]))
    made = small_problem(reflection=0.1, shown=(deep,), sigma=0.005)
    height, evidence = {}, {}
    for lands in (False, True):
        selection = _Selection(rounds(made, lands=lands), no_drift(), UP, nothing, None, ChoiceSettings())
        solution = selection.floor()[0]
        (plane,) = solution.problem.inputs.planes
        unknown = solution.problem.layout.plane_unknowns(solution.state.theta)[0]
        height[lands] = 0.5 * float(plane.image(np.zeros(3), unknown)[2])
        evidence[lands] = log_evidence(solution)
    # where it lands there is one start, just below the lowest place, and 25 cm to go
    assert abs(height[False] + 0.36) < 0.5 * abs(height[True] + 0.36)
    assert evidence[False] > evidence[True] + 5.0


def test_walls_are_weighed_against_every_floor_and_length_together(monkeypatch: pytest.MonkeyPatch) -> None:
    made = small_problem()
    solution = minimise(made.start, 2)
    lengths, walls = (Alternative(solution, 0.5), Alternative(solution, 0.5)), [Alternative(solution, 0.25)]
    monkeypatch.setattr(_Selection, "floor", lambda self: (solution, -1.0, ()))
    monkeypatch.setattr(_Selection, "with_flights", lambda self, *given: given)
    monkeypatch.setattr(_Selection, "other_lengths", lambda self, one: (one, lengths))
    monkeypatch.setattr(_Selection, "walls", lambda self, one: (one, walls, []))
    monkeypatch.setattr("radargui.estimation.select.choose.unseen_mirrors", lambda *given: ([], 0.0))
    model = chosen(made, few_fringes=1e9, last_rounds=1)
    assert [other.weight for other in model.alternatives] == [0.5, 0.5, 0.25 * 2.0]


def test_mirrors_that_nothing_excludes_are_weighed_against_all_others_together(monkeypatch: pytest.MonkeyPatch) -> None:
    solution, asked = minimise(small_problem().start, 2), []
    states = [State(solution.state.coefficients, solution.state.theta + shift) for shift in (0.1, 0.2)]
    monkeypatch.setattr(_Selection, "floor", lambda self: (solution, -1.0, (Alternative(solution, 0.5),)))
    monkeypatch.setattr(_Selection, "with_flights", lambda self, *given: given)
    monkeypatch.setattr(_Selection, "walls", lambda self, one: (one, [Alternative(solution, 0.25)], []))

    def unseen(*given: object) -> tuple[list[State], float]:
        asked.append(given)
        return states, 0.1

    monkeypatch.setattr("radargui.estimation.select.choose.unseen_mirrors", unseen)
    made, stages = small_problem(), []
    settings = ChoiceSettings(last_rounds=1, temper=7.0)
    model = choose_model(rounds(made), no_drift(), UP, nothing, None, settings, stages.append)
    assert stages == ["flights", "walls", "last"]
    assert "Bias maps with a correlation length of 0.09 m." in model.choices
    # 1.5 times as much, a wall beside the best and beside its alternative; then 1 + 0.5 + 0.375 stand against these
    assert [other.weight for other in model.alternatives] == pytest.approx([0.5, 0.375, 0.1875, 0.1875])
    assert [other.solution.state for other in model.alternatives[2:]] == states
    assert all(other.solution.problem is model.solution.problem for other in model.alternatives[2:])
    ((_, normal, temper, _),) = asked
    assert (normal.tolist(), temper) == (UP.tolist(), 7.0)
    of_receivers = ", ".join(f"{value:.2f}" for value in chi_square(model.solution))
    assert f"Misfit (chi-square) {of_receivers}." in model.choices


def test_a_search_that_ran_out_counts_what_it_left_open_alike_and_no_copy_of_what_it_chose(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    # a weak wall alone leaves open whether there is a floor
    made = small_problem(reflection=0.06, shown=(WALL_PLANE,), sigma=0.005)
    monkeypatch.setattr(budget, "ROUNDS", (1, 20))
    monkeypatch.setattr(budget, "BIN_ROUNDS", 20 * made.data.bins.n_bins)
    model = choose_model(rounds(made), no_drift(), UP, nothing, None)
    assert model.ended_early
    assert "The search for walls was ended after 20 rounds." in model.choices
    assert not has_floor(model.solution.problem.inputs.planes)
    assert model.solution.problem.in_flight.any()
    (other,) = model.alternatives
    assert other.weight == 1.0
    assert has_floor(other.solution.problem.inputs.planes)
    # it flies as well: without, it would say of g and e less than is known
    assert other.solution.problem.in_flight.any()


def test_the_floor_is_sought_below_the_lowest_place_along_its_normal() -> None:
    normal = np.array([0.6, 0.0, 0.8])
    selection = _Selection(rounds(small_problem()), no_drift(), normal, nothing, None, ChoiceSettings())
    place = np.array([[0.0, 0.3, -0.3], [0.1, 0.2, 0.3], [0.0, -0.1, -0.05]])
    plane = selection.floor_below(place, 0.02)
    # heights 0, 0.1 and -0.22 along the normal: the third, though the second is lower along z
    assert plane.foot_m == pytest.approx([-0.312, 0.3, -0.066])
    assert (plane.normal.tolist(), plane.name) == (normal.tolist(), "floor")


def test_a_model_that_was_given_up_is_worse_by_what_models_are_given_up_for() -> None:
    made = small_problem()
    solution = minimise(made.start, 1)
    selection = _Selection(rounds(made), no_drift(), UP, nothing, None, ChoiceSettings(most_behind=(0.5, 0.25)))
    least = 0.25 * made.data.bins.value.size
    assert (selection.gain_of(None, solution), selection.gain_of(solution, None)) == (least, -least)
    assert selection.preferred(None, solution) is selection.preferred(solution, None) is solution
    assert selection.gain_of(solution, solution) == 0.0


@pytest.mark.parametrize(
    ("planes", "deviation", "misfit", "asks"),
    [
        ((), 0.1, 1.0, False),
        ((FLOOR_PLANE,), 0.1, 1.0, True),
        ((FLOOR_PLANE,), 0.0019, 1.0, False),
        ((), 0.0, 1.2, True),
        ((FLOOR_PLANE,), 0.0, 1.14, False),
    ],
)
def test_residuals_ask_for_walls_and_maps_that_grow_although_a_floor_is_there(
    planes: tuple[MirrorPlane, ...], deviation: float, misfit: float, asks: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    made = small_problem(planes)
    selection = _Selection(rounds(made), no_drift(), UP, nothing, None, ChoiceSettings())
    monkeypatch.setattr(selection, "misfit", lambda one: np.array([0.5, misfit, 0.5]))
    monkeypatch.setattr("radargui.estimation.select.choose.bias_deviations", lambda one: np.array([0.0, deviation]))
    assert selection._asks_for_walls(minimise(made.start, 1)) is asks


def test_drift_and_flicker_noise_are_told() -> None:
    made = small_problem()
    slow = Drift(0.0, 0.45, 4, np.full((6, 4), 0.01), np.zeros(6))
    assert "The offsets drift" in " ".join(chosen(made, slow, most_walls=0).choices)
    flicker = Drift(0.0, 0.45, 4, np.full((6, 4), 0.01), np.full(6, 1e-6))
    assert "1/f noise found" in " ".join(chosen(made, flicker, most_walls=0).choices)


def test_an_alternative_weighs_by_its_tempered_evidence() -> None:
    selection = _Selection(rounds(small_problem()), no_drift(), UP, nothing, None, ChoiceSettings(temper=5.0))
    assert selection._weight(0.0) == selection._weight(3.0) == 1.0
    assert selection._weight(-5.0) == pytest.approx(np.exp(-1.0))


def test_a_known_front_end_is_believed_where_the_run_says_little() -> None:
    made = small_problem(sigma=0.2)
    known = [LogFrontEnd(c.log_gain, 1e-4, c.quadrature_error_rad, 1e-4) for c in CONSTANTS]
    model = choose_model(rounds(made), no_drift(), UP, nothing, known, ChoiceSettings(most_walls=0))
    for own, constants in zip(model.solution.problem.layout.receivers, CONSTANTS, strict=True):
        assert model.solution.state.theta[own.log_gain] == pytest.approx(constants.log_gain, abs=5e-4)
