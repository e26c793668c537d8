"""What the test of the flights widens and tells."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from radargui.restitution.flight_fit import FlightFit
from radargui.restitution.input_changes import SPHERE, FlightTest, SetupResponses, _tested


def judged(misfit: tuple[float, int], bend: float, unexplained: float = 5.0) -> Any:
    estimate: Any = SimpleNamespace(time_s=np.zeros(1), u_position_m=np.ones((3, 1)))
    fit: Any = SimpleNamespace(misfit=misfit, bends=lambda _: np.zeros(0), bend_over_u=lambda *_: bend)
    fit.excess = lambda explained: FlightFit.excess(fit, explained)
    return _tested(fit, SetupResponses(np.zeros(1), (), ()), estimate, unexplained)


def test_what_noise_makes_is_neither_told_nor_widened() -> None:
    test = judged((215.0, 200), 0.1)
    assert test.warning == ""
    assert test.widening == pytest.approx(np.hypot(1.0, 0.1))


def test_a_misfit_beyond_noise_widens_by_birges_ratio_where_the_motion_keeps_to_its_flights() -> None:
    test = judged((300.0, 200), 0.1)
    assert test.warning == ""
    assert test.widening == pytest.approx(np.sqrt(1.5))


def test_a_misfit_that_nothing_explains_is_told_though_the_motion_keeps_to_its_flights() -> None:
    test = judged((1009.0, 223), 0.6, 37.0)
    assert "something that changed during the motion" in test.warning
    assert "widened 2.1 times" in test.warning
    assert test.widening == pytest.approx(np.sqrt(1009.0 / 223.0))
    # what the setup explains if it is off by more than its u is told of places, not here
    assert judged((1009.0, 223), 0.6, 2.0).warning == ""


def test_flights_that_bend_by_more_than_u_beyond_noise_are_told() -> None:
    test = judged((300.0, 200), 1.2)
    assert "the flights bend" in test.warning
    assert test.widening == pytest.approx(2.0)
    assert judged((2000.0, 200), 1.2).widening == pytest.approx(np.sqrt(10.0))
    assert judged((215.0, 200), 1.2).warning == ""


def test_maps_change_by_what_uncertain_inputs_give_them_together_and_one_sphere_of_many() -> None:
    keys, sizes = ("a", "exact", SPHERE, SPHERE, "b"), (3.0, 100.0, 2.0, 6.0, 4.0)
    each: Any = tuple(SimpleNamespace(bias=np.array([size, 0.0])) for size in sizes)
    found = SetupResponses(np.zeros(1), keys, each, frozenset({"exact"})).bias_deviations()
    assert found == pytest.approx([np.sqrt(9.0 + 16.0 + 20.0), 0.0])
    assert not SetupResponses(np.zeros(1), (), ()).bias_deviations().any()


def test_a_cause_that_is_named_takes_the_place_of_the_guess() -> None:
    of_setup, test = judged((2000.0, 200), 1.2, 0.5), judged((2000.0, 200), 1.2)
    assert test.warnings == (test.warning,)
    assert "likely a reflector" in test.warning
    assert "likely a setup that is wrong" in of_setup.warning
    assert FlightTest(of_setup.warning, 2.0, "a").warnings[1] == FlightTest(test.warning, 2.0, "a").warnings[1]
    cause, bent = FlightTest(test.warning, test.widening, "the release is wrong").warnings
    assert cause == "the release is wrong"
    assert bent == (
        "the flights bend by more than what is known can make them (chi-square 2000 of 200): the uncertainties of "
        "track, e and g were widened 3.2 times"
    )
    beside = FlightTest(test.warning, test.widening, "the release leaves much of it", explained=False)
    assert beside.warnings == ("the release leaves much of it", test.warning)
