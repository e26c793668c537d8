"""Waves from transmitter to sphere to receiver, directly and by way of the bottom."""

from __future__ import annotations

import numpy as np
import pytest
from support.simulated_recording import simulate_recording
from support.simulated_setup import perfect_setup

from radargui.model.errors import SetupError
from radargui.model.setup import Setup
from radargui.physics.path_length import Antennas, place_antennas
from radargui.sources.simulated.model import SimulatedRadar
from radargui.sources.simulated.waves import SIDE_LOBE, Lobe, make_waves, reflectors_of

WAVELENGTH_M = 299_792_458.0 / 10e9


def _received(setup: Setup, place: np.ndarray) -> np.ndarray:
    waves = make_waves(setup, place_antennas(setup))
    field = waves.at_tracer(place)
    return np.array([waves.received(receiver, place, field) for receiver in range(setup.n_receivers)])


def _places(count: int = 200) -> np.ndarray:
    return np.random.default_rng(5).uniform(-0.12, 0.12, (3, count))


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("scene", ["drop", "circle", "pendulum", "bed"])
def test_without_mismatch_and_noise_the_arctangent_is_the_true_phase(sign: int, scene: str) -> None:
    setup = perfect_setup(scene=scene, radar={"phase_sign": sign}, lateral_speed_m_s=0.05)
    recording, truth = simulate_recording(setup)
    volts = recording.volts()
    measured = np.unwrap(np.arctan2(volts[1::2], volts[::2]))
    expected = sign * 2 * np.pi * truth.path_m / WAVELENGTH_M
    turns = (measured - expected) / (2 * np.pi)
    np.testing.assert_allclose(turns, np.round(turns[:, :1]).repeat(turns.shape[1], axis=1), atol=1e-11)


def test_moving_away_raises_every_path_and_the_path_is_the_distance_both_ways() -> None:
    setup = perfect_setup()
    truth = SimulatedRadar(setup).truth(0, 9000)
    antennas = place_antennas(setup)
    for number, place in enumerate(antennas.receivers_m):
        there = np.linalg.norm(truth.position_m.T - antennas.transmitter_m, axis=1)
        back = np.linalg.norm(truth.position_m.T - place, axis=1)
        np.testing.assert_allclose(truth.path_m[number], there + back, atol=1e-14)
    falling = slice(6100, 8200)
    assert (np.diff(truth.path_m[:, falling]) > 0).all()


def test_the_amplitude_is_amplitude_v_at_the_release_for_every_receiver() -> None:
    setup = perfect_setup(release=(0.03, -0.02, 0.1), amplitude_v=0.7)
    recording, _ = simulate_recording(setup)
    volts = recording.volts()[:, 0]
    np.testing.assert_allclose(np.hypot(volts[::2], volts[1::2]), 0.7, rtol=1e-13)


def test_with_a_wide_beam_the_amplitude_falls_with_one_over_both_distances() -> None:
    setup = perfect_setup(beamwidth_deg=180.0)
    places = np.array([[0.0, 0.0, 0.12], [0.001, 0.0, 0.121]]).T
    antennas = place_antennas(setup)
    lobe = Lobe.of_beamwidth(180.0)
    received = np.abs(_received(setup, places))
    for number, receiver in enumerate(antennas.receivers_m):
        expected = 1.0
        for antenna in (antennas.transmitter_m, receiver):
            away = places - antenna[:, None]
            distance = np.linalg.norm(away, axis=0)
            gain = lobe.gain(-(antenna @ away) / (np.linalg.norm(antenna) * distance))
            expected = expected * gain / distance
        assert received[number, 1] == pytest.approx(expected[1] / expected[0], rel=1e-12)


@pytest.mark.parametrize("width", [5.0, 15.0, 60.0])
def test_the_lobe_has_half_power_at_half_its_width_and_never_falls_below_the_side_lobes(width: float) -> None:
    lobe = Lobe.of_beamwidth(width)
    angles = np.radians([0.0, width / 2, 90.0, 180.0])
    gain = lobe.gain(np.cos(angles))
    assert gain[0] == pytest.approx(1.0)
    assert gain[1] ** 2 == pytest.approx(0.5)
    assert (gain >= SIDE_LOBE).all()
    assert (np.diff(gain) <= 0).all()


def test_along_the_fall_on_the_axis_the_amplitude_stays_within_half_and_twice_the_amplitude_at_the_release() -> None:
    heights = np.linspace(-0.14, 0.12, 50)
    received = np.abs(_received(perfect_setup(), np.array([0 * heights, 0 * heights, heights])))
    assert received.min() > 0.5
    assert received.max() < 2.0


def _mirror_by_hand(point: np.ndarray, normal: np.ndarray, on_plane: np.ndarray) -> np.ndarray:
    foot = point - (normal @ (point - on_plane)) * normal
    return 2 * foot - point


@pytest.mark.parametrize("tilt", [0.0, 0.15])
def test_reflections_equal_the_sum_over_mirrored_transmitter_receiver_and_both(tilt: float) -> None:
    normal = np.array([np.sin(tilt), 0.0, np.cos(tilt)])
    floor = {"height_m": -0.14, "normal": normal.tolist()}
    setup = perfect_setup(floor=floor, reflection=0.2, beamwidth_deg=30.0)
    rho = reflectors_of(setup)[0].coefficient
    assert abs(rho) == pytest.approx(0.2)
    on_plane = np.array([0.0, 0.0, -0.14]) - 0.005 * normal
    antennas = place_antennas(setup)
    lobe = Lobe.of_beamwidth(30.0)
    places = _places()
    origin_image = _mirror_by_hand(np.zeros(3), normal, on_plane)

    def leg(antenna: np.ndarray, *, image: bool) -> np.ndarray:
        here = _mirror_by_hand(antenna, normal, on_plane) if image else antenna
        axis = (origin_image if image else np.zeros(3)) - here
        away = places - here[:, None]
        distance = np.linalg.norm(away, axis=0)
        gain = lobe.gain(axis @ away / (np.linalg.norm(axis) * distance))
        return gain / distance * np.exp(2j * np.pi * distance / WAVELENGTH_M)

    measured = _received(setup, places)
    clean = _received(
        setup.model_copy(update={"simulation": setup.simulation.model_copy(update={"reflection": 0.0})}), places
    )
    for number, receiver in enumerate(antennas.receivers_m):
        t, t_image = leg(antennas.transmitter_m, image=False), leg(antennas.transmitter_m, image=True)
        r, r_image = leg(receiver, image=False), leg(receiver, image=True)
        direct = t * r
        four_paths = direct + rho * t_image * r + rho * t * r_image + rho**2 * t_image * r_image
        np.testing.assert_allclose(measured[number] / clean[number], four_paths / direct, rtol=1e-10)


def test_the_bottom_lies_one_radius_below_the_centre_at_the_impact_and_below_a_bed_by_its_depth() -> None:
    assert reflectors_of(perfect_setup(reflection=0.1))[0].distance_m == pytest.approx(-0.145)
    bed = perfect_setup(reflection=0.1, scene="bed", bed_depth_m=0.02)
    assert reflectors_of(bed)[0].distance_m == pytest.approx(-0.165)
    assert reflectors_of(perfect_setup()) == ()


def test_an_antenna_below_the_reflecting_bottom_is_refused() -> None:
    setup = perfect_setup(reflection=0.1)
    antennas = place_antennas(setup)
    sunk = Antennas(antennas.transmitter_m, antennas.receivers_m * [1.0, 1.0, -1.0])
    with pytest.raises(SetupError, match="below the bottom"):
        make_waves(setup, sunk)


def test_a_swing_through_the_reflecting_bottom_is_refused_and_without_reflection_allowed() -> None:
    deep = {"scene": "pendulum", "pendulum_length_m": 1.0, "pendulum_amplitude_deg": 60.0, "floor": {"height_m": 0.0}}
    with pytest.raises(SetupError, match="through the bottom"):
        SimulatedRadar(perfect_setup(**deep, reflection=0.1))
    SimulatedRadar(perfect_setup(**deep))


def test_a_sphere_that_would_hit_an_antenna_is_refused() -> None:
    with pytest.raises(SetupError, match="hit the transmitter"):
        SimulatedRadar(perfect_setup(release=(0.0, 0.0, 0.69)))
