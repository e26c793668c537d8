"""Onset: slow beginnings, drifts."""

from __future__ import annotations

import numpy as np
import pytest

from radargui.signals.onset import creeps_since, find_onset, is_under_way

RATE = 5000.0
TIME = np.arange(8000) / RATE


def turning(phase: np.ndarray, noise: float, seed: int = 3) -> np.ndarray:
    """Three IQ pairs at different phases under noise."""
    pairs = [part(phase + shift) for shift in (0.3, 1.9, 4.0) for part in (np.cos, np.sin)]
    return np.array(pairs) + noise * np.random.default_rng(seed).standard_normal((6, TIME.size))


def test_a_pendulums_slow_beginning_is_motion_before_it_has_gone_a_fifth_of_a_turn() -> None:
    swing = 9.0 * (1.0 - np.cos(4.0 * np.clip(TIME - 0.4, 0.0, None)))
    onset = find_onset(TIME, turning(swing, 0.05))
    assert onset is not None
    assert 0.4 <= onset <= 0.46
    assert np.interp(onset, TIME, swing) < 0.4 * np.pi


@pytest.mark.parametrize("drift", [0.2 * TIME, 0.3 * TIME**2, 0.1 * np.sin(2.0 * np.pi * 0.3 * TIME)])
def test_a_drift_of_the_offsets_is_no_onset(drift: np.ndarray) -> None:
    still = turning(np.zeros_like(TIME), 0.01) + drift
    assert find_onset(TIME, still) is None
    falling = turning(300.0 * np.clip(TIME - 0.8, 0.0, None) ** 2, 0.01) + drift
    assert find_onset(TIME, falling) == pytest.approx(0.8, abs=0.02)


@pytest.mark.parametrize("noise", [0.01, 0.1])
@pytest.mark.parametrize("drift", [0.2 * TIME, 0.3 * TIME**2, 0.1 * np.sin(2.0 * np.pi * 0.3 * TIME)])
def test_a_drift_of_the_offsets_is_no_gentle_start(drift: np.ndarray, noise: float) -> None:
    falling = turning(300.0 * np.clip(TIME - 0.8, 0.0, None) ** 2, noise) + drift
    assert creeps_since(TIME, falling, 0.8) is None


@pytest.mark.parametrize("until_s", [0.75, 1.1, 1.5])
def test_a_start_so_gentle_that_forecasts_move_with_it_is_found_where_it_began(until_s: float) -> None:
    # 0.1 m/s^2 to and fro along a path at 30 mm: seen late, or after several turns
    phase = 2.0 * np.pi / 0.03 * 0.1 * np.clip(TIME - 0.4, 0.0, None) ** 2
    found = creeps_since(TIME, turning(phase, 0.07), until_s)
    assert found == pytest.approx(0.4, abs=0.05)


@pytest.mark.parametrize("seed", [3, 4, 5])
def test_a_slide_before_the_fall_that_drowns_in_short_means_is_found_in_longer_ones(seed: int) -> None:
    # 0.2 to 0.3 rad in a quarter of a second at 20 dB, as of 1 or 2 mm to the side
    phase = 0.25 * np.clip((TIME - 0.4) / 0.25, 0.0, None) ** 2
    found = creeps_since(TIME, turning(phase, 0.1, seed), 0.65)
    assert found == pytest.approx(0.4, abs=0.05)
    assert creeps_since(TIME, turning(np.zeros_like(TIME), 0.1, seed), 0.65) is None


def test_what_one_receiver_alone_shows_is_no_start_of_a_motion() -> None:
    value = turning(np.zeros_like(TIME), 0.01)
    value[0] += np.where(TIME > 0.4, 2.0 * (TIME - 0.4) ** 2, 0.0)
    assert creeps_since(TIME, value, 1.2) is None


def test_one_block_of_5_ms_beside_the_rest_is_no_onset() -> None:
    falling = turning(300.0 * np.clip(TIME - 0.8, 0.0, None) ** 2, 0.01)
    falling[:, 2500:2525] += 0.03
    assert find_onset(TIME, falling) == pytest.approx(0.8, abs=0.02)


@pytest.mark.parametrize(("noise", "drift", "moves"), [(0.01, 0.0, True), (0.2, 0.0, False), (0.01, 0.2, True)])
def test_a_record_that_begins_as_the_motion_does_has_no_rest(noise: float, drift: float, moves: bool) -> None:
    # 2 m/s^2 from the first sample on: 0.6 mm of path, an eighth of a radian, in 25 ms
    phase = 2.0 * np.pi / 0.03 * TIME**2
    assert is_under_way(TIME, turning(phase, noise) + drift * TIME, 0.025) is moves
    still = turning(np.zeros_like(TIME), noise) + drift * TIME
    assert not any(is_under_way(TIME, still, end_s) for end_s in (0.011, 0.025, 0.1, 0.24))
    # a long rest is looked at by creeps_since
    assert not is_under_way(TIME, turning(phase, noise), 0.3)


def test_one_receiver_whose_cable_is_touched_does_not_end_a_short_rest() -> None:
    value = turning(np.zeros_like(TIME), 0.01)
    value[:2] += 2.0 * TIME
    assert not is_under_way(TIME, value, 0.1)
