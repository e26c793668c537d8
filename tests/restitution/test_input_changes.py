"""What the test of the flights widens and tells."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from support.words import words

from radargui.estimation.posterior.input_response import possible_spheres
from radargui.model.assumed import CLOCK, DIAMETER, TILT, uncertain_inputs
from radargui.model.finding import warn
from radargui.model.setup import read_setup
from radargui.model.setup_posterior import EXACT
from radargui.restitution.flight_fit import FlightFit
from radargui.restitution.input_changes import (
    INSTANTS,
    SPHERE,
    SetupResponses,
    judged_flights,
    setup_responses,
)
from radargui.system.resources import default_setup_path


def judged(misfit: tuple[float, int], bend: float, unexplained: float = 5.0) -> Any:
    estimate: Any = SimpleNamespace(time_s=np.zeros(1), u_position_m=np.ones((3, 1)))
    fit: Any = SimpleNamespace(misfit=misfit, bends=lambda _: np.zeros(0), bend_over_u=lambda *_: bend)
    fit.excess = lambda explained: FlightFit.excess(fit, explained)
    return judged_flights(fit, estimate, unexplained)


@pytest.mark.parametrize("point", [True, False])
def test_inputs_are_asked_for_that_move_a_motion_which_its_own_unknowns_do_not_hold(point: bool) -> None:
    setup = read_setup(default_setup_path())
    first, *others = setup.receiver
    setup = setup.model_copy(update={"receiver": (first.model_copy(update={"u_tilt_deg": 0.0}), *others)})
    posterior: Any = SimpleNamespace(is_point=point, responses=lambda inputs, time_s: tuple(inputs))
    chosen = SimpleNamespace(setup=None)
    estimate: Any = SimpleNamespace(posterior=posterior, time_s=np.linspace(0.0, 1.0, 100_000), chosen=chosen)
    found = setup_responses(estimate, setup)
    stated = {one.key for one in uncertain_inputs(setup)}
    # floor and clock move no motion, and angles of antennas are unknowns of its own
    moves = {key for key in stated - {TILT, CLOCK, DIAMETER} if not key.endswith("polarization_deg")}
    assert set(found.keys) - {SPHERE, DIAMETER} == moves
    assert len(found.each) == len(found.keys)
    # what a point would be were it a sphere, or what another diameter would be
    assert (SPHERE in found.keys, DIAMETER in found.keys) == (point, not point)
    assert found.keys.count(SPHERE) == (len(possible_spheres(setup)) if point else 0)
    # what is called exact is asked for too: by as much as it usually is known to
    assert "receiver[1].tilt_deg" in found.exact
    assert "receiver[1].tilt_deg" in found.keys
    assert found.time_s.size < 2 * INSTANTS


def test_what_noise_makes_is_neither_told_nor_widened() -> None:
    test = judged((215.0, 200), 0.1)
    assert test.bent is None
    assert test.widening == pytest.approx(np.hypot(1.0, 0.1))


def test_a_misfit_beyond_noise_widens_by_birges_ratio_where_the_motion_keeps_to_its_flights() -> None:
    test = judged((300.0, 200), 0.1)
    assert test.bent is None
    assert test.widening == pytest.approx(np.sqrt(1.5))


def test_a_misfit_that_nothing_explains_is_told_though_the_motion_keeps_to_its_flights() -> None:
    test = judged((1009.0, 223), 0.6, 37.0)
    assert "something that changed during the motion" in words(test.bent)
    assert "widened 2.1 times" in words(test.bent)
    assert test.widening == pytest.approx(np.sqrt(1009.0 / 223.0))
    # what the setup explains if it is off by more than its u is told of places, not here
    assert judged((1009.0, 223), 0.6, 2.0).bent is None


def test_flights_that_bend_by_more_than_u_beyond_noise_are_told() -> None:
    test = judged((300.0, 200), 1.2)
    assert "the flights bend" in words(test.bent)
    assert test.widening == pytest.approx(2.0)
    assert judged((2000.0, 200), 1.2).widening == pytest.approx(np.sqrt(10.0))
    assert judged((215.0, 200), 1.2).bent is None


def test_maps_change_by_what_uncertain_inputs_give_them_together_and_one_sphere_of_many() -> None:
    keys, sizes = ("a", "exact", SPHERE, SPHERE, "b"), (3.0, 100.0, 2.0, 6.0, 4.0)
    each: Any = tuple(SimpleNamespace(bias=np.array([size, 0.0])) for size in sizes)
    found = SetupResponses(np.zeros(1), keys, each, frozenset({"exact"})).bias_deviations()
    assert found == pytest.approx([np.sqrt(9.0 + 16.0 + 20.0 + (EXACT * 100.0) ** 2), 0.0])
    assert not SetupResponses(np.zeros(1), (), ()).bias_deviations().any()


def test_a_cause_is_guessed_at_by_what_would_explain_the_flights() -> None:
    of_setup, test = judged((2000.0, 200), 1.2, 0.5), judged((2000.0, 200), 1.2)
    assert "likely a reflector" in words(test.bent)
    assert "likely a setup that is wrong" in words(of_setup.bent)
    assert test.bent.with_facts(guess="", remedy="").text == (
        "the flights bend by more than what is known can make them (chi-square 2000 of 200): the uncertainties of "
        "track, e and g were widened 3.2 times"
    )
    release, rest = (warn("setup_contradicted", explains=explains) for explains in (True, False))
    assert replace(test, cause=release).is_explained
    assert not replace(test, cause=rest).is_explained
