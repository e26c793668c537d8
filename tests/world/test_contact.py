"""Impacts on planes that stand, lean or vibrate, rolling and riding: energy, spin, continuity."""

from __future__ import annotations

import numpy as np
import pytest
from benchmarks.world.contact import Surface, Vibration, rebound
from benchmarks.world.course import UP
from benchmarks.world.drop import ROLLING, Body, Impact
from benchmarks.world.journey import Journey, journey

STEEL = Body(0.005, 7850.0, 9.81)
HEAVY = Body(0.005, 1e6, 9.81)  # hardly braked by air
ASIDE = np.array([1.0, 0.0, 0.0])
FLOOR = Surface(UP, np.zeros(3), 0.8, 0.0)


def generator() -> np.random.Generator:
    return np.random.default_rng(3)


def hit(
    surface: Surface, velocity: np.ndarray, spin: np.ndarray | None = None
) -> tuple[Impact, np.ndarray, np.ndarray]:
    return rebound(generator(), surface, STEEL.radius_m, 0.0, velocity, np.zeros(3) if spin is None else spin)


def energy(velocity: np.ndarray, spin: np.ndarray) -> float:
    return float(velocity @ velocity / 2.0 + 0.2 * STEEL.radius_m**2 * (spin @ spin))


def gone(*surfaces: Surface, place: np.ndarray, velocity: np.ndarray, end_s: float = 1.0, **values: float) -> Journey:
    return journey(generator(), HEAVY, surfaces, place, velocity, start_s=0.0, end_s=end_s, **values)


@pytest.mark.parametrize("friction", [0.0, 0.05, 1.0])
def test_an_impact_turns_the_normal_speed_by_e_and_makes_no_energy(friction: float) -> None:
    surface = Surface(np.array([0.6, 0.0, 0.8]), np.zeros(3), 0.7, 0.0, friction=friction)
    before, spin = np.array([0.3, 0.4, -1.5]), np.array([20.0, -30.0, 5.0])
    impact, after, turned = hit(surface, before, spin)
    assert impact.e == pytest.approx(0.7)
    assert surface.normal @ after == pytest.approx(-0.7 * (surface.normal @ before))
    assert energy(after, turned) < energy(before, spin)
    if not friction:
        np.testing.assert_allclose(surface.level(after), surface.level(before))


def test_enough_friction_leaves_a_sphere_that_rolls_and_keeps_rolling() -> None:
    _, after, spin = hit(FLOOR, np.array([0.3, 0.0, -1.5]))
    assert after[0] == pytest.approx(ROLLING * 0.3)
    np.testing.assert_allclose(FLOOR.level(after), STEEL.radius_m * np.cross(spin, UP), atol=1e-15)
    _, again, _ = hit(FLOOR, np.array([after[0], 0.0, -1.0]), spin)
    assert again[0] == pytest.approx(after[0])


def test_little_friction_pushes_no_harder_than_coulomb_lets_it() -> None:
    surface = Surface(UP, np.zeros(3), 0.8, 0.0, friction=0.1)
    impact, after, _ = hit(surface, np.array([1.0, 0.0, -0.5]))
    assert 1.0 - after[0] == pytest.approx(0.1 * (impact.before_m_s + impact.after_m_s))


def test_a_plate_that_moves_gives_its_speed_twice_less_what_e_takes() -> None:
    plate = Surface(UP, np.zeros(3), 0.5, 0.0, vibration=Vibration(0.002, 20.0))
    speed = float(plate.vibration.moved(0.0, 1))
    assert speed == pytest.approx(0.002 * 2.0 * np.pi * 20.0)
    impact, after, _ = hit(plate, np.array([0.0, 0.0, -1.0]))
    assert impact.before_m_s == pytest.approx(1.0 + speed)
    assert after[2] == pytest.approx(speed + 0.5 * (1.0 + speed))


@pytest.mark.parametrize("grows_s", [0.0, 0.2])
def test_speed_and_acceleration_of_a_plate_are_the_derivatives_of_its_height(grows_s: float) -> None:
    shake, times, step = Vibration(0.003, 12.0, 0.7, grows_s), np.linspace(0.01, 0.4, 300), 1e-5
    for order in (0, 1):
        slope = (shake.moved(times + step, order) - shake.moved(times - step, order)) / (2.0 * step)
        np.testing.assert_allclose(shake.moved(times, order + 1), slope, atol=1e-4)
    assert grows_s == 0.0 or abs(shake.moved(0.0, 2)) < 1e-12


def test_a_journey_over_a_floor_keeps_its_energy_between_impacts_and_loses_by_e_in_them() -> None:
    went = gone(FLOOR, place=0.2 * UP, velocity=0.1 * ASIDE)
    first, second = went.impacts[:2]
    assert first.before_m_s == pytest.approx(np.sqrt(2.0 * 9.81 * 0.2), rel=1e-4)
    assert second.time_s - first.time_s == pytest.approx(2.0 * first.after_m_s / 9.81, rel=1e-4)
    assert second.before_m_s == pytest.approx(0.8 * first.before_m_s, rel=1e-4)
    places = went.position(np.array([one.time_s for one in went.impacts]))
    np.testing.assert_allclose(places[2], 0.0, atol=1e-10)
    assert np.linalg.norm(np.diff(went.position(np.linspace(0.0, 1.0, 20_001)), axis=1), axis=0).max() < 2.0 / 20_000


def test_a_wall_is_a_side_impact_and_turns_the_drift() -> None:
    wall = Surface(-ASIDE, 0.03 * ASIDE, 0.9, 0.0, friction=0.2, is_floor=False)
    went = gone(FLOOR, wall, place=0.2 * UP, velocity=0.2 * ASIDE)
    assert len(went.sides) == 1
    side = went.sides[0]
    assert went.position(np.array([side.time_s]))[0, 0] == pytest.approx(0.03, abs=1e-10)
    assert went.position(np.linspace(0.0, 1.0, 4000))[0].max() < 0.03 + 1e-9
    assert all(one.time_s != side.time_s for one in went.impacts)


def test_a_sphere_rolls_to_a_wall_and_back_until_the_floor_stops_it() -> None:
    wall = Surface(-ASIDE, 0.02 * ASIDE, 0.9, 0.0, friction=0.2, is_floor=False)
    went = gone(FLOOR, wall, place=np.zeros(3), velocity=0.1 * ASIDE, lies_on=FLOOR, resistance=0.01, end_s=3.0)
    assert went.sides[0].before_m_s == pytest.approx(np.sqrt(0.01 - 2.0 * 0.01 * 9.81 * 0.02), rel=1e-3)
    places = went.position(np.linspace(0.0, 3.0, 3001))
    assert places[0].max() < 0.02 + 1e-9
    np.testing.assert_array_equal(places[:, -500:], np.repeat(places[:, -1:], 500, axis=1))
    assert np.abs(np.diff(places[0])).max() < 0.1 * 1.01e-3


def test_beyond_its_end_a_floor_holds_nothing() -> None:
    block, table = (Surface(UP, h * UP, 0.8, 0.0, end=e) for h, e in ((0.0, (ASIDE, 0.05)), (-0.03, None)))
    went = gone(block, table, place=0.1 * UP, velocity=0.2 * ASIDE)
    places = went.position(np.array([one.time_s for one in went.impacts]))
    np.testing.assert_allclose(places[2], np.where(places[0] < 0.05, 0.0, -0.03), atol=1e-10)
    assert len(set(np.round(places[2], 6))) == 2


def test_a_plate_carries_the_sphere_until_it_falls_away_faster_than_g() -> None:
    shake = Vibration(0.005, 10.0, 0.0, 0.3)
    plate = Surface(UP, np.zeros(3), 0.6, 0.0, vibration=shake)
    went = gone(plate, place=np.zeros(3), velocity=np.zeros(3), lies_on=plate)
    times = np.linspace(0.0, 1.0, 20_001)
    above = went.position(times)[2] - shake.moved(times)
    leaves = times[np.flatnonzero(above > 1e-9)[0]]
    assert shake.moved(leaves, 2) == pytest.approx(-9.81, rel=0.02)
    assert above.min() > -1e-9
    assert above.max() > 1e-3


def test_a_plate_that_never_falls_away_keeps_it() -> None:
    shake = Vibration(0.001, 10.0, 0.0, 0.3)
    plate = Surface(UP, np.zeros(3), 0.6, 0.0, vibration=shake)
    went = gone(plate, place=np.zeros(3), velocity=np.zeros(3), lies_on=plate)
    times = np.linspace(0.0, 1.0, 2001)
    np.testing.assert_allclose(went.position(times)[2], shake.moved(times), atol=1e-12)
    assert went.impacts == ()
