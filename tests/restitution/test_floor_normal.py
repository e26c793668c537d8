"""The floor's normal from velocities at impacts: tilts that are there, and kicks that only look like one."""

from __future__ import annotations

import numpy as np
import pytest

from radargui.restitution.floor_normal import FloorNormal, normal_of_impacts

SLOPE = np.array([0.07, -0.05])


def impacts(slope: np.ndarray, kick_m_s: float, friction: float = 0.0, seed: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """Return velocities before and after five impacts under gravity, e = 0.7 along the normal."""
    rng = np.random.default_rng(seed)
    normal = np.array([*slope, 1.0])
    normal /= np.linalg.norm(normal)
    before, after, velocity = [], [], np.array([0.0, 0.0, -2.0])
    for _ in range(5):
        before.append(velocity)
        along = (velocity @ normal) * normal
        velocity = -0.7 * along + (1.0 - friction) * (velocity - along)
        velocity = velocity + kick_m_s * np.array([*rng.uniform(-1.0, 1.0, 2), 0.0])
        after.append(velocity)
        velocity = velocity * np.array([1.0, 1.0, -1.0])
    return np.array(before), np.array(after)


@pytest.mark.parametrize("friction", [0.0, 0.15, 2.0 / 7.0])
def test_a_tilt_is_found_with_its_uncertainty_whatever_the_friction(friction: float) -> None:
    before, after = impacts(SLOPE, 0.002, friction)
    floor = normal_of_impacts(before, after, np.full(5, 1e-4))
    wrong = floor.normal[:2] / floor.normal[2] - SLOPE
    assert np.abs(wrong).max() < 3.0 * np.sqrt(floor.slope_variance)
    assert floor.u_tilt_deg < 0.5
    assert floor.tilt_deg == pytest.approx(np.degrees(np.arctan(np.hypot(*SLOPE))), abs=0.5)
    assert np.degrees(np.arctan2(*floor.normal[1::-1])) == pytest.approx(324.46 - 360.0, abs=3.0)


def test_random_kicks_on_a_level_floor_leave_the_normal_upright_and_its_uncertainty_covers_them() -> None:
    fits = []
    for seed in range(40):
        before, after = impacts(np.zeros(2), 0.08, seed=seed)
        floor = normal_of_impacts(before, after, np.full(5, 1e-4))
        fits.append(floor)
    inside = [np.abs(f.normal[:2] / f.normal[2]).max() < 3.0 * np.sqrt(f.slope_variance) for f in fits]
    assert np.mean(inside) > 0.95
    assert 0.02 < np.median([floor.u_tilt_deg for floor in fits]) < 0.5


def test_one_impact_cannot_tell_a_tilt_from_a_kick() -> None:
    before, after = impacts(SLOPE, 0.0)
    floor = normal_of_impacts(before[:1], after[:1], np.array([1e-4]))
    assert np.abs(floor.normal[:2] - SLOPE).max() < 2.0 * np.sqrt(floor.slope_variance)
    assert 0.5 < floor.u_tilt_deg < 5.0


@pytest.mark.parametrize("tilt_deg", [0.0, 0.1, 0.6, 2.0])
def test_e_lies_within_what_the_normal_leaves_open_whether_the_floor_is_level_or_not(tilt_deg: float) -> None:
    rng, ratios = np.random.default_rng(7), []
    for seed in range(150):
        turn = rng.uniform(0.0, 2.0 * np.pi)
        slope = np.tan(np.radians(tilt_deg)) * np.array([np.cos(turn), np.sin(turn)])
        true = np.array([*slope, 1.0]) / np.hypot(1.0, np.hypot(*slope))
        before, after = (own[:3] for own in impacts(slope, 0.03, 0.1, seed))
        floor = normal_of_impacts(before, after, np.full(3, 1e-4))
        for b, a in zip(before, after, strict=True):
            wrong = (a @ true) / (b @ true) - (a @ floor.normal) / (b @ floor.normal)
            ratios.append(wrong / np.sqrt(floor.e_variance(b, a) + 1e-12))
    assert np.mean(np.abs(ratios) < 2.0) >= 0.92


def test_a_tilt_that_the_setup_limits_is_believed() -> None:
    before, after = impacts(SLOPE, 0.0)
    floor = normal_of_impacts(before[:1], after[:1], np.array([1e-4]), u_tilt_deg=0.01)
    assert floor.tilt_deg < 0.01


def test_the_normal_adds_nothing_to_e_of_a_sphere_that_goes_straight_up() -> None:
    floor = FloorNormal(np.array([0.0, 0.0, 1.0]), 0.02**2)
    straight = floor.e_variance(np.array([0.0, 0.0, -2.0]), np.array([0.0, 0.0, 1.4]))
    aside = floor.e_variance(np.array([0.0, 0.0, -2.0]), np.array([0.2, 0.0, 1.4]))
    assert straight == 0.0
    assert np.sqrt(aside) == pytest.approx(0.02 * 0.2 / 2.0)


@pytest.mark.parametrize(("sees", "inside"), [(False, 0.85), (True, 0.92)])
def test_e_of_a_sphere_that_grips_and_rolls_lies_within_its_uncertainty_on_a_leaning_floor(
    sees: bool, inside: float
) -> None:
    ratios = []
    for seed in range(100):
        turn = np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi)
        slope = np.tan(np.radians(0.8)) * np.array([np.cos(turn), np.sin(turn)])
        true = FloorNormal(np.array([*slope, 1.0]) / np.hypot(1.0, np.hypot(*slope)), np.radians(0.02) ** 2)
        before, after = impacts(slope, 0.03, 2.0 / 7.0, seed)
        floor = normal_of_impacts(before, after, np.full(5, 1e-4), reflecting=true if sees else None)
        for b, a in zip(before, after, strict=True):
            wrong = (a @ true.normal) / (b @ true.normal) - (a @ floor.normal) / (b @ floor.normal)
            ratios.append(wrong / np.sqrt(floor.e_variance(b, a)))
    assert np.mean(np.abs(ratios) < 2.0) > inside


def leaning(tilt_deg: float, u_deg: float) -> FloorNormal:
    slope = np.tan(np.radians(tilt_deg))
    return FloorNormal(np.array([slope, 0.0, 1.0]) / np.hypot(1.0, slope), np.radians(u_deg) ** 2)


def test_the_surface_that_reflects_tells_the_tilt_that_kicks_hide() -> None:
    slope = np.array([np.tan(np.radians(0.8)), 0.0])
    alone, seen = [], []
    for seed in range(60):
        before, after = (own[:3] for own in impacts(slope, 0.06, 0.1, seed))
        for found, reflecting in ((alone, None), (seen, leaning(0.8, 0.01))):
            floor = normal_of_impacts(before, after, np.full(3, 1e-4), reflecting=reflecting)
            found.append(np.append(floor.normal[:2] / floor.normal[2] - slope, np.sqrt(floor.slope_variance)))
    off_alone, off_seen = (np.sqrt(np.mean(np.array(found)[:, :2] ** 2)) for found in (alone, seen))
    assert off_seen < 0.85 * off_alone
    assert np.mean(np.abs(np.array(seen)[:, :2]) < 2.0 * np.array(seen)[:, 2:]) > 0.92


def test_the_impacts_overrule_a_surface_that_reflects_and_is_not_the_floor() -> None:
    before, after = impacts(np.zeros(2), 0.01)
    floor = normal_of_impacts(before, after, np.full(5, 1e-4), reflecting=leaning(3.0, 0.01))
    assert floor.tilt_deg < 2.0 * floor.u_tilt_deg
    assert floor.u_tilt_deg < 0.3


def test_a_surface_that_is_hardly_known_says_nothing() -> None:
    before, after = impacts(SLOPE, 0.02)
    alone = normal_of_impacts(before, after, np.full(5, 1e-4))
    seen = normal_of_impacts(before, after, np.full(5, 1e-4), reflecting=leaning(0.0, 60.0))
    assert seen.normal == pytest.approx(alone.normal, abs=1e-4)
    assert seen.slope_variance == pytest.approx(alone.slope_variance, rel=0.05)
