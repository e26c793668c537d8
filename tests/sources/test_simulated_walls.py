"""Walls of the simulated scene reflect by image theory, sized as the correction writes it."""

from __future__ import annotations

import numpy as np
import pytest
from support.simulated_recording import simulate_recording
from support.simulated_setup import perfect_setup

from radargui.model.errors import SetupError
from radargui.model.setup import Setup, dump_setup, parse_setup
from radargui.physics.path_length import place_antennas
from radargui.sources.simulated.model import SimulatedRadar
from radargui.sources.simulated.waves import Lobe, make_waves, reflectors_of

WAVELENGTH_M = 299_792_458.0 / 10e9
RELEASE = np.array([0.0, 0.0, 0.12])
ONE = {"wall_reflection": 0.05, "wall_distance_m": (0.3,), "wall_azimuth_deg": (30.0,)}
TWO = {"wall_reflection": 0.05, "wall_distance_m": (0.3, 0.25), "wall_azimuth_deg": (30.0, 270.0)}


def _places(count: int = 400) -> np.ndarray:
    return np.random.default_rng(5).uniform(-0.12, 0.12, (3, count))


def _received(setup: Setup, places: np.ndarray) -> np.ndarray:
    waves = make_waves(setup, place_antennas(setup))
    field = waves.at_tracer(places)
    return np.array([waves.received(receiver, places, field) for receiver in range(setup.n_receivers)])


def _relative(antenna: np.ndarray, places: np.ndarray, distance_m: float, azimuth_deg: float) -> np.ndarray:
    """Mirrored over direct path by hand: range, phase, and lobes as they change from the release on."""
    normal = -np.array([np.cos(np.radians(azimuth_deg)), np.sin(np.radians(azimuth_deg)), 0.0])
    image, target = (point - 2.0 * (normal @ point + distance_m) * normal for point in (antenna, np.zeros(3)))
    lobe = Lobe.of_beamwidth(15.0)

    def leg(origin: np.ndarray, aim: np.ndarray, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        away, axis = places - origin[:, None], aim - origin
        distance = np.linalg.norm(away, axis=0)
        return distance, lobe.gain(axis @ away / distance / np.linalg.norm(axis))

    (direct, gain), (mirrored, gain_mirrored) = leg(antenna, np.zeros(3), places), leg(image, target, places)
    start, start_mirrored = (leg(*ends, RELEASE[:, None])[1] for ends in ((antenna, np.zeros(3)), (image, target)))
    lobes = (gain_mirrored / gain) / (start_mirrored / start)
    return lobes * direct / mirrored * np.exp(2j * np.pi / WAVELENGTH_M * (mirrored - direct))


@pytest.mark.parametrize("walls", [ONE, TWO], ids=["one", "two"])
def test_the_signal_is_the_direct_path_times_one_plus_each_image_of_size_wall_reflection(
    walls: dict[str, object],
) -> None:
    setup, places = perfect_setup(**walls), _places()
    antennas = place_antennas(setup)
    ratio = _received(setup, places) / _received(perfect_setup(), places)
    planes = list(zip(walls["wall_distance_m"], walls["wall_azimuth_deg"], strict=True))  # type: ignore[call-overload]
    outward = [_relative(antennas.transmitter_m, places, *plane) for plane in planes]
    of_transmitter, of_receivers = [], []
    for number, antenna in enumerate(antennas.receivers_m):
        inward = [_relative(antenna, places, *plane) for plane in planes]
        paths = np.array(
            [np.ones(places.shape[1]), *outward, *inward, *(out * back for out in outward for back in inward)]
        )
        found, *_ = np.linalg.lstsq(paths.T, ratio[number], rcond=None)
        np.testing.assert_allclose(found @ paths, ratio[number], atol=1e-11)
        count = len(planes)
        direct, transmitter, receiver = found[0], found[1 : 1 + count], found[1 + count : 1 + 2 * count]
        np.testing.assert_allclose(np.abs([*transmitter, *receiver] / direct), 0.05, rtol=1e-8)
        np.testing.assert_allclose(found[1 + 2 * count :] / direct, np.outer(transmitter, receiver).ravel(), atol=1e-9)
        of_transmitter.append(transmitter)
        of_receivers.append(receiver)
    np.testing.assert_allclose(of_transmitter, of_transmitter[:1] * 3, rtol=1e-8)
    assert np.abs(np.diff(np.angle(of_receivers), axis=0)).min() > 0.01


def test_the_bottom_counts_its_coefficient_apart_from_range_and_lobe() -> None:
    on_axis = np.array([[0.0], [0.0], [0.05]])
    field = sum(make_waves(perfect_setup(reflection=0.2), place_antennas(perfect_setup())).at_tracer(on_axis))
    direct = sum(make_waves(perfect_setup(), place_antennas(perfect_setup())).at_tracer(on_axis))
    image_m = 0.7 + 2 * 0.145
    coefficient = (field - direct) / direct * (image_m + 0.05) / 0.65
    assert abs(coefficient[0]) == pytest.approx(0.2)


def test_phases_come_from_the_seed_and_the_walls_stay_from_run_to_run() -> None:
    def first(seed: int, run: int) -> np.ndarray:
        return SimulatedRadar(perfect_setup(**ONE, seed=seed), run=run).samples(6000, 2000)

    np.testing.assert_array_equal(first(1, 0), first(1, 3))
    assert np.abs(first(1, 0) - first(2, 0)).max() > 0.01


def test_walls_are_off_unless_asked_for_whatever_the_mismatch() -> None:
    assert len(reflectors_of(perfect_setup(mismatch=0.1))) == 1
    assert len(reflectors_of(perfect_setup(mismatch=0.1, **TWO))) == 3
    assert reflectors_of(perfect_setup(**{**TWO, "wall_reflection": 0.0})) == ()


def test_an_antenna_beyond_a_wall_has_no_image_in_it() -> None:
    # receivers stand 0.45 m from the axis at -150, -30 and 90 degrees
    walls = {"wall_reflection": 0.05, "wall_distance_m": (0.3,), "wall_azimuth_deg": (90.0,)}
    setup, places = perfect_setup(**walls), _places(50)
    transmitter = 1.0 + _bare_ratio(setup, places)
    ratio = _received(setup, places) / _received(perfect_setup(), places)
    np.testing.assert_allclose(ratio[2] / ratio[2][0], transmitter / transmitter[0], atol=1e-12)
    assert np.abs(ratio[0] / ratio[0][0] - transmitter / transmitter[0]).max() > 0.01


def _bare_ratio(setup: Setup, places: np.ndarray) -> np.ndarray:
    """Field of the transmitter's images over its direct field."""
    antennas = place_antennas(setup)
    direct = sum(make_waves(perfect_setup(), antennas).at_tracer(places))
    return sum(make_waves(setup, antennas).at_tracer(places)) / direct - 1.0


def test_a_path_through_a_wall_is_refused_and_without_reflection_allowed() -> None:
    swing = {
        "scene": "pendulum",
        "pendulum_amplitude_deg": 40.0,
        "lateral_azimuth_deg": 210.0,
        "floor": {"height_m": -0.3},
    }
    with pytest.raises(SetupError, match="through wall 1"):
        SimulatedRadar(perfect_setup(**swing, **ONE))
    SimulatedRadar(perfect_setup(**swing, **{**ONE, "wall_reflection": 0.0}))


def test_every_wall_needs_distance_and_azimuth_and_walls_survive_the_setup_file() -> None:
    setup = perfect_setup(**TWO)
    assert parse_setup(dump_setup(setup)) == setup
    text = dump_setup(setup).replace("[0.3, 0.25]", "[0.3]")
    with pytest.raises(
        SetupError, match=r"wall_azimuth_deg = .*allowed: as many values as in simulation.wall_distance_m"
    ):
        parse_setup(text)


def test_walls_change_every_channel_by_about_their_size() -> None:
    clean, walls = (simulate_recording(perfect_setup(**kind))[0].volts() for kind in ({}, ONE))
    size = np.abs(walls - clean).max(axis=1)
    assert (size > 0.02).all()
    assert (size < 0.3).all()
