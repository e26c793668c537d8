"""The simulated laboratory: a metal sphere between polarised antennas, crosstalk, a floor that leans, kicks."""

from __future__ import annotations

import numpy as np
import pytest
from support.changed import changed
from support.simulated_setup import perfect_setup

from radargui.model.scattering import mie_sphere, received_direction, scattered_field
from radargui.model.setup import Setup
from radargui.physics.path_length import mirror, path_lengths, place_antennas
from radargui.sources.simulated.model import SimulatedRadar
from radargui.sources.simulated.scene import Scene, contact_plane
from radargui.sources.simulated.waves import Lobe, make_waves, reflectors_of

RELEASE = np.array([0.0, 0.0, 0.12])


def polarised(setup: Setup, transmitter_deg: float = 25.0, *receivers_deg: float) -> Setup:
    plain = setup.model_dump(by_alias=True)
    plain["transmitter"]["polarization_deg"] = transmitter_deg
    for one, angle in zip(plain["receiver"], receivers_deg, strict=False):
        one["polarization_deg"] = angle
    return Setup.model_validate(plain)


def received(setup: Setup, place: np.ndarray) -> np.ndarray:
    waves = make_waves(setup, place_antennas(setup))
    field = waves.at_tracer(place)
    return np.array([waves.received(receiver, place, field) for receiver in range(setup.n_receivers)])


def places(count: int = 60) -> np.ndarray:
    return np.random.default_rng(5).uniform(-0.1, 0.1, (3, count))


@pytest.mark.parametrize("reflection", [0.0, 0.2])
def test_every_pair_of_images_has_the_factor_of_its_own_scattered_field(reflection: float) -> None:
    setup = polarised(perfect_setup(reflection=reflection, beamwidth_deg=40.0), 25.0, 70.0)
    point = perfect_setup(reflection=reflection, beamwidth_deg=40.0)
    rho = reflectors_of(point)[0].coefficient if reflection else 0.0
    antennas, lobe, wavelength_m = place_antennas(setup), Lobe.of_beamwidth(40.0), setup.radar.wavelength_m
    sphere, up, here = mie_sphere(0.005, wavelength_m), np.array([0.0, 0.0, 1.0]), places()
    sent = np.array([np.cos(np.radians(25.0)), np.sin(np.radians(25.0)), 0.0])

    def leg(place: np.ndarray, axis: np.ndarray) -> np.ndarray:
        away = here - place[:, None]
        distance = np.linalg.norm(away, axis=0)
        gain = lobe.gain(axis @ away / np.linalg.norm(axis) / distance)
        return gain / distance * np.exp(2j * np.pi * distance / wavelength_m)

    signal = received(setup, here)
    for number, (rx, field) in enumerate(zip(antennas.receivers_m, setup.received_fields(), strict=True)):
        got = received_direction(field.angle_deg, field.horizontal, field.vertical)
        expected = 0.0
        for tx, e_tx, tx_axis, by_tx in (
            (antennas.transmitter_m, sent, -antennas.transmitter_m, 1.0),
            (mirror(antennas.transmitter_m, up, -0.145), mirror(sent, up, 0.0), np.array([0.0, 0.0, 1.0]), rho),
        ):
            for at, e_rx, rx_axis, by_rx in (
                (rx, got, -rx, 1.0),
                (mirror(rx, up, -0.145), mirror(got, up, 0.0), mirror(-rx, up, 0.0), rho),
            ):
                f = e_rx @ scattered_field(sphere, here, tx, e_tx, at)
                expected = expected + by_tx * by_rx * leg(tx, tx_axis) * leg(at, rx_axis) * f
        ratio = signal[number] / expected
        np.testing.assert_allclose(ratio, ratio[0], rtol=1e-11)
    # and the receiver that was given an angle has it
    assert setup.received_fields()[0].angle_deg == 70.0


@pytest.mark.parametrize("is_metal", [True, False])
def test_a_floor_that_is_stated_reflects_so_unless_the_simulation_says_otherwise(is_metal: bool) -> None:
    here, plain = places(5), changed(perfect_setup(), simulation={"reflection": None})
    plain = polarised(plain) if is_metal else plain
    of_steel = received(changed(plain, floor={"material": "steel"}), here)
    # so thin on metal that it is metal
    film = {"material": "glass", "thickness_m": 1e-7, "backing": "metal"}
    np.testing.assert_allclose(received(changed(plain, floor=film), here), of_steel, rtol=1e-3)
    direct, glass = received(plain, here), {"material": "glass", "thickness_m": 0.01}
    of_glass = received(changed(plain, floor=glass), here)
    assert 0.3 < np.abs(of_glass - direct).mean() / np.abs(of_steel - direct).mean() < 0.9
    otherwise = changed(plain, floor=glass, simulation={"reflection": 0.0})
    np.testing.assert_allclose(received(otherwise, here), direct)
    by_modulus = reflectors_of(changed(plain, floor={"reflection": 0.4}))
    assert abs(by_modulus[0].coefficient) == pytest.approx(0.4)


def test_the_sphere_is_a_point_where_no_polarisation_is_given_unless_the_scene_says_metal() -> None:
    place = places(5)
    point, metal = received(perfect_setup(), place), received(perfect_setup(sphere="metal"), place)
    told = received(polarised(perfect_setup(), 0.0), place)
    np.testing.assert_array_equal(metal, told)
    assert np.abs(np.angle(metal / point / (metal / point)[:, :1])).max() > 0.005
    np.testing.assert_array_equal(received(polarised(perfect_setup(sphere="point")), place), point)


def test_the_truth_is_the_centre_of_the_sphere_and_the_way_over_it_whatever_it_scatters() -> None:
    setup = polarised(perfect_setup(lateral_speed_m_s=0.05))
    truth = SimulatedRadar(setup).truth(6000, 3000)
    np.testing.assert_array_equal(
        truth.position_m, SimulatedRadar(perfect_setup(lateral_speed_m_s=0.05)).truth(6000, 3000).position_m
    )
    np.testing.assert_allclose(truth.path_m, path_lengths(truth.position_m, place_antennas(setup)), atol=1e-14)


def test_the_amplitude_is_one_at_the_release_for_metal_too() -> None:
    np.testing.assert_allclose(np.abs(received(polarised(perfect_setup()), RELEASE[:, None])), 1.0, rtol=1e-13)


@pytest.mark.parametrize("skew_s", [0.0, 5e-6])
def test_crosstalk_leaves_a_share_of_the_channel_before_in_each(skew_s: float) -> None:
    daq = {"channel_skew_s": skew_s}
    clean = SimulatedRadar(perfect_setup(daq=daq)).samples(0, 9000)
    mixed = SimulatedRadar(perfect_setup(daq=daq, crosstalk=0.01)).samples(0, 9000)
    before = np.concatenate([np.roll(clean[-1:], 1, axis=1), clean[:-1]])
    expected = clean + 0.01 * (before - clean)
    # the very first sample follows a scan at rest, not the last one
    np.testing.assert_allclose(mixed[:, 1:], expected[:, 1:], atol=1e-14)
    assert mixed[0, 0] == pytest.approx(clean[0, 0] + 0.01 * (clean[-1, 0] - clean[0, 0]), abs=1e-14)


def test_samples_with_crosstalk_are_the_same_however_they_are_read() -> None:
    setup = perfect_setup(crosstalk=0.01, lateral_speed_m_s=0.05)
    whole = SimulatedRadar(setup).samples(3000, 6000)
    parts = SimulatedRadar(setup)
    np.testing.assert_array_equal(np.concatenate([parts.samples(3000, 1100), parts.samples(4100, 4900)], axis=1), whole)


def test_the_floor_leans_as_told_from_what_the_setup_says_and_the_bounces_follow_it() -> None:
    setup = perfect_setup(rest_s=0.0, floor_tilt_deg=2.0, floor_tilt_azimuth_deg=90.0, restitution=0.5)
    normal = contact_plane(setup).normal
    assert normal == pytest.approx([0.0, np.sin(np.radians(2.0)), np.cos(np.radians(2.0))])
    scene = Scene(setup)
    first = float(scene.trajectory.impact_time_s[0])
    before, at, after = scene.position_m(np.array([first - 1e-6, first, first + 1e-6])).T
    change = (after - at - (at - before)) / 1e-6
    assert change / np.linalg.norm(change) == pytest.approx(normal, abs=1e-5)
    assert at @ normal == pytest.approx(contact_plane(setup).distance_m, abs=1e-12)


def test_a_kick_changes_the_velocity_along_the_floor_only_and_each_run_has_its_own() -> None:
    setup = perfect_setup(rest_s=0.0, kick_m_s=0.05, restitution=0.7)
    kicked, other, none = Scene(setup, run=1), Scene(setup, run=2), Scene(perfect_setup(rest_s=0.0, restitution=0.7))
    np.testing.assert_allclose(kicked.trajectory.impact_time_s, none.trajectory.impact_time_s, atol=1e-9)
    time = np.linspace(0.0, kicked.trajectory.duration_s, 300)
    np.testing.assert_allclose(kicked.position_m(time)[2], none.position_m(time)[2], atol=1e-6)
    end = np.array([scene.position_m(time[-1:])[:2, 0] for scene in (kicked, other, none)])
    assert np.linalg.norm(end[0] - end[2]) > 1e-3
    assert np.linalg.norm(end[0] - end[1]) > 1e-3


def test_e_may_fall_with_the_speed_and_scatter_from_impact_to_impact() -> None:
    def e_of(run: int = 0, **simulation: float) -> np.ndarray:
        impacts = Scene(perfect_setup(rest_s=0.0, restitution=0.6, **simulation), run=run).trajectory.impact_time_s
        flights = np.diff(impacts)[:4]
        # in vacuum a flight lasts 2 v / g
        first = np.sqrt(2.0 * 0.26 / 9.81)
        return flights / np.concatenate([[2.0 * first], flights[:-1]])

    speeds = np.sqrt(2.0 * 9.81 * 0.26) * np.cumprod(np.concatenate([[1.0], e_of(restitution_exponent=0.1)[:-1]]))
    np.testing.assert_allclose(e_of(restitution_exponent=0.1), 0.6 * speeds**-0.1, rtol=1e-6)
    scattered = np.concatenate([e_of(run, restitution_scatter=0.01) for run in range(30)])
    assert scattered.mean() == pytest.approx(0.6, abs=0.004)
    assert scattered.std(ddof=1) == pytest.approx(0.01, rel=0.25)
    np.testing.assert_array_equal(e_of(3, restitution_scatter=0.01), scattered[12:16])


def test_a_dead_stop_has_one_impact_and_stays_there() -> None:
    scene = Scene(perfect_setup(rest_s=0.0, restitution=0.0))
    assert scene.trajectory.impact_time_s.size == 1
    still = scene.position_m(scene.trajectory.impact_time_s[0] + np.array([1e-4, 0.1, 0.4]))
    np.testing.assert_allclose(still[2], -0.14, atol=1e-12)
