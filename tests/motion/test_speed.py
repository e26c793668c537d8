"""Speed along a track against the exact one: falls, impacts, gaps, noise."""

from __future__ import annotations

import numpy as np
import pytest

from radargui.motion.speed import speed_along

G = 9.81
RATE_HZ = 2000.0


def bounce() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Time, position and speed of a fall that turns upwards at 0.2 s with 0.8 of its speed, moving sideways."""
    t = np.arange(0.0, 0.35, 1.0 / RATE_HZ)
    since = t - 0.2
    v = np.where(since < 0.0, -G * t, 0.8 * G * 0.2 - G * since)
    z = np.where(since < 0.0, -0.5 * G * t**2, -0.5 * G * 0.04 + 0.8 * G * 0.2 * since - 0.5 * G * since**2)
    return t, np.stack([0.3 * t, np.zeros_like(t), z]), np.hypot(0.3, v)


def test_the_speed_of_free_flight_is_exact_up_to_the_impact() -> None:
    t, place, speed = bounce()
    assert speed_along(t, place, [0.2]) == pytest.approx(speed, abs=1e-9)
    # without the break the parabola would reach across it
    assert np.abs(speed_along(t, place) - speed).max() > 0.5


def test_no_speed_reaches_across_lost_samples_and_nothing_unknown_has_one() -> None:
    t, place, speed = bounce()
    place[:, 100:130] = np.nan
    place[0, 303] = np.nan
    found = speed_along(t, place, [0.2])
    known = np.isfinite(place).all(axis=0)
    assert np.isnan(found[~known]).all()
    assert found[known] == pytest.approx(speed[known], abs=1e-9)
    kept = np.r_[0:100, 140 : t.size]
    assert speed_along(t[kept], place[:, kept], [0.2])[:100] == pytest.approx(speed[:100], abs=1e-9)


def test_noise_leaves_as_much_as_is_said() -> None:
    t = np.arange(0.0, 4.0, 1.0 / RATE_HZ)
    noisy = np.random.default_rng(5).normal(0.0, 1e-4, (3, t.size))
    noisy[2] += t
    assert np.std(speed_along(t, noisy)[50:-50]) < 0.02


@pytest.mark.parametrize("count", [0, 1, 4])
def test_too_few_points_have_no_speed(count: int) -> None:
    assert np.isnan(speed_along(np.arange(count) / RATE_HZ, np.zeros((3, count)))).all()
