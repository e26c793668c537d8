"""Phases counted over holes."""

from __future__ import annotations

import numpy as np
import pytest

from radargui.correction.phase import unwrapped


def fallen(time_s: np.ndarray) -> np.ndarray:
    """Phases in rad of two paths of a fall at 10 GHz, g along one, less along the other."""
    return np.array([9.81, -4.0])[:, None] * time_s**2 / 2.0 * 2.0 * np.pi / 0.015


@pytest.mark.parametrize("hole_s", [0.003, 0.015, 0.030])
@pytest.mark.parametrize("noise", [0.0, 0.2])
def test_a_hole_of_several_turns_is_counted_by_the_speeds_beside_it(hole_s: float, noise: float) -> None:
    time = np.arange(2000) / 5000.0
    time = time[(time < 0.25) | (time > 0.25 + hole_s)]
    true = fallen(time) + noise * np.random.default_rng(2).standard_normal((2, time.size))
    found = unwrapped(np.angle(np.exp(1j * true)), time)
    assert found - found[:, :1] == pytest.approx(true - true[:, :1], abs=1e-6)
    plain = np.unwrap(np.angle(np.exp(1j * true)), axis=1)
    # or the test would say nothing: half a turn is passed in 3 ms
    assert hole_s < 0.01 or np.abs(plain - plain[:, :1] - (true - true[:, :1])).max() > 6.0


def test_two_samples_between_two_holes_tell_no_speed() -> None:
    time = np.arange(2000) / 5000.0
    time = time[(time < 0.25) | (np.abs(time - 0.2651) < 2e-4) | (time > 0.28)]
    assert (np.diff(time) > 0.01).sum() == 2
    angle = np.angle(np.exp(1j * fallen(time)))
    assert unwrapped(angle, time).tolist() == np.unwrap(angle, axis=1).tolist()
