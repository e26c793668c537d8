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
from radargui.restitution.setup_chi_square import SetupChiSquare
from radargui.restitution.setup_outlier import SetupOutlier, _most_by_chance, misstated, setup_outlier

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
    exact = np.array([stated.get(key) == 0.0 for key in keys])
    return SetupChiSquare.of(fit, keys, responses, setup, exact)


def test_a_setup_that_is_right_within_its_u_names_nothing() -> None:
    rng = np.random.default_rng(2)
    for _ in range(20):
        assert judged(dict(zip(KEYS, rng.normal(size=len(KEYS)).tolist(), strict=True))) is None


def test_a_receiver_that_stands_elsewhere_is_named_with_what_has_to_be_added() -> None:
    found = judged({"receiver[2].tilt_deg": -20.0, "receiver[1].azimuth_deg": 1.0})
    assert found is not None
    assert "likely receiver[2] is wrong, adding tilt_deg -10 would agree (20 times" in found.sentence
    assert found.off["receiver[2].tilt_deg"] == pytest.approx(-20.0, abs=0.2)
    assert found.widening("receiver[2].tilt_deg") == pytest.approx(20.0, abs=0.2)
    assert found.widening("receiver[1].azimuth_deg") == found.widening("receiver[2].azimuth_deg") == 1.0


def test_a_release_that_is_elsewhere_is_one_place_with_three_coordinates() -> None:
    found = judged({"tracer.release_position_m[1]": 30.0, "tracer.release_position_m[3]": -40.0})
    assert found is not None
    assert "tracer.release_position_m is wrong, adding x +30 mm, z -40 mm would agree (40 times" in found.sentence


def test_a_g_that_no_place_explains_is_left_to_wavelength_and_clock() -> None:
    assert judged({}, g_m_s2=10.2) is None


def test_spheres_that_are_possible_are_no_places() -> None:
    found = judged({"sphere": 30.0}, keys=("sphere", "sphere", *KEYS))
    assert found is None
    assert judged({}, keys=("sphere", "sphere")) is None


def test_what_is_exceeded_by_chance_is_the_quantile_of_chi_square() -> None:
    exact = {1: 15.14, 3: 21.11, 12: 39.13}
    assert all(_most_by_chance(n) == pytest.approx(value, rel=0.08) for n, value in exact.items())


def test_the_flights_answer_as_one_matrix_what_they_answer_for_each_input() -> None:
    """`FlightFit.bends` is the diagonal of `against`, whose c vanishes where nothing parts flights and motion."""
    from radargui.restitution.flight_fit import FlightFit

    rng = np.random.default_rng(3)
    root: NDArray[np.float64] = rng.normal(size=(9, 9))
    form = root @ root.T
    jacobian = rng.normal(size=(9, 4))
    information: Any = SimpleNamespace(
        form=SimpleNamespace(solve=lambda right: np.linalg.solve(form, right)),
        eliminated=SimpleNamespace(marginal=lambda slope, _: slope),
        minimum=lambda: np.zeros(9),
    )
    away = np.linalg.solve(form, np.linalg.qr(jacobian, mode="complete")[0][:, 4:] @ rng.normal(size=5))
    fit = FlightFit(
        np.zeros(2), np.eye(2), (1.0, 5), np.zeros(1), 0.0, 1.0, information, np.zeros((2, 9)), jacobian,
        jacobian.T @ form @ jacobian, away,
    )  # fmt: skip
    slopes = rng.normal(size=(9, 3))
    responses: Any = [SimpleNamespace(slope_motion=one, slope_global=None) for one in slopes.T]
    cost, pull = fit.against(responses)
    np.testing.assert_allclose(fit.bends(responses), np.diag(cost))
    # what parts flights and motion after a change, by hand
    shift = np.linalg.solve(form, slopes) - jacobian @ np.linalg.solve(fit.normal, jacobian.T @ slopes)
    np.testing.assert_allclose(cost, shift.T @ form @ shift, atol=1e-9)
    np.testing.assert_allclose(pull, shift.T @ form @ away, atol=1e-9)


def test_what_is_beyond_a_linear_answer_is_told_without_a_number() -> None:
    found = judged({"receiver[3].distance_m": -1000.0})
    assert found is not None
    assert "receiver[3] is wrong, adding much to distance_m would agree (1000 times" in found.sentence


def test_a_release_outside_the_room_is_not_named() -> None:
    found = judged({"tracer.release_position_m[1]": 900.0})
    assert found is not None
    assert "tracer.release_position_m is wrong" in found.sentence
    found = judged({"tracer.release_position_m[1]": 2000.0, "tracer.release_position_m[2]": 40000.0})
    assert found is not None
    assert "likely receiver[2] (or receiver[3]," in found.sentence
    assert "tracer.release_position_m" not in found.sentence


def test_places_that_explain_it_as_well_are_named_beside_it_and_that_receivers_may_be_exchanged() -> None:
    off = {"receiver[1].azimuth_deg": 40.0, "receiver[2].azimuth_deg": -40.0}
    found = judged(off)
    assert found is not None
    assert "or receivers are exchanged)" in found.sentence


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
    assert "likely receiver[2] is wrong, adding tilt_deg -15 would agree" in found.sentence


def test_a_place_that_leaves_much_of_what_bends_is_not_the_whole_cause() -> None:
    alone = judged({"receiver[2].tilt_deg": -20.0})
    assert alone is not None
    assert alone.explains
    beside = judged({"receiver[2].tilt_deg": -20.0}, besides=30.0)
    assert beside is not None
    assert not beside.explains
    left = re.search(r", leaves (\d+)% of it", beside.sentence)
    assert left is not None
    assert int(left[1]) == pytest.approx(70, abs=15)


def with_weak_azimuth(strength: float, spurious: float, left: float = 40.0) -> SetupChiSquare:
    """Flights that inputs bend so strongly, and an azimuth hardly, along which something bends them besides."""
    rng = np.random.default_rng(4)
    bends = strength * rng.normal(size=(N_FLIGHTS, len(KEYS)))
    weak = KEYS.index("receiver[1].azimuth_deg")
    bends[:, weak] = rng.normal(size=N_FLIGHTS) * 0.7 / np.sqrt(N_FLIGHTS)
    away = -spurious * bends[:, weak] / np.linalg.norm(bends[:, weak])
    misfit = (float(away @ away) + N_FLIGHTS + left, N_FLIGHTS)
    fit: Any = SimpleNamespace(g_m_s2=9.80, u_g_m_s2=1e-3, misfit=misfit)
    fit.against = lambda _: (bends.T @ bends, bends.T @ away)
    fit.follow = lambda response: np.array([response])
    return SetupChiSquare.of(fit, KEYS, np.zeros(len(KEYS)).tolist(), SETUP, np.zeros(len(KEYS), bool))


def test_what_the_linear_answer_misses_of_strong_bends_names_no_azimuth() -> None:
    """Laboratory 6361045, 45 dB, all right: an azimuth 74 degrees off gained 36 where tilts bend by 130 deviations."""
    quiet, loud = with_weak_azimuth(0.1, 6.5), with_weak_azimuth(3.0, 6.5)
    assert quiet.blur == 1.0
    assert loud.blur > 10.0
    found = setup_outlier(quiet, KEYS, SETUP)
    assert found is not None
    assert "receiver[1], adding azimuth_deg" in found.sentence
    assert setup_outlier(loud, KEYS, SETUP) is None
    # a mistake bends by far more than that, or makes flights agree
    assert setup_outlier(with_weak_azimuth(3.0, 40.0), KEYS, SETUP) is not None
    assert setup_outlier(with_weak_azimuth(3.0, 6.5, left=0.0), KEYS, SETUP) is not None


def test_inputs_that_are_exact_leave_the_answer_linear() -> None:
    tables = SETUP.model_dump(by_alias=True, exclude_unset=True)
    exact = {f"u_{name}": 0.0 for name in ("tilt_deg", "azimuth_deg", "distance_m")}
    tables["receiver"] = tuple({**one, **exact} for one in tables["receiver"])
    known = Setup.model_validate(tables)
    assert chi_square({}, strength=3.0, setup=known).blur < chi_square({}, strength=3.0).blur


def test_one_number_that_is_misread_is_asked_less_of_than_a_whole_place() -> None:
    """A height of which the flights say little, x and y of which they say much: alone it may be far off (7302103)."""
    rng = np.random.default_rng(6)
    bends = rng.normal(size=(N_FLIGHTS, len(KEYS)))
    bends *= np.array([1.0 if "release" in key and not key.endswith("[3]") else 0.008 for key in KEYS])
    height = KEYS.index("tracer.release_position_m[3]")
    away = 20.0 * bends[:, height]
    fit: Any = SimpleNamespace(g_m_s2=9.80, u_g_m_s2=1e-3, misfit=(float(away @ away) + N_FLIGHTS, N_FLIGHTS))
    fit.against = lambda _: (bends.T @ bends, bends.T @ away)
    fit.follow = lambda response: np.array([response])
    form = SetupChiSquare.of(fit, KEYS, np.zeros(len(KEYS)).tolist(), SETUP, np.zeros(len(KEYS), bool))
    widened = misstated(form, KEYS, SETUP)
    assert widened[height] > 1.5
    assert widened[height - 1] < 1.05


def test_a_place_that_may_be_misstated_counts_as_far_off_as_that_is_likely() -> None:
    """Flights that show the release weakly: 12 mm beside the truth is too little to name it."""
    key = "tracer.release_position_m[1]"
    form = chi_square({key: 12.0}, strength=0.025)
    assert setup_outlier(form, KEYS, SETUP) is None
    widened = dict(zip(KEYS, misstated(form, KEYS, SETUP).tolist(), strict=True))
    assert widened[key] > 3.0
    assert all(by < 1.5 for other, by in widened.items() if not other.startswith("tracer.release"))
    # what is certain counts as that far off
    sure = misstated(chi_square({key: 40.0}), KEYS, SETUP)
    assert sure[KEYS.index(key)] == pytest.approx(40.0, rel=0.05)


def test_a_setup_that_is_right_within_its_u_is_not_widened() -> None:
    rng = np.random.default_rng(5)
    for strength in (0.01, 0.1, 1.0):
        for _ in range(10):
            true = dict(zip(KEYS, rng.normal(size=len(KEYS)).tolist(), strict=True))
            assert misstated(chi_square(true, strength=strength), KEYS, SETUP).max() < 1.6
