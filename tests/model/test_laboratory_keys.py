"""Air, polarisation, site and uncertainties in the setup: what they mean, what is refused, what is assumed."""

from __future__ import annotations

import numpy as np
import pytest
from support.changed import changed

from radargui.model.assumed import assumed_uncertainties, release_parts_m, u_release_m, uncertain_inputs
from radargui.model.errors import SetupError
from radargui.model.gravity import normal_gravity_m_s2, share_in_air
from radargui.model.radar import SPEED_OF_LIGHT_M_S
from radargui.model.scattering import received_direction
from radargui.model.setup import Setup, dump_setup, moved, parse_setup, value_of
from radargui.physics.path_length import place_antennas

GOOD = """\
schema = 1
[radar]
frequency_hz = 10.0e9
[transmitter]
distance_m = 0.70
polarization_deg = 0.0
[[receiver]]
tilt_deg = 40.0
azimuth_deg = 211.0
distance_m = 0.70
"""


def line_of(text: str) -> str:
    with pytest.raises(SetupError) as caught:
        parse_setup(text)
    return str(caught.value)


def test_the_wavelength_is_that_in_the_air_told_and_in_vacuum_where_none_is() -> None:
    setup = parse_setup(GOOD)
    assert setup.radar.wavelength_m == SPEED_OF_LIGHT_M_S / 10.0e9
    in_air = changed(setup, radar={"refractive_index": 1.00032})
    assert in_air.radar.wavelength_m == pytest.approx(SPEED_OF_LIGHT_M_S / 10.0e9 / 1.00032, rel=1e-15)


def test_a_receiver_without_an_angle_is_turned_for_the_strongest_signal() -> None:
    (field,) = parse_setup(GOOD).received_fields()
    # 10 mm sphere, transmitter along x: the published worked example
    found = received_direction(field.angle_deg, field.horizontal, field.vertical)
    assert found == pytest.approx([0.83232, -0.15138, 0.53322], abs=1e-5)
    assert field.share == 1.0


def test_a_receiver_turned_across_the_field_is_refused_with_the_angle_that_is_not() -> None:
    # a small sphere's field is nearly linear: across it there is nothing
    small = GOOD.replace("[[rec", "[tracer]\ndiameter_m = 0.001\n[[rec")
    (field,) = parse_setup(small).received_fields()
    across = f"{small}polarization_deg = {field.strongest_deg + 90.0}\n"
    assert f"{field.strongest_deg:.1f} gives the strongest" in line_of(across)
    assert "receiver[1].polarization_deg" in line_of(across)
    assert "5 % and more" in line_of(across)
    beside = f"{small}polarization_deg = {field.strongest_deg + 85.0}\n"
    assert parse_setup(beside).received_fields()[0].share == pytest.approx(np.sin(np.radians(5.0)), rel=1e-3)


@pytest.mark.parametrize("by", [180.0, -180.0, -360.0])
def test_half_a_turn_of_an_antenna_is_none(by: float) -> None:
    own = parse_setup(f"{GOOD}polarization_deg = 20.0\n").received_fields()[0]
    turned = parse_setup(f"{GOOD}polarization_deg = {20.0 + by}\n").received_fields()[0]
    assert turned.share == pytest.approx(own.share, rel=1e-12)


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("polarization_deg = 0.0\n", "", "receiver[1].polarization_deg = 20, allowed: together with transmitter.pol"),
        ("= 0.0\n", "= 361.0\n", "transmitter.polarization_deg = 361.0, allowed: a number from -360 to 360"),
        (
            "distance_m = 0.70\npolarization_deg = 0",
            "polarization_deg = 0",
            "transmitter.distance_m is missing, allowed: a number above 0 to 100, or position_m instead",
        ),
        (
            "distance_m = 0.70\npolarization_deg = 0",
            "distance_m = 0.7\nposition_m = [0.0, 0.0, 0.7]\npolarization_deg = 0",
            "transmitter.distance_m = 0.7 beside position_m, allowed: a number above",
        ),
        (
            "distance_m = 0.70\npolarization_deg = 0",
            "position_m = [0.0, 0.0, 0.0]\npolarization_deg = 0",
            "transmitter.position_m = [0, 0, 0], allowed: any place but the centre",
        ),
        ("10.0e9\n", "10.0e9\nrefractive_index = 0.99\n", "refractive_index = 0.99, allowed: a number from 1 to 1.01"),
        (
            "[tr",
            "[site]\nlatitude_deg = 50.0\n[tr",
            "site.latitude_deg = 50, allowed: g_m_s2 (and u_g_m_s2), or latitude_deg and height_m",
        ),
        (
            "[tr",
            "[site]\ng_m_s2 = 9.8\nheight_m = 1.0\n[tr",
            "site.g_m_s2 = 9.8 with height_m = 1, allowed: g_m_s2 (and",
        ),
        ("[tr", "[site]\nu_g_m_s2 = 0.1\n[tr", "site.u_g_m_s2 = 0.1, allowed: g_m_s2 (and u_g_m_s2), or latitude_deg"),
        ("[tr", "[tracer]\ndensity_kg_m3 = 0.0\n[tr", "tracer.density_kg_m3 = 0.0, allowed: a number from 10 to 25000"),
        ("[tr", "[floor]\nu_tilt_deg = 90.0\n[tr", "floor.u_tilt_deg = 90.0, allowed: a number from 0 to 45"),
        ("[tr", "[daq]\nu_clock_ppm = -1.0\n[tr", "daq.u_clock_ppm = -1.0, allowed: a number from 0 to 10000"),
    ],
)
def test_what_makes_no_sense_is_refused_by_name(old: str, new: str, told: str) -> None:
    text = f"{GOOD}polarization_deg = 20.0\n"
    assert text.count(old) == 1
    assert told in line_of(text.replace(old, new))


def test_a_transmitter_stands_where_its_position_says() -> None:
    text = GOOD.replace("distance_m = 0.70\npol", "position_m = [0.01, -0.02, 0.69]\npol")
    setup = parse_setup(text)
    assert place_antennas(setup).transmitter_m == pytest.approx([0.01, -0.02, 0.69])
    assert parse_setup(dump_setup(setup)) == setup
    farther = moved(setup, "transmitter.distance_m", 0.003)
    assert np.linalg.norm(farther.transmitter.place_m) == pytest.approx(
        np.linalg.norm(setup.transmitter.place_m) + 3e-3
    )


def test_what_the_setup_gives_is_taken_and_the_rest_assumed_of_every_input() -> None:
    setup = parse_setup(f"{GOOD}u_tilt_deg = 0.2\n")
    setup = changed(setup, tracer={"u_diameter_m": 0.0}, daq={"u_clock_ppm": 10.0})
    assert assumed_uncertainties(setup) == {
        "radar.u_frequency_hz": 10.0e9 * 1e-6,
        "radar.refractive_index": 3.2e-4,
        "transmitter.u_distance_m": 3e-3,
        "transmitter.u_x_m": 3e-3,
        "transmitter.u_y_m": 3e-3,
        "transmitter.u_polarization_deg": 5.0,
        "receiver[1].u_azimuth_deg": 0.5,
        "receiver[1].u_distance_m": 3e-3,
        "receiver[1].u_polarization_deg": 5.0,
        "tracer.u_release_m": 1e-3,
        "floor.u_tilt_deg": 0.3,
    }
    given = {one.key: one.u for one in uncertain_inputs(setup) if not one.assumed}
    assert given == {"receiver[1].tilt_deg": 0.2, "tracer.diameter_m": 0.0, "daq.clock_ppm": 10.0}


def test_a_release_has_a_part_that_drops_share_and_a_scatter_that_is_in_it_unless_it_is_stated() -> None:
    def parts(**keys: float) -> tuple[float, float, float]:
        tracer = changed(parse_setup(GOOD), tracer=keys).tracer
        return (*release_parts_m(tracer), u_release_m(tracer))

    assert parts() == pytest.approx((np.sqrt(1e-6 - 4e-8), 2e-4, 1e-3))
    assert parts(u_release_m=1e-4) == (0.0, 1e-4, 1e-4)
    # what is called exact stays exact
    assert parts(u_release_m=0.0) == (0.0, 0.0, 0.0)
    assert parts(u_release_m=3e-4, u_release_scatter_m=4e-4) == pytest.approx((3e-4, 4e-4, 5e-4))


def test_every_value_with_an_uncertainty_can_be_moved_by_it() -> None:
    setup = parse_setup(GOOD)
    for one in uncertain_inputs(setup):
        if one.key in ("floor.tilt_deg", "daq.clock_ppm"):
            continue
        there = moved(setup, one.key, one.u)
        assert there != setup, one.key
        assert moved(there, one.key, -one.u).radar.wavelength_m == pytest.approx(setup.radar.wavelength_m)


def test_a_value_that_is_moved_stands_where_it_was_moved_to() -> None:
    setup = parse_setup(GOOD)
    for one in uncertain_inputs(setup):
        if one.key not in ("floor.tilt_deg", "daq.clock_ppm"):
            there = value_of(moved(setup, one.key, 2.0 * one.u), one.key)
            assert there == pytest.approx(value_of(setup, one.key) + 2.0 * one.u), one.key


def test_without_polarisation_no_angle_of_it_is_uncertain() -> None:
    setup: Setup = parse_setup(GOOD.replace("polarization_deg = 0.0\n", ""))
    assert not [one.key for one in uncertain_inputs(setup) if "polarization" in one.key]


def test_normal_gravity_is_the_ellipsoids() -> None:
    # NIMA TR8350.2, table 3.4: normal gravity at equator and pole; 45 degrees from the international tables
    assert normal_gravity_m_s2(0.0, 0.0) == pytest.approx(9.7803253359, abs=1e-10)
    assert normal_gravity_m_s2(90.0, 0.0) == pytest.approx(9.8321849378, abs=1e-9)
    assert normal_gravity_m_s2(45.0, 0.0) == pytest.approx(9.806197769, abs=1e-8)
    # free-air gradient, -0.3086 mGal/m at 45 degrees
    assert normal_gravity_m_s2(45.0, 100.0) - normal_gravity_m_s2(45.0, 0.0) == pytest.approx(-3.085e-4, rel=1e-3)


def test_steel_loses_one_and_a_half_times_the_ratio_of_densities_and_water_in_water_floats() -> None:
    assert 1.0 - share_in_air(7800.0) == pytest.approx(1.5 * 1.2 / 7800.0, rel=1e-3)
    assert share_in_air(1.2) == 0.0
    # of a sphere whose density is not given nothing is taken off
    assert share_in_air(None) == 1.0


HORN = GOOD.replace("distance_m = 0.70", "distance_m = 0.58\nphase_centre_m = 0.12")


def test_waves_come_from_as_far_behind_the_aperture_as_is_stated() -> None:
    near, far = place_antennas(parse_setup(HORN)), place_antennas(parse_setup(GOOD))
    assert near.transmitter_m == pytest.approx(far.transmitter_m, abs=1e-15)
    assert near.receivers_m == pytest.approx(far.receivers_m, abs=1e-15)
    u = {one.key: one.u for one in uncertain_inputs(parse_setup(f"{HORN}u_phase_centre_m = 0.004\n"))}
    # a horn's is assumed to 2 cm, and a tape has its 3 mm besides
    assert u["transmitter.distance_m"] == pytest.approx(np.hypot(3e-3, 0.02))
    assert u["receiver[1].distance_m"] == pytest.approx(5e-3)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (f"{GOOD}u_phase_centre_m = 0.01\n", "u_phase_centre_m = 0.01, allowed: together with phase_centre_m"),
        (f"{GOOD}phase_centre_m = 0.6\n", "phase_centre_m = 0.6"),
        (HORN.replace("distance_m = 0.58", "position_m = [0.1, 0, 0.6]", 1), "beside position_m"),
        (f'{GOOD}[tracer]\nmaterial = "PE"\nrefractive_index = 1.5\n', "beside refractive_index = 1.5"),
        (f"{GOOD}[tracer]\nu_refractive_index = 0.1\n", "of a sphere that is not of metal"),
    ],
)
def test_what_says_a_thing_twice_or_belongs_to_nothing_is_refused_by_its_name(text: str, said: str) -> None:
    assert said in line_of(text)


def test_a_plastic_sphere_has_an_index_that_can_be_wrong() -> None:
    named, told = (parse_setup(f"{GOOD}[tracer]\n{line}\n") for line in ('material = "PE"', "refractive_index = 1.52"))
    assert named.tracer.index == told.tracer.index == 1.52
    assert parse_setup(GOOD).tracer.index is None
    (one,) = (one for one in uncertain_inputs(named) if one.key == "tracer.refractive_index")
    assert one.assumed
    assert one.moved(named).tracer.index == pytest.approx(1.52 + one.u)


@pytest.mark.parametrize(
    ("table", "line"),
    [
        ("reflection = 1.2", "floor.reflection = 1.2, allowed: a number above 0 to 1"),
        ("u_reflection = 0.1", "floor.u_reflection = 0.1, allowed: together with reflection or material"),
        ('material = "wood"', 'floor.material = "wood", allowed: steel, glass, acrylic, granite'),
        ('material = "glass"', 'floor.thickness_m left out, allowed: above 0 to 1 beside material = "glass"'),
        (
            'reflection = 0.5\nmaterial = "steel"',
            'floor.material = "steel" beside reflection = 0.5, allowed: one of them',
        ),
        ("thickness_m = 0.01", "floor.thickness_m = 0.01, allowed: together with material or refractive_index"),
        (
            'refractive_index = 2.5\nthickness_m = 0.01\nbacking = "wood"',
            'floor.backing = "wood", allowed: air, metal, or',
        ),
        ("refractive_index = 2.5\nthickness_m = 0.01\nbacking = 0.5", "floor.backing = 0.5, allowed: air, metal, or"),
        ("middle_m = [0.0, 0.0]", "floor.size_m left out, allowed: both sides of the plate beside middle_m"),
        ("size_m = [0.1, -0.1]", "floor.size_m[2] = -0.1, allowed: a number above 0"),
    ],
)
def test_what_a_floor_reflects_is_said_in_one_way_and_whole(table: str, line: str) -> None:
    assert line in line_of(f"{GOOD}[floor]\n{table}\n")


def test_what_a_floor_lies_on_is_a_name_or_an_index_and_its_uncertainty_is_assumed() -> None:
    setup = parse_setup(f"{GOOD}[floor]\nmaterial = 'glass'\nthickness_m = 0.01\nbacking = 1.5\n")
    assert setup.floor.backing == 1.5
    assert parse_setup(dump_setup(setup)) == setup
    assert assumed_uncertainties(setup)["floor.u_reflection"] == 0.05
    assert "floor.u_reflection" not in assumed_uncertainties(parse_setup(GOOD))
    told = f"{GOOD}[floor]\nreflection = 0.9\nu_reflection = 0.02\n"
    assert "floor.u_reflection" not in assumed_uncertainties(parse_setup(told))


def test_where_a_plate_ends_is_stated_with_uncertainties_that_are_assumed() -> None:
    setup = parse_setup(f"{GOOD}[floor]\nsize_m = [0.1, 0.08]\nazimuth_deg = 20.0\nu_size_m = 0.002\n")
    assert parse_setup(dump_setup(setup)) == setup
    assumed = assumed_uncertainties(setup)
    assert assumed["floor.u_azimuth_deg"] == 3.0
    assert assumed["floor.u_middle_m"] == 0.005
    assert "floor.u_size_m" not in assumed
    assert "floor.u_middle_m" not in assumed_uncertainties(parse_setup(GOOD))
