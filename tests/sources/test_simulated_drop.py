"""The simulated fall and its bounces obey mechanics."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from support.simulated_setup import perfect_setup

from radargui.model.errors import SetupError
from radargui.sources.simulated.scene import Scene

G = 9.81


def _velocity(scene: Scene, time_s: float, side: int, step_s: float = 1e-4) -> np.ndarray:
    """One-sided velocity, exact where the acceleration is constant."""
    times = time_s + side * step_s * np.array([0.0, 1.0, 2.0])
    near, middle, far = scene.position_m(times).T
    return side * (-1.5 * near + 2.0 * middle - 0.5 * far) / step_s


def test_the_sphere_rests_at_the_release_and_then_falls_along_the_parabola() -> None:
    scene = Scene(perfect_setup(rest_s=0.3))
    time = np.linspace(0.0, 0.3 + np.sqrt(2 * 0.26 / G), 500)
    fallen = 0.5 * G * np.maximum(time - 0.3, 0.0) ** 2
    np.testing.assert_allclose(scene.position_m(time)[2], 0.12 - fallen, atol=1e-14)
    assert not scene.position_m(time)[:2].any()


def test_the_first_impact_comes_after_the_time_of_free_fall_and_the_sphere_touches_at_each_impact() -> None:
    scene = Scene(perfect_setup(rest_s=0.3, restitution=0.7))
    impacts = scene.impacts_s(0.0, 100.0)
    assert impacts[0] == pytest.approx(0.3 + np.sqrt(2 * 0.26 / G), abs=1e-15)
    np.testing.assert_allclose(scene.position_m(impacts)[2], -0.14, atol=1e-13)


def test_the_speed_after_each_impact_is_e_times_the_speed_before() -> None:
    scene = Scene(perfect_setup(restitution=0.7))
    impacts = scene.impacts_s(0.0, 100.0)
    for time in impacts[:6]:
        before = -_velocity(scene, time, -1)[2]
        after = _velocity(scene, time, +1)[2]
        assert after / before == pytest.approx(0.7, rel=1e-8)


def test_rebounds_end_below_two_centimetres_a_second_and_the_sphere_stays_on_the_floor() -> None:
    scene = Scene(perfect_setup(restitution=0.5))
    impacts = scene.impacts_s(0.0, 100.0)
    first_speed = np.sqrt(2 * G * 0.26)
    assert first_speed * 0.5 ** (len(impacts) - 1) >= 0.02 > first_speed * 0.5 ** len(impacts)
    later = impacts[-1] + np.linspace(0.0, 5.0, 50)
    np.testing.assert_allclose(scene.position_m(later)[2], -0.14, atol=1e-15)


def test_lateral_speed_is_reached_within_ten_milliseconds_and_kept_through_bounces() -> None:
    setup = perfect_setup(rest_s=0.0, lateral_speed_m_s=0.1, lateral_azimuth_deg=60.0)
    scene = Scene(setup)
    impacts = scene.impacts_s(0.0, 100.0)
    for time in (0.02, 0.5 * (impacts[0] + impacts[1]), 0.5 * (impacts[3] + impacts[4])):
        velocity = _velocity(scene, float(time), +1)
        np.testing.assert_allclose(velocity[:2], [0.05, 0.1 * np.sqrt(0.75)], rtol=1e-7)
    assert np.abs(_velocity(scene, 0.0, +1)[:2]).max() < 1e-9


def test_after_the_last_impact_a_drifting_sphere_rolls_out_evenly() -> None:
    scene = Scene(perfect_setup(rest_s=0.0, settle_s=0.5, lateral_speed_m_s=0.1, lateral_azimuth_deg=0.0))
    last = scene.impacts_s(0.0, 100.0)[-1]
    speeds = [_velocity(scene, last + part, +1)[0] for part in (0.001, 0.125, 0.2499)]
    np.testing.assert_allclose(speeds, [0.0996, 0.05, 0.0], atol=5e-5)
    assert scene.duration_s == pytest.approx(last + 0.25 + 0.5)


def test_the_floor_is_where_the_drop_height_says_else_where_the_setup_says_else_26_cm_below() -> None:
    def lowest(**settings: object) -> float:
        return float(Scene(perfect_setup(**settings)).position_m(np.array([60.0]))[2, 0])

    assert lowest(drop_height_m=0.2) == pytest.approx(-0.08)
    assert lowest() == pytest.approx(-0.14)
    assert lowest(floor={}) == pytest.approx(-0.14)
    assert lowest(floor={}, release=(0.0, 0.0, 0.10)) == pytest.approx(-0.16)


def test_on_a_tilted_floor_the_fall_is_vertical_and_the_impact_reverses_only_the_speed_along_the_normal() -> None:
    normal = np.array([np.sin(0.1), 0.0, np.cos(0.1)])
    scene = Scene(perfect_setup(rest_s=0.0, restitution=0.6, floor={"height_m": -0.14, "normal": normal.tolist()}))
    impact = float(scene.impacts_s(0.0, 100.0)[0])
    falling = scene.position_m(np.linspace(0.0, impact, 50))
    np.testing.assert_allclose(falling[:2], 0.0, atol=1e-15)
    before, after = _velocity(scene, impact, -1), _velocity(scene, impact, +1)
    np.testing.assert_allclose(after, before - 1.6 * (before @ normal) * normal, atol=1e-8)


def test_another_gravity_is_obeyed() -> None:
    scene = Scene(perfect_setup(rest_s=0.0, gravity_m_s2=1.62))
    assert scene.impacts_s(0.0, 100.0)[0] == pytest.approx(np.sqrt(2 * 0.26 / 1.62))


def test_a_bed_stops_the_sphere_evenly_over_its_depth_without_impact_or_rebound() -> None:
    scene = Scene(perfect_setup(scene="bed", rest_s=0.0, bed_depth_m=0.01))
    touch, speed = np.sqrt(2 * 0.26 / G), np.sqrt(2 * G * 0.26)
    assert scene.impacts_s(0.0, 100.0).size == 0
    duration = scene.trajectory.duration_s
    assert duration == pytest.approx(touch + 2 * 0.01 / speed)
    times = np.linspace(touch + 1e-3, duration - 1e-3, 20)
    step = 1e-4
    acceleration = (scene.position_m(times + step) - 2 * scene.position_m(times) + scene.position_m(times - step))[2]
    np.testing.assert_allclose(acceleration / step**2, speed**2 / 0.02, rtol=1e-6)
    assert scene.position_m(np.array([60.0]))[2, 0] == pytest.approx(-0.15)
    assert (np.diff(scene.position_m(np.linspace(0.0, duration, 500))[2]) <= 0.0).all()


@given(
    height=st.floats(0.01, 1.0),
    e=st.floats(0.0, 0.95),
    speed=st.floats(0.0, 1.0),
    slope=st.floats(0.0, 0.3),
    repeat=st.booleans(),
    scene=st.sampled_from(["drop", "bed"]),
)
@settings(max_examples=40, deadline=None)
def test_any_fall_begins_at_the_release_never_jumps_and_never_passes_the_floor(
    height: float, e: float, speed: float, slope: float, repeat: bool, scene: str
) -> None:
    setup = perfect_setup(
        scene=scene,
        release=(0.0, 0.0, 0.0),
        floor={"normal": [slope, 0.0, 1.0]},
        drop_height_m=height,
        restitution=e,
        lateral_speed_m_s=speed,
    )
    normal = np.array(setup.floor.normal)
    simulated = Scene(setup, repeat=repeat)
    times = np.linspace(0.0, 20.0, 20001)
    position = simulated.position_m(times)
    assert not position[:, 0].any()
    sunk = 0.01 if scene == "bed" else 0.0
    assert (normal @ position).min() >= -height * normal[2] - sunk - 1e-12
    fastest = np.sqrt(2 * G * height) + speed + 2.0 * G * slope * 20.0
    returning = 2.0 * np.abs(position).max() if repeat else 0.0
    assert np.abs(np.diff(position)).max() <= 1e-3 * (fastest + returning)


@pytest.mark.parametrize(
    ("settings_", "said"),
    [
        ({"release": (0.0, 0.0, -0.2)}, "not above the floor"),
        ({"floor": {"normal": [0.0, 0.0, -1.0]}}, "faces up"),
        ({"restitution": 0.9999}, "bounce for more than"),
        ({"scene": "bed", "release": (0.0, 0.0, -0.14)}, "not above the floor"),
    ],
)
def test_an_impossible_fall_is_refused_in_a_clear_sentence(settings_: dict[str, object], said: str) -> None:
    with pytest.raises(SetupError, match=said):
        Scene(perfect_setup(**settings_))
