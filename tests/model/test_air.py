"""The air of the setup: refractive index, density and viscosity against tables, and how uncertain they are."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from hypothesis import given, strategies as st
from support.changed import changed

from radargui.model.assumed import assumed_uncertainties, uncertain_inputs
from radargui.model.errors import SetupError
from radargui.model.gravity import USUAL_AIR, Air, drag_of_sphere, expected_gravity, share_in_air
from radargui.model.radar import SPEED_OF_LIGHT_M_S, Site
from radargui.model.setup import Setup, dump_setup, moved, parse_setup, value_of

GOOD = """\
schema = 1
[radar]
frequency_hz = 10.0e9
[transmitter]
distance_m = 0.70
[[receiver]]
tilt_deg = 40.0
azimuth_deg = 211.0
distance_m = 0.70
"""
ROOM = "[air]\ntemperature_c = 20.0\npressure_hpa = 1013.25\nhumidity_percent = 50.0\n"


def in_air(setup: Setup, **keys: float) -> Setup:
    room = {"temperature_c": 20.0, "pressure_hpa": 1013.25, "humidity_percent": 50.0}
    return changed(setup, radar={"refractive_index": None}, air=room | keys)


@pytest.mark.parametrize(
    ("temperature_c", "humidity_percent", "ppm"),
    [
        # Smith & Weintraub, Proc. IRE 41, 1035 (1953): N = 77.6 / T (p + 4810 e / T), good to 0.5 % of N
        (0.0, 0.0, 77.6 * 1013.25 / 273.15),
        (20.0, 50.0, 77.6 / 293.15 * (1013.25 + 4810.0 * 11.69 / 293.15)),
        (30.0, 100.0, 77.6 / 303.15 * (1013.25 + 4810.0 * 42.43 / 303.15)),
    ],
)
def test_the_refractive_index_is_that_of_the_older_formula_within_what_that_claims(
    temperature_c: float, humidity_percent: float, ppm: float
) -> None:
    air = Air(temperature_c=temperature_c, pressure_hpa=1013.25, humidity_percent=humidity_percent)
    assert 1e6 * (air.refractive_index - 1.0) == pytest.approx(ppm, rel=5e-3)


def test_density_and_viscosity_are_those_of_tables() -> None:
    # CIPM-2007 (Picard et al., Metrologia 45, 149, 2008) at 20 degrees C, 1013.25 hPa, half humid: 1.1992
    room = Air(temperature_c=20.0, pressure_hpa=1013.25, humidity_percent=50.0).gas
    assert room.density_kg_m3 == pytest.approx(1.1992, rel=1e-3)
    # U.S. Standard Atmosphere 1976 at the level of the sea, 15 degrees C
    dry = Air(temperature_c=15.0, pressure_hpa=1013.25, humidity_percent=0.0).gas
    assert (dry.density_kg_m3, dry.viscosity_m2_s) == pytest.approx((1.2250, 1.4607e-5), rel=1e-3)
    assert Air().gas == USUAL_AIR


@given(
    st.floats(-20.0, 40.0),
    st.floats(600.0, 1080.0),
    st.floats(5.0, 95.0),
    st.tuples(st.floats(0.0, 2.0), st.floats(0.0, 10.0), st.floats(0.0, 5.0)),
)
def test_the_uncertainty_is_the_scatter_of_what_is_known_no_better(
    temperature_c: float, pressure_hpa: float, humidity_percent: float, u: tuple[float, float, float]
) -> None:
    def index(*by: float) -> float:
        t, p, h = np.add((temperature_c, pressure_hpa, humidity_percent), by)
        return Air(temperature_c=float(t), pressure_hpa=float(p), humidity_percent=float(h)).refractive_index

    at = {"temperature_c": temperature_c, "pressure_hpa": pressure_hpa, "humidity_percent": humidity_percent}
    names = ("u_temperature_c", "u_pressure_hpa", "u_humidity_percent")
    air = Air(**at, **dict(zip(names, u, strict=True)))
    # each value one u above or below what is told, all eight ways
    corners = [index(*(np.array(signs) * u).tolist()) for signs in product((-1.0, 1.0), repeat=3)]
    assert air.u_refractive_index == pytest.approx(float(np.std(corners)), rel=0.02, abs=1e-9)


def test_the_wave_is_as_long_as_in_the_air_told_also_read_again_from_its_file() -> None:
    setup = parse_setup(GOOD + ROOM)
    index = setup.air.refractive_index
    assert setup.radar.wavelength_m == pytest.approx(SPEED_OF_LIGHT_M_S / 10e9 / index, rel=1e-15)
    assert "refractive_index" not in dump_setup(setup)
    again = parse_setup(dump_setup(setup))
    assert again == setup
    assert again.radar.wavelength_m == setup.radar.wavelength_m
    # in other air it is another wave
    assert in_air(setup, humidity_percent=100.0).radar.wavelength_m < setup.radar.wavelength_m


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (
            GOOD + "[air]\ntemperature_c = 20.0\n",
            "air.pressure_hpa is missing, allowed: temperature_c, pressure_hpa and",
        ),
        (GOOD + "[air]\nu_pressure_hpa = 1.0\n", "air.temperature_c is missing"),
        (GOOD + ROOM.replace("1013.25", "101325.0"), "air.pressure_hpa = 101325.0, allowed: a number from 300 to 1100"),
        (
            GOOD.replace("10.0e9\n", "10.0e9\nrefractive_index = 1.0003\n") + ROOM,
            "radar.refractive_index = 1.0003, allowed: left out beside [air]",
        ),
    ],
)
def test_what_is_missing_or_said_twice_is_refused_by_name(text: str, told: str) -> None:
    with pytest.raises(SetupError) as caught:
        parse_setup(text)
    assert told in str(caught.value)


def test_the_index_is_uncertain_by_what_the_air_is_and_says_what_was_assumed() -> None:
    setup = in_air(parse_setup(GOOD), u_pressure_hpa=0.5)
    (wave,) = [one for one in uncertain_inputs(setup) if one.key == "radar.refractive_index"]
    # half of it and more is the humidity's
    assert wave.u == setup.air.u_refractive_index
    assert 4e-6 < wave.u < 6e-6
    said = assumed_uncertainties(setup)
    assert {key: u for key, u in said.items() if key.startswith(("air", "radar.ref"))} == {
        "air.u_temperature_c": 0.5,
        "air.u_humidity_percent": 5.0,
    }
    there = moved(setup, wave.key, wave.u)
    assert value_of(there, wave.key) == pytest.approx(setup.air.refractive_index + wave.u, rel=1e-12)
    assert there.radar.wavelength_m < setup.radar.wavelength_m


def test_thin_air_brakes_and_buoys_a_sphere_less() -> None:
    usual, high = drag_of_sphere(0.01, 1050.0), Air(temperature_c=20.0, pressure_hpa=602.0, humidity_percent=0.0).gas
    thin = drag_of_sphere(0.01, 1050.0, high)
    assert thin.k_1_m == pytest.approx(usual.k_1_m * 602.0 / 1013.25, rel=5e-3)
    assert 1.0 - share_in_air(1050.0, high) == pytest.approx((1.0 - share_in_air(1050.0)) * 602.0 / 1013.25, rel=5e-3)


def test_a_sphere_of_unknown_density_falls_with_the_buoyancy_of_metal_within_what_metals_differ_by() -> None:
    site = Site(g_m_s2=9.81, u_g_m_s2=1e-5)
    expected, u = expected_gravity(site, None)
    for density_kg_m3 in (2700.0, 7800.0, 19000.0):
        stated, u_stated = expected_gravity(site, density_kg_m3)
        assert abs(expected - stated) < u, density_kg_m3
        # who states it is believed
        assert u_stated < 2e-5
    # drag apart nothing of metal falls faster than in vacuum
    assert expected < 9.81
