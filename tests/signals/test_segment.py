"""The segment with motion: found, and nothing invented in noise, hum or drift."""

from __future__ import annotations

import numpy as np
import pytest
from support.drops import Drop

from radargui.model.arrays import FloatArray
from radargui.signals.noise import white_noise_v
from radargui.signals.segment import Motion, find_motion

RATE = 20000.0


def motion_in(volts: FloatArray, rate_hz: float) -> Motion | None:
    return find_motion(volts, rate_hz, white_noise_v(volts))


def iq_of(height_m: FloatArray, noise: float = 0.005, seed: int = 0) -> FloatArray:
    phase = -2 * np.pi * 1.77 * height_m / 0.03
    z = np.stack([np.cos(phase), np.sin(phase)])
    return np.asarray(z + noise * np.random.default_rng(seed).normal(size=z.shape))


def test_white_noise_is_measured_beside_any_smooth_motion() -> None:
    drop = Drop()
    noise = white_noise_v(iq_of(drop.height(drop.time_s), 0.01))
    assert noise == pytest.approx([0.01, 0.01], rel=0.05)


@pytest.mark.parametrize("noise", [0.0, 0.001, 0.02, 0.1])
def test_a_drop_moves_from_its_release_to_its_last_bounce(noise: float) -> None:
    drop = Drop(rate_hz=RATE)
    segment = motion_in(iq_of(drop.height(drop.time_s), noise), RATE)
    assert segment is not None
    assert segment.first / RATE == pytest.approx(drop.rest_s, abs=0.03)
    assert drop.impact_s[-12] < segment.last / RATE < drop.impact_s[-1] + 0.03


def test_a_drop_is_found_under_a_hum() -> None:
    drop = Drop(rate_hz=RATE)
    volts = iq_of(drop.height(drop.time_s)) + 0.1 * np.sin(2 * np.pi * 50 * drop.time_s)
    segment = motion_in(volts, RATE)
    assert segment is not None
    assert segment.first / RATE == pytest.approx(drop.rest_s, abs=0.04)


def test_motion_at_constant_speed_with_the_doppler_of_the_mains_is_motion() -> None:
    time = np.arange(20000) / RATE
    turn = 2 * np.pi * 50 * time
    volts = np.stack([np.cos(turn), np.sin(turn)]) + np.random.default_rng(0).normal(0, 0.005, (2, 20000))
    segment = motion_in(volts, RATE)
    assert segment is not None
    assert (segment.first, segment.last) == (0, 20000)


@pytest.mark.parametrize("rate_hz", [2000.0, RATE, 100_000.0])
def test_a_spike_is_no_motion(rate_hz: float) -> None:
    volts = np.random.default_rng(0).normal(0, 0.005, (6, 20000))
    volts[2, 10000] = 1.0
    assert motion_in(volts, rate_hz) is None


def test_motion_until_the_end_holds_the_last_sample_too() -> None:
    time = np.arange(30007) / RATE
    segment = motion_in(iq_of(0.1 * np.clip(time - 0.5, 0.0, None) ** 2), RATE)
    assert segment is not None
    assert segment.last == 30007


def test_a_slow_circle_deep_in_noise_is_motion_and_its_rest_is_found() -> None:
    rate = 2000.0
    time = np.arange(6000) / rate
    angle = 2 * np.pi * 1.2 * np.clip(time - 0.5, 0.0, None) ** 2 / (1.0 + np.clip(time - 0.5, 0.0, None))
    draw = np.random.default_rng(0)
    volts = np.concatenate([np.stack([np.cos(angle + k), np.sin(angle + k)]) for k in range(3)])
    volts = volts + 0.15 * draw.normal(size=volts.shape)
    segment = motion_in(volts, rate)
    assert segment is not None
    assert 0.4 < segment.first / rate < 0.9
    assert segment.last / rate > 2.8


def test_a_slow_pendulum_that_reflections_make_ragged_is_motion() -> None:
    rate = 2000.0
    time = np.arange(4600) / rate
    swing = 17.0 * (1.0 - np.cos(3.0 * np.clip(time - 0.3, 0.0, None)))
    pairs = []
    for share in (1.0, 0.5, 0.05):
        radius = 1.0 + 0.5 * np.cos(0.8 * share * swing)
        pairs += [radius * np.cos(share * swing), radius * np.sin(share * swing)]
    volts = np.array(pairs) + 0.15 * np.random.default_rng(2).normal(size=(6, time.size))
    segment = motion_in(volts, rate)
    assert segment is not None
    assert segment.first / rate < 0.8


@pytest.mark.parametrize("seed", range(20))
def test_a_strong_slow_drift_at_rest_is_no_motion(seed: int) -> None:
    draw = np.random.default_rng(seed)
    time = np.arange(30000) / 10000.0
    drift = sum(
        0.06 * np.sin(2 * np.pi * draw.uniform(0.03, 0.3, (6, 1)) * time + draw.uniform(0, 6.3, (6, 1)))
        for _ in range(3)
    )
    assert motion_in(drift + draw.normal(0.2, 0.01, (6, 30000)), 10000.0) is None
