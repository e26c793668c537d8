"""Which place of a setup is named where flights and g contradict it."""

from __future__ import annotations

import re
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from radargui.model.assumed import uncertain_inputs
from radargui.model.setup import Setup
from radargui.model.setup_posterior import EXACT
from radargui.restitution.setup_chi_square import SetupChiSquare
from radargui.restitution.setup_outlier import SetupOutlier, setup_outlier, wrong_value

SETUP = Setup.model_validate(
    {
        "schema": 1,
        "radar": {"refractive_index": 1.00032},
        "transmitter": {"distance_m": 0.7},
        "receiver": tuple({"tilt_deg": 40.0, "azimuth_deg": a, "distance_m": 0.7} for a in (90.0, 210.0, 330.0)),
        "tracer": {"density_kg_m3": 7800.0, "release_position_m": (0.0, 0.0, 0.12)},
    }
)
KEYS = tuple(one.key for one in uncertain_inputs(SETUP) if one.key not in ("floor.tilt_deg", "daq.clock_ppm"))
N_FLIGHTS = 200


def judged(
    true: dict[str, float],
    *,
    g_m_s2: float = 9.80,
    keys: tuple[str, ...] = KEYS,
    setup: Setup = SETUP,
    besides: float = 0.0,
) -> SetupOutlier | None:
    """Judge flights that bend as inputs that are off by so many u make them, and besides, without noise."""
    return setup_outlier(chi_square(true, g_m_s2, keys, setup, besides), keys, setup)


def chi_square(
    true: dict[str, float],
    g_m_s2: float = 9.80,
    keys: tuple[str, ...] = KEYS,
    setup: Setup = SETUP,
    besides: float = 0.0,
    strength: float = 1.0,
) -> SetupChiSquare:
    rng = np.random.default_rng(1)
    bends = strength * rng.normal(size=(N_FLIGHTS, len(keys)))
    by_g = 1e-3 * rng.normal(size=len(keys))
    wrong = np.array([true.get(key, 0.0) for key in keys])
    # flights agree where what is added to the setup is `wrong`
    away = -bends @ wrong + besides * rng.normal(size=N_FLIGHTS)
    misfit = (float(away @ away) + N_FLIGHTS, N_FLIGHTS)
    fit: Any = SimpleNamespace(g_m_s2=g_m_s2 - by_g @ wrong, u_g_m_s2=1e-3, misfit=misfit)
    fit.against = lambda _: (bends.T @ bends, bends.T @ away)
    fit.follow = lambda response: np.array([response])
    responses: Any = by_g.tolist()
    stated = {one.key: one.u for one in uncertain_inputs(setup)}
    own = np.array([EXACT**-2.0 if stated.get(key) == 0.0 else float(keys.count(key)) for key in keys])
    return SetupChiSquare.of(fit, responses, own, np.zeros(len(keys)), setup)


def test_a_setup_that_is_right_within_its_u_names_nothing() -> None:
    rng = np.random.default_rng(2)
    for _ in range(20):
        assert judged(dict(zip(KEYS, rng.normal(size=len(KEYS)).tolist(), strict=True))) is None


def test_a_receiver_that_stands_elsewhere_is_named_with_what_has_to_be_added() -> None:
    found = judged({"receiver[2].tilt_deg": -20.0, "receiver[1].azimuth_deg": 1.0})
    assert found is not None
    assert "likely receiver[2] is wrong, adding tilt_deg -10 would agree (20 times" in found.finding.text
    assert found.off["receiver[2].tilt_deg"] == pytest.approx(-20.0, abs=0.2)


def test_a_release_that_is_elsewhere_is_one_place_with_three_coordinates() -> None:
    found = judged({"tracer.release_position_m[1]": 30.0, "tracer.release_position_m[3]": -40.0})
    assert found is not None
    assert "tracer.release_position_m is wrong, adding x +30 mm, z -40 mm would agree (40 times" in found.finding.text


def test_a_g_that_no_place_explains_is_left_to_wavelength_and_clock() -> None:
    assert judged({}, g_m_s2=10.2) is None


def test_spheres_that_are_possible_are_no_places() -> None:
    found = judged({"sphere": 30.0}, keys=("sphere", "sphere", *KEYS))
    assert found is None
    assert judged({}, keys=("sphere", "sphere")) is None


def test_the_flights_answer_as_one_matrix_what_they_answer_for_each_input() -> None:
    """`FlightFit.bends` is the diagonal of `against`, whose c vanishes where nothing parts flights and motion."""
    from radargui.restitution.flight_fit import FlightFit

    rng = np.random.default_rng(3)
    root: NDArray[np.float64] = rng.normal(size=(9, 9))
    form = root @ root.T
    jacobian = rng.normal(size=(9, 4))
    information: Any = SimpleNamespace(
        form=SimpleNamespace(solve=lambda right: np.linalg.solve(form, right)),
        eliminated=SimpleNamespace(marginal=lambda slope: slope),
        minimum=lambda: np.zeros(9),
    )
    away = np.linalg.solve(form, np.linalg.qr(jacobian, mode="complete")[0][:, 4:] @ rng.normal(size=5))
    fit = FlightFit(
        np.zeros(2), np.eye(2), (1.0, 5), np.zeros(1), 0.0, 1.0, information, np.zeros((2, 9)), jacobian,
        jacobian.T @ form @ jacobian, away,
    )  # fmt: skip
    slopes = rng.normal(size=(9, 3))
    responses: Any = [SimpleNamespace(slope=one) for one in slopes.T]
    cost, pull = fit.against(responses)
    np.testing.assert_allclose(fit.bends(responses), np.diag(cost))
    # what parts flights and motion after a change, by hand
    shift = np.linalg.solve(form, slopes) - jacobian @ np.linalg.solve(fit.normal, jacobian.T @ slopes)
    np.testing.assert_allclose(cost, shift.T @ form @ shift, atol=1e-9)
    np.testing.assert_allclose(pull, shift.T @ form @ away, atol=1e-9)


def test_what_is_beyond_a_linear_answer_is_told_without_a_number() -> None:
    found = judged({"receiver[3].distance_m": -1000.0})
    assert found is not None
    assert "receiver[3] is wrong, adding much to distance_m would agree (1000 times" in found.finding.text


def test_a_release_outside_the_room_is_not_named() -> None:
    found = judged({"tracer.release_position_m[1]": 900.0})
    assert found is not None
    assert "tracer.release_position_m is wrong" in found.finding.text
    found = judged({"tracer.release_position_m[1]": 2000.0, "tracer.release_position_m[2]": 40000.0})
    assert found is not None
    assert "likely receiver[" in found.finding.text
    assert "tracer.release_position_m" not in found.finding.text


def test_places_that_explain_it_as_well_are_named_beside_it_and_that_receivers_may_be_exchanged() -> None:
    off = {"receiver[1].azimuth_deg": 40.0, "receiver[2].azimuth_deg": -40.0}
    found = judged(off)
    assert found is not None
    assert "or receivers are exchanged)" in found.finding.text


def test_values_that_are_called_exact_are_doubted_by_what_a_laboratory_knows_them_to() -> None:
    tables = SETUP.model_dump(by_alias=True, exclude_unset=True)
    exact = {f"u_{name}": 0.0 for name in ("tilt_deg", "azimuth_deg", "distance_m")}
    tables["receiver"] = tuple({**one, **exact} for one in tables["receiver"])
    setup = Setup.model_validate(tables)
    assert judged({}, setup=setup) is None
    # what no model has shows in them alone: only gross mistakes are told
    assert judged({"receiver[2].tilt_deg": -14.0}, setup=setup) is None
    found = judged({"receiver[2].tilt_deg": -30.0}, setup=setup)
    assert found is not None
    assert "likely receiver[2] is wrong, adding tilt_deg -15 would agree" in found.finding.text


def test_a_place_that_leaves_much_of_what_bends_is_not_the_whole_cause() -> None:
    alone = judged({"receiver[2].tilt_deg": -20.0})
    assert alone is not None
    assert alone.finding.facts["explains"]
    beside = judged({"receiver[2].tilt_deg": -20.0}, besides=30.0)
    assert beside is not None
    assert not beside.finding.facts["explains"]
    left = re.search(r", leaves (\d+)% of it", beside.finding.text)
    assert left is not None
    assert int(left[1]) == pytest.approx(70, abs=15)


def test_a_value_that_was_tried_by_itself_is_named_where_it_explains_all() -> None:
    key, by, gain = "tracer.diameter_m", -0.005, 40.0
    alone = wrong_value(key, by, gain, 0.0, SETUP)
    assert alone is not None
    assert "likely tracer.diameter_m is wrong, adding diameter_m -5 mm" in alone.text
    # what is gained by chance, what leaves most of it, and what is within a few u
    assert wrong_value(key, by, 10.0, 0.0, SETUP) is None
    assert wrong_value(key, by, gain, 0.5, SETUP) is None
    assert wrong_value(key, -5e-5, gain, 0.0, SETUP) is None
