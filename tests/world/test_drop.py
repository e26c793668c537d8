"""The motion against closed forms: fall in air, impacts along the leaning floor's normal, the endings."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from benchmarks.world.drop import AIR_M2_S, ROLLING, Body, Drop, Floor, drag_coefficient_times_speed, fall

STEEL = Body(0.005, 7850.0, 9.81)
RELEASE = np.array([0.01, -0.02, 0.1])
LEVEL = Floor(np.array([0.0, 0.0, 1.0]), RELEASE - [0.0, 0.0, 0.2], 0.8)


def dropped(floor: Floor = LEVEL, *, body: Body = STEEL, seconds: float = 1.2, **options: float) -> Drop:
    return fall(np.random.default_rng(5), body, floor, RELEASE, start_s=0.2, duration_s=seconds, **options)


def leaning(degrees: float, kick_m_s: float = 0.03) -> Floor:
    normal = np.array([np.sin(np.radians(degrees)), 0.0, np.cos(np.radians(degrees))])
    return Floor(normal, LEVEL.touch_m, 0.8, kick_m_s=kick_m_s)


def velocity(drop: Drop, time_s: float, step_s: float = 1e-6) -> np.ndarray:
    before, after = drop.position(np.array([time_s - step_s, time_s + step_s])).T
    return (after - before) / (2.0 * step_s)


def test_it_hangs_until_it_is_let_go() -> None:
    places = dropped().position(np.linspace(0.0, 0.2, 11))
    np.testing.assert_array_equal(places, np.repeat(RELEASE[:, None], 11, axis=1))


def test_the_first_fall_loses_what_drag_has_done() -> None:
    light = replace(STEEL, density_kg_m3=300.0)
    times = np.linspace(0.0, 0.19, 20001)
    place = RELEASE[2] - dropped(body=light).position(0.2 + times)[2]
    speed = np.gradient(place, times)
    lost = np.array([light.braking_1_s(float(one)) * one for one in speed])
    # energy: half the square of the speed is what gravity gave less what drag took along the way
    taken = np.concatenate([[0.0], np.cumsum(0.5 * (lost[1:] + lost[:-1]) * np.diff(place))])
    energy = light.acceleration_m_s2 * place - taken
    np.testing.assert_allclose(0.5 * speed[1:-1] ** 2, energy[1:-1], atol=1e-6)


@pytest.mark.parametrize(
    ("reynolds", "coefficient"), [(100.0, 1.087), (300.0, 0.653), (1000.0, 0.471), (3000.0, 0.393)]
)
def test_a_sphere_has_the_drag_of_the_standard_curve(reynolds: float, coefficient: float) -> None:
    # Clift, Grace & Weber 1978, table 5.2, of which the fit is within some per cent
    speed = reynolds * AIR_M2_S / 0.01
    assert drag_coefficient_times_speed(speed, 0.01) / speed == pytest.approx(coefficient, rel=0.08)


def test_air_takes_one_and_a_half_times_the_ratio_of_densities_from_g() -> None:
    assert STEEL.acceleration_m_s2 / 9.81 - 1.0 == pytest.approx(-1.5 * 1.2 / 7850.0, rel=1e-3)
    # what is known of a 10 mm steel sphere at the end of its fall
    assert STEEL.braking_1_s(2.0) / 2.0 == pytest.approx(0.005, rel=0.1)


@pytest.mark.parametrize("floor", [LEVEL, leaning(0.6), leaning(3.0)], ids=["level", "0.6 deg", "3 deg"])
def test_impacts_happen_on_the_floor_with_the_speeds_told(floor: Floor) -> None:
    drop = dropped(floor)
    assert len(drop.impacts) >= 3
    for impact in drop.impacts[:3]:
        place = drop.position(np.array([impact.time_s]))[:, 0]
        assert floor.normal @ (place - floor.touch_m) == pytest.approx(0.0, abs=1e-10)
        before = velocity(drop, impact.time_s - 2e-6)
        after = velocity(drop, impact.time_s + 2e-6)
        assert floor.normal @ before == pytest.approx(-impact.before_m_s, abs=1e-4)
        assert floor.normal @ after == pytest.approx(impact.after_m_s, abs=1e-4)
        assert impact.e == pytest.approx(0.8, abs=0.04)


def test_between_impacts_it_never_sinks_into_the_floor() -> None:
    floor = leaning(1.0)
    heights = floor.normal @ (dropped(floor).position(np.linspace(0.0, 1.2, 5000)) - floor.touch_m[:, None])
    assert heights.min() > -1e-9


def test_a_leaning_floor_and_kicks_turn_speed_sideways_and_a_level_one_without_does_not() -> None:
    ends = np.array([1.2])
    np.testing.assert_allclose(dropped().position(ends)[:2, 0], RELEASE[:2], atol=1e-12)
    assert np.linalg.norm(dropped(leaning(1.0, 0.0)).position(ends)[:2, 0] - RELEASE[:2]) > 1e-3
    assert np.linalg.norm(dropped(leaning(0.0)).position(ends)[:2, 0] - RELEASE[:2]) > 1e-3


def test_a_bouncing_sphere_comes_to_roll_down_the_slope() -> None:
    floor = replace(leaning(1.0, 0.0), restitution=0.3)
    drop = dropped(floor, seconds=2.0)
    assert drop.impacts[-1].after_m_s == 0.0
    late = drop.impacts[-1].time_s + 0.3
    assert floor.normal @ velocity(drop, late) == pytest.approx(0.0, abs=1e-9)
    gained = (velocity(drop, late + 0.2) - velocity(drop, late)) / 0.2
    slope = ROLLING * STEEL.acceleration_m_s2 * np.sin(np.radians(1.0))
    assert np.linalg.norm(gained) == pytest.approx(slope, rel=1e-4)


def test_a_bed_catches_it_within_the_depth_without_an_impact() -> None:
    drop = dropped(caught_within_m=0.01)
    end = drop.position(np.array([1.2]))[:, 0]
    assert drop.impacts == ()
    np.testing.assert_allclose(end, LEVEL.touch_m - [0.0, 0.0, 0.01], atol=1e-9)
    np.testing.assert_allclose(velocity(drop, 1.0), 0.0, atol=1e-9)
    speed = np.linalg.norm(velocity(drop, 0.2 + np.sqrt(0.4 / 9.81)))
    assert speed == pytest.approx(np.sqrt(2.0 * 9.81 * 0.2), rel=5e-3)  # it does not slow before it touches


def test_friction_takes_no_more_along_the_floor_than_its_share_and_no_more_than_rolling_needs() -> None:
    thrown = np.array([0.5, 0.0, 0.0])
    for friction in (0.05, 0.9):
        drop = dropped(replace(LEVEL, friction=friction, scatter=0.0), velocity_m_s=thrown)
        first = drop.impacts[0]
        arriving, leaving = np.array(first.arriving_m_s), np.array(first.leaving_m_s)
        assert -arriving[2] == first.before_m_s
        assert leaving[2] == first.after_m_s
        taken = arriving[0] - leaving[0]
        most = friction * (first.before_m_s + first.after_m_s)
        assert taken == pytest.approx(min(most, (1.0 - ROLLING) * arriving[0]), rel=1e-12)
        np.testing.assert_allclose(velocity(drop, first.time_s - 1e-5), arriving, atol=2e-4)
        np.testing.assert_allclose(velocity(drop, first.time_s + 1e-5), leaving, atol=2e-4)


def test_without_a_friction_that_is_told_a_drop_is_the_one_it_was() -> None:
    told = dropped(replace(LEVEL, friction=1e9))
    times = np.linspace(0.0, 1.2, 400)
    np.testing.assert_allclose(told.position(times), dropped().position(times), atol=1e-12)
