"""Motion that the trigger of a drop does not see, and what is none."""

from __future__ import annotations

import numpy as np
import pytest

from radargui.live.map_filter import LATE_S, LONGEST_S, SlowMotion
from radargui.model.arrays import FloatArray

RATE_HZ = 4000.0
NOISE_V = 0.02


def signal(seconds: float, path_m: FloatArray | float = 0.0, seed: int = 0) -> FloatArray:
    count = round(seconds * RATE_HZ)
    phase = 2.0 * np.pi * np.broadcast_to(path_m, count) / 0.03
    noise = np.random.default_rng(seed).normal(0.0, NOISE_V, (2, count))
    return np.asarray(np.stack([np.cos(phase), np.sin(phase)]) + noise)


def said(slow: SlowMotion, volts: FloatArray, block: int = 160) -> list[bool]:
    return [slow.push(volts[:, first : first + block]) for first in range(0, volts.shape[1], block)]


def time_s(seconds: float) -> FloatArray:
    return np.arange(round(seconds * RATE_HZ)) / RATE_HZ


@pytest.mark.parametrize("speed_m_s", [0.02, 0.1, 0.5])
@pytest.mark.parametrize("block", [7, 160, 2000])
def test_a_hand_is_seen_in_time_and_its_end_too(speed_m_s: float, block: int) -> None:
    slow = SlowMotion(RATE_HZ, RATE_HZ, 8.0)
    assert not any(said(slow, signal(2.0), block))
    assert any(said(slow, signal(LATE_S, speed_m_s * time_s(LATE_S)), block))
    assert said(slow, signal(2.0, speed_m_s * time_s(2.0)), block)[-1]
    assert not said(slow, signal(LATE_S + 0.1), block)[-1]


@pytest.mark.parametrize("mains_hz", [50.0, 60.0])
def test_a_drift_and_the_mains_are_no_motion(mains_hz: float) -> None:
    time = time_s(30.0)
    drift = np.stack([0.5 * time / 30.0, -0.5 * time / 30.0])
    hum = 0.3 * np.sin(2.0 * np.pi * mains_hz * time)
    assert not any(said(SlowMotion(RATE_HZ, RATE_HZ, 8.0), signal(30.0) + drift + hum))


def test_what_does_not_end_is_the_new_quiet() -> None:
    slow = SlowMotion(RATE_HZ, RATE_HZ, 8.0)
    said(slow, signal(2.0))
    shaken = signal(LONGEST_S + 4.0, 0.004 * np.sin(2.0 * np.pi * 3.0 * time_s(LONGEST_S + 4.0)))
    told = said(slow, shaken)
    assert told[50]
    assert not told[-1]


def test_what_moves_from_the_start_has_never_rested() -> None:
    slow = SlowMotion(RATE_HZ, RATE_HZ, 8.0)
    assert said(slow, signal(1.0, 0.1 * time_s(1.0)))[-1]
    assert not slow.has_rested
    said(slow, signal(2.0))
    assert slow.has_rested


def test_an_input_that_shows_one_code_is_no_motion() -> None:
    slow = SlowMotion(RATE_HZ, RATE_HZ, 8.0)
    dead = np.zeros((2, 8000))
    dead[:, 4000:] = 1.5e-4
    assert not any(said(slow, np.concatenate([signal(2.0), dead])))
    assert not any(said(SlowMotion(RATE_HZ, RATE_HZ, 8.0), dead))
