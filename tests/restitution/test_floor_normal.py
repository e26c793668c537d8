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
    assert floor.azimuth_deg == pytest.approx(324.46, abs=3.0)


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
