"""Impacts: each one found, none invented where the motion is smooth."""

from __future__ import annotations

import numpy as np
import pytest
from support.drops import Drop

from radargui.model.arrays import FloatArray
from radargui.model.gravity import NOMINAL_GRAVITY_M_S2 as G_M_S2
from radargui.motion.impacts import IMPACT_LIMITS, find_impacts, find_track_impacts, find_turns

RATE = 20000.0


def found_in(height_m: FloatArray, noise_m: float = 20e-6, seed: int = 0) -> FloatArray:
    noisy = height_m + noise_m * np.random.default_rng(seed).normal(size=height_m.size)
    return find_track_impacts(np.arange(height_m.size) / RATE, noisy, np.ones(height_m.size, dtype=bool), RATE, G_M_S2)


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


def test_a_kick_upwards_in_flight_is_no_impact() -> None:
    time = np.arange(0, 0.2, 1 / RATE)
    assert found_in(0.5 * time + 1.5 * np.clip(time - 0.1, 0.0, None)).size == 0


def test_waves_that_a_mismatch_leaves_in_the_height_are_no_impacts() -> None:
    time = np.arange(0, 1.0, 1 / RATE)
    assert found_in(3e-4 * np.sin(2 * np.pi * 60 * time)).size == 0


def test_a_jump_sooner_after_an_impact_than_the_sphere_can_be_back_is_none() -> None:
    drop = Drop(rate_hz=RATE)
    clean = found_in(drop.height(drop.time_s))
    # 0.15 s after an impact after which the sphere flies for 0.36 s: it falls at once and rises at once, as at a floor
    dip_m = 0.7 * np.clip(0.015 - np.abs(drop.time_s - drop.impact_s[0] - 0.15), 0.0, None)
    assert found_in(drop.height(drop.time_s) - dip_m) == pytest.approx(clean, abs=1e-3)


def test_an_impact_among_unknown_heights_is_not_told() -> None:
    drop = Drop(rate_hz=RATE)
    height = drop.height(drop.time_s)
    known = np.abs(drop.time_s - drop.impact_s[0]) > 0.004
    found = find_track_impacts(drop.time_s, np.where(known, height, np.nan), known, RATE, G_M_S2)
    assert np.abs(found - drop.impact_s[0]).min() > 0.1
    assert np.abs(found - drop.impact_s[1]).min() < 0.001


def test_a_short_record_has_no_impact() -> None:
    assert found_in(np.zeros(10)).size == 0


def test_impacts_of_binned_places_are_found_where_parabolas_meet_and_smooth_turns_are_none() -> None:
    rng = np.random.default_rng(2)
    t = np.arange(0, 0.8, 4e-4)
    fall, rise = -2.0, 1.2
    z = np.where(t < 0.3, -fall * (0.3 - t) - 4.905 * (t - 0.3) ** 2, rise * (t - 0.3) - 4.905 * (t - 0.3) ** 2)
    z = z[t < 0.5]
    noisy = z + 2e-5 * rng.standard_normal(z.size)
    found = find_impacts(t[t < 0.5], noisy, np.full(z.size, 2e-5), G_M_S2)
    assert found == pytest.approx([0.3], abs=5e-5)
    smooth = 0.05 * np.cos(2 * np.pi * t / 0.3) + 2e-5 * rng.standard_normal(t.size)
    assert find_impacts(t, smooth, np.full(t.size, 2e-5), G_M_S2).size == 0


def test_turns_are_all_bounces_of_a_cascade_and_none_of_a_slow_swing() -> None:
    t = np.arange(0.0, 1.0, 4e-4)
    impacts, speeds, z = [0.1], [1.0], np.zeros(t.size)
    while speeds[-1] > 0.12:
        speeds.append(0.7 * speeds[-1])
        impacts.append(impacts[-1] + 2 * speeds[-1] / 9.81)
    for first, last, speed in zip(impacts[:-1], impacts[1:], speeds[1:], strict=True):
        inside = (t >= first) & (t < last)
        z[inside] = speed * (t[inside] - first) - 4.905 * (t[inside] - first) ** 2
    z[t < 0.1] = (0.1 - t[t < 0.1]) * 1.0
    noisy = z + 2e-5 * np.random.default_rng(4).standard_normal(t.size)
    found = find_turns(t, noisy, np.full(t.size, 2e-5))
    for impact in impacts[:-1]:
        assert np.abs(found - impact).min() < 0.002
    swing = 0.05 * np.cos(2 * np.pi * t / 0.9)
    assert find_turns(t, swing, np.full(t.size, 2e-5)).size == 0


@pytest.mark.parametrize(
    ("before", "after", "u_jump", "expected"),
    [
        (-1.0, 0.5, 0.01, True),
        (-0.05, 0.06, 0.001, False),  # jumps by 0.11 m/s
        (-1.0, 0.03, 0.01, False),  # a stop in grains does not rise
        (-0.03, 1.0, 0.01, False),  # nor does what is thrown up fall before
        (-1.0, 0.5, 0.22, False),  # within seven standard uncertainties
        (-1.0, 0.5, np.nan, False),
    ],
)
def test_an_impact_falls_rises_and_jumps(before: float, after: float, u_jump: float, *, expected: bool) -> None:
    assert IMPACT_LIMITS.are_impacts(*(np.array([value]) for value in (before, after, u_jump))).tolist() == [expected]


def test_unseen_bounces_after_the_last_impact_do_not_move_it() -> None:
    drop = Drop(e=0.5, rate_hz=RATE)
    found = found_in(drop.height(drop.time_s), 5e-6)
    last = drop.impact_s[np.abs(drop.impact_s - found[-1]).argmin()]
    assert found[-1] < drop.impact_s[-1]
    assert found == pytest.approx(drop.impact_s[: found.size], abs=3e-4)
    assert found[-1] == pytest.approx(last, abs=3e-4)
