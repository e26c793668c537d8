"""Impacts: each one found, none invented where the motion is smooth."""

from __future__ import annotations

import numpy as np
import pytest
from support.drops import Drop

from radargui.model.arrays import FloatArray
from radargui.motion.impacts import find_impacts

RATE = 20000.0


def found_in(height_m: FloatArray, noise_m: float = 20e-6, seed: int = 0) -> FloatArray:
    noisy = height_m + noise_m * np.random.default_rng(seed).normal(size=height_m.size)
    return find_impacts(np.arange(height_m.size) / RATE, noisy, np.ones(height_m.size, dtype=bool), RATE)


@pytest.mark.parametrize("e", [0.4, 0.6, 0.8, 0.92])
def test_every_impact_that_rebounds_with_15_cm_a_second_is_found(e: float) -> None:
    drop = Drop(e=e, rate_hz=RATE)
    found = found_in(drop.height(drop.time_s))
    speed_after = np.sqrt(2 * 9.81 * drop.height_m) * e ** np.arange(1, drop.impact_s.size + 1)
    wanted = drop.impact_s[speed_after > 0.15]
    assert found.size >= wanted.size
    assert found[: wanted.size] == pytest.approx(wanted, abs=0.0015)
    assert np.abs(found[:, None] - drop.impact_s).min(axis=1).max() < 0.002


def test_an_apex_is_no_impact() -> None:
    time = np.arange(0, 0.4, 1 / RATE)
    assert found_in(2.0 * time - 0.5 * 9.81 * time**2).size == 0


def test_a_smooth_turn_round_is_no_impact() -> None:
    time = np.arange(0, 4.0, 1 / RATE)
    assert found_in(0.1 * np.cos(2 * np.pi * time)).size == 0
    assert found_in(0.02 * np.cos(2 * np.pi * 3 * time)).size == 0


def test_a_stop_in_a_granular_bed_is_no_impact() -> None:
    time = np.arange(0, 1.0, 1 / RATE)
    speed, depth = 2.2, 0.01
    stop = 2 * depth / speed
    fall = 0.25 - 0.5 * 9.81 * time**2
    t0 = np.sqrt(2 * 0.25 / 9.81)
    d = np.clip(time - t0, 0, stop)
    height = np.where(time < t0, fall, -speed * d + 0.5 * speed / stop * d**2)
    assert found_in(height).size == 0


def test_an_impact_among_unknown_heights_is_not_told() -> None:
    drop = Drop(rate_hz=RATE)
    height = drop.height(drop.time_s)
    known = np.abs(drop.time_s - drop.impact_s[0]) > 0.004
    found = find_impacts(drop.time_s, np.where(known, height, np.nan), known, RATE)
    assert np.abs(found - drop.impact_s[0]).min() > 0.1
    assert np.abs(found - drop.impact_s[1]).min() < 0.001


def test_a_short_record_has_no_impact() -> None:
    assert found_in(np.zeros(10)).size == 0
