"""Draws of the laboratory: within what was asked for, the same world whatever is told of it, the record as made."""

from __future__ import annotations

import numpy as np
import pytest
from benchmarks.world import stated as values
from benchmarks.world.draw import WEAKEST, draw
from benchmarks.world.room import Room
from benchmarks.world.scene import Scene, make_record

from radargui.model.recording import channel_skew


@pytest.fixture(scope="module")
def scenes() -> list[Scene]:
    return [draw(seed) for seed in range(45)]


def test_no_receiver_is_nearly_blind(scenes: list[Scene]) -> None:
    centre = np.zeros((3, 1))
    for one in scenes[:5]:
        for number in range(3):
            sender, antenna = one.room.antennas[0], one.room.antennas[number + 1]
            outward = -antenna.axis
            turned = [
                Room((sender, type(antenna)(antenna.position_m, antenna.axis, field, antenna.lobe)), one.room.sphere)
                for angle in np.radians(np.arange(0.0, 180.0, 5.0))
                for field in [
                    np.cos(angle) * antenna.polarization + np.sin(angle) * np.cross(outward, antenna.polarization)
                ]
            ]
            strengths = [abs(room.received(0, centre)[0]) for room in turned]
            assert strengths[0] > WEAKEST * max(strengths)


def test_a_wall_sends_back_its_share_of_the_field_at_the_centre() -> None:
    scene = draw(1, walls=1, wall=0.04, floor=0.0, wall_distance_m=0.6)
    (wall,) = scene.room.mirrors
    for antenna, reflection in zip(scene.room.antennas, wall.reflection, strict=True):
        away = wall.height_m(antenna.position_m)
        centre = wall.height_m(np.zeros(3))
        foot = antenna.position_m - away * wall.normal
        spot = foot + away / (away + centre) * (-centre * wall.normal - foot)  # equal angles there
        towards = (spot - antenna.position_m) / np.linalg.norm(spot - antenna.position_m)
        share = abs(reflection) * antenna.strength(towards[:, None])[0]
        assert 0.8 * 0.04 <= share <= 1.2 * 0.04
        assert antenna.strength(antenna.axis[:, None])[0] == pytest.approx(1.0, abs=0.006)


def test_the_multiplexer_ends_a_scan_before_the_next(scenes: list[Scene]) -> None:
    for one in scenes:
        assert 6 * one.converter.skew_s * one.converter.rate_hz <= 1.0 + 1e-9


def test_a_value_held_changes_no_other() -> None:
    free, held = draw(3), draw(3, snr_db=50.0, walls=0, floor=0.0, crosstalk=0.0)
    assert held.snr_db == 50.0
    assert held.room.mirrors == ()
    assert held.setup == free.setup
    assert held.drop.impacts == free.drop.impacts
    assert held.mixers == free.mixers


def test_a_value_that_is_not_there_is_refused_by_name() -> None:
    with pytest.raises(ValueError, match="snr"):
        draw(0, snr=30.0)


def test_the_world_is_the_same_whatever_the_setup_states() -> None:
    exact, drawn = draw(4), draw(4, "drawn")
    np.testing.assert_array_equal(
        make_record(exact).recording.raw, make_record(drawn).recording.raw, err_msg="the record"
    )
    assert drawn.setup.receiver != exact.setup.receiver


def test_an_exact_setup_states_the_truth() -> None:
    scene = draw(5)
    stated = scene.setup.receiver[1]
    tilt, azimuth = np.radians([stated.tilt_deg, stated.azimuth_deg])
    place = stated.distance_m * np.array([np.sin(tilt) * np.cos(azimuth), np.sin(tilt) * np.sin(azimuth), np.cos(tilt)])
    np.testing.assert_allclose(place, scene.room.antennas[2].position_m, atol=1e-12)
    assert 2.0 * np.pi / scene.setup.radar.wavelength_m == pytest.approx(scene.room.sphere.wavenumber_rad_m)
    np.testing.assert_allclose(scene.setup.tracer.release_position_m, scene.drop.position(np.zeros(1))[:, 0])
    assert scene.setup.tracer.diameter_m == pytest.approx(2.0 * scene.room.sphere.radius_m)
    assert stated.u_tilt_deg == 0.0


def test_a_drawn_setup_is_off_by_the_uncertainty_that_it_states(scenes: list[Scene]) -> None:
    off = []
    for seed in range(25):
        exact, drawn = scenes[seed].setup, draw(seed, "drawn").setup
        for true, told in zip(exact.receiver, drawn.receiver, strict=True):
            assert told.u_tilt_deg == values.U_ANGLE_DEG
            off.append((told.tilt_deg - true.tilt_deg) / told.u_tilt_deg)
            off.append((told.azimuth_deg - true.azimuth_deg) / told.u_azimuth_deg)
            off.append((told.distance_m - true.distance_m) / told.u_distance_m)
        places = [np.array(one.tracer.release_position_m) for one in (exact, drawn)]
        off.extend((places[1] - places[0]) / drawn.tracer.u_release_m)
    # 300 standard normals: chi-square / 300 has a standard deviation of 0.082
    assert np.mean(np.square(off)) == pytest.approx(1.0, abs=0.33)


def test_skew_that_the_file_lacks_stands_in_the_setup() -> None:
    for in_file in (True, False):
        scene = draw(6, rate_hz=2000.0, skew_s=15e-6, skew_in_file=in_file)
        found = channel_skew(make_record(scene).recording.digitisation, scene.setup.daq)
        assert (found.delay_s, found.known_from) == (15e-6, "file" if in_file else "setup")


def test_a_record_of_a_perfect_chain_turns_by_the_path() -> None:
    """Almost no noise, no mirrors, a sphere that is a point: the phase of I and Q is that of the path."""
    scene = draw(
        7, snr_db=90.0, floor=0.0, walls=0, crosstalk=0.0, radius_m=1e-4, rate_hz=5000.0, skew_s=0.0,
        density_kg_m3=25e3, amplitude_v=1.5,
    )  # fmt: skip
    record = make_record(scene)
    volts = record.recording.volts()
    for number, mixer in enumerate(scene.mixers):
        i = volts[2 * number] / mixer.amplitude_v - mixer.offset[0]
        q = (volts[2 * number + 1] / mixer.amplitude_v - mixer.offset[1]) / mixer.gain_ratio
        q = (q - i * np.sin(mixer.quadrature_error_rad)) / np.cos(mixer.quadrature_error_rad)
        turned = scene.phase_sign * np.unwrap(np.angle(i + 1j * q))
        path = record.truth.path_m[number]
        expected = scene.room.sphere.wavenumber_rad_m * (path - path[0])
        np.testing.assert_allclose(turned - turned[0], expected, atol=2e-3)
