"""Circle, pendulum, rest, and the scene that repeats."""

from __future__ import annotations

import numpy as np
import pytest
from support.simulated_setup import perfect_setup

from radargui.sources.simulated.scene import RETURN_S, Pendulum, Scene


@pytest.mark.parametrize("tilt", [0.0, 35.0, 90.0])
def test_a_circle_starts_at_the_release_and_keeps_its_radius_and_its_plane(tilt: float) -> None:
    setup = perfect_setup(scene="circle", circle_radius_m=0.08, circle_tilt_deg=tilt, lateral_azimuth_deg=20.0)
    scene = Scene(setup)
    position = scene.position_m(np.linspace(0.0, scene.duration_s or 0.0, 2001))
    np.testing.assert_allclose(position[:, 0], [0.0, 0.0, 0.12], atol=1e-15)
    tilt_rad, azimuth = np.radians([tilt, 20.0])
    inward = np.array([np.cos(tilt_rad) * np.cos(azimuth), np.cos(tilt_rad) * np.sin(azimuth), -np.sin(tilt_rad)])
    middle = np.array([0.0, 0.0, 0.12]) + 0.08 * inward
    np.testing.assert_allclose(np.linalg.norm(position - middle[:, None], axis=0), 0.08, atol=1e-15)
    normal = np.cross(inward, [-np.sin(azimuth), np.cos(azimuth), 0.0])
    np.testing.assert_allclose(normal @ (position - middle[:, None]), 0.0, atol=1e-15)


@pytest.mark.parametrize("turns", [0.2, 1.0, 2.5])
def test_a_circle_turns_as_often_as_asked_from_rest_to_rest_with_an_even_middle(turns: float) -> None:
    setup = perfect_setup(scene="circle", circle_period_s=1.0, turns=turns, rest_s=0.0)
    circle = Scene(setup).trajectory
    angle = circle.angle_rad  # type: ignore[attr-defined]
    assert float(angle(np.array([1e3]))[0]) == pytest.approx(2 * np.pi * turns)
    times = np.linspace(0.0, circle.duration_s, 4001)
    rate = np.gradient(angle(times), times)
    assert rate[0] == pytest.approx(0.0, abs=0.01)
    assert rate[-1] == pytest.approx(0.0, abs=0.01)
    assert rate.max() <= 2 * np.pi + 1e-6
    assert np.abs(np.diff(rate)).max() < 0.05
    if turns >= 1.0:
        assert rate[2000] == pytest.approx(2 * np.pi)


def test_a_pendulum_keeps_its_length_and_its_energy() -> None:
    setup = perfect_setup(
        scene="pendulum", pendulum_length_m=0.3, pendulum_amplitude_deg=60.0, rest_s=0.0, lateral_azimuth_deg=75.0
    )
    pendulum = Scene(setup).trajectory
    times = np.linspace(0.01, pendulum.duration_s - 0.01, 400)
    step = 1e-5
    position = pendulum.position_m(times)
    velocity = (pendulum.position_m(times + step) - pendulum.position_m(times - step)) / (2 * step)
    energy = 0.5 * (velocity**2).sum(axis=0) + 9.81 * position[2]
    np.testing.assert_allclose(energy, 9.81 * 0.12, atol=1e-8)
    heading = np.array([np.cos(np.radians(75.0)), np.sin(np.radians(75.0)), 0.0])
    pivot = np.array([0.0, 0.0, 0.12]) + 0.3 * (np.array([0.0, 0.0, 0.5]) - np.sqrt(0.75) * heading)
    np.testing.assert_allclose(np.linalg.norm(position - pivot[:, None], axis=0), 0.3, atol=1e-12)


@pytest.mark.parametrize(("amplitude", "ratio"), [(1.0, 1.0000190), (60.0, 1.0731820), (80.0, 1.1374927)])
def test_the_period_of_a_pendulum_grows_with_its_amplitude_as_tabulated(amplitude: float, ratio: float) -> None:
    setup = perfect_setup(scene="pendulum", pendulum_amplitude_deg=amplitude)
    pendulum = Pendulum(setup.simulation, np.array([0.0, 0.0, 0.12]))
    assert pendulum.period_s / (2 * np.pi * np.sqrt(0.5 / 9.81)) == pytest.approx(ratio, abs=2e-7)


def test_a_pendulum_is_released_at_rest_and_caught_at_rest_after_whole_half_swings() -> None:
    setup = perfect_setup(scene="pendulum", turns=1.7, rest_s=0.0)
    pendulum = Scene(setup).trajectory
    assert isinstance(pendulum, Pendulum)
    assert pendulum.duration_s == pytest.approx(1.5 * pendulum.period_s)
    ends = pendulum.position_m(np.array([0.0, 1e-4, pendulum.duration_s - 1e-4, pendulum.duration_s]))
    np.testing.assert_allclose(ends[:, 0], [0.0, 0.0, 0.12], atol=1e-15)
    assert np.linalg.norm(ends[:, 1] - ends[:, 0]) < 1e-7
    assert np.linalg.norm(ends[:, 3] - ends[:, 2]) < 1e-7
    assert ends[2, 3] == pytest.approx(0.12)


def test_at_rest_nothing_moves() -> None:
    scene = Scene(perfect_setup(scene="rest"))
    assert scene.duration_s == pytest.approx(1.2)
    np.testing.assert_array_equal(np.ptp(scene.position_m(np.linspace(0.0, 5.0, 10)), axis=1), 0.0)


@pytest.mark.parametrize("kind", ["drop", "circle", "pendulum", "bed", "rest"])
def test_a_repeated_scene_returns_smoothly_and_every_round_is_the_same(kind: str) -> None:
    setup = perfect_setup(scene=kind, turns=0.7, lateral_speed_m_s=0.05)
    once, again = Scene(setup), Scene(setup, repeat=True)
    run = once.duration_s or 0.0
    period = run + RETURN_S
    times = np.linspace(0.0, run, 500)[:-1]
    np.testing.assert_allclose(again.position_m(times + 3 * period), once.position_m(times), atol=1e-12)
    back = np.linspace(run, period, 3001)
    velocity = np.diff(again.position_m(back)) / np.diff(back)
    assert np.abs(velocity[:, [0, -1]]).max() < 1e-5
    assert np.abs(np.diff(velocity)).max() < 3e-3
    np.testing.assert_allclose(again.position_m(np.array([period - 1e-9]))[:, 0], [0.0, 0.0, 0.12], atol=1e-9)
    assert again.duration_s is None


def test_a_repeated_scene_tells_the_impacts_of_every_round() -> None:
    setup = perfect_setup()
    once = Scene(setup)
    impacts = once.impacts_s(0.0, 100.0)
    period = (once.duration_s or 0.0) + RETURN_S
    again = Scene(setup, repeat=True)
    np.testing.assert_allclose(again.impacts_s(period, 2 * period), impacts + period)
    assert again.impacts_s(0.0, 10 * period).size == 10 * impacts.size
