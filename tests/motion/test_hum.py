"""The hum of the mains is learned at rest and taken off afterwards."""

from __future__ import annotations

import numpy as np
import pytest

from radargui.model.arrays import FloatArray
from radargui.motion.hum import Hum

RATE = 4000.0


def hum_v(time_s: FloatArray, frequency_hz: float) -> FloatArray:
    turn = 2.0 * np.pi * frequency_hz * time_s
    return np.stack([0.02 * np.cos(turn + 1.0), 0.01 * np.sin(turn) + 0.004 * np.cos(3.0 * turn), np.zeros_like(turn)])


@pytest.mark.parametrize("frequency_hz", [50.0, 60.0, 50.04, 59.95])
def test_the_hum_learned_at_rest_is_known_for_the_next_second(frequency_hz: float) -> None:
    time = np.arange(round(1.8 * RATE)) / RATE + 77.0
    volts = hum_v(time, frequency_hz) + np.array([[0.3], [-0.2], [0.1]])
    volts = volts + np.random.default_rng(0).normal(0.0, 0.003, volts.shape)
    hum = Hum()
    hum.learn(volts[:, :3200], time[:3200])
    assert hum.frequency_hz == pytest.approx(frequency_hz, abs=0.03)
    left = hum_v(time, frequency_hz)[:, 3200:] - hum.at(time[3200:])
    assert np.abs(left).max() < 0.003
    assert np.array_equal(np.asarray(hum.at(time))[2], np.zeros(time.size))


def test_noise_is_no_hum() -> None:
    time = np.arange(4000) / RATE
    hum = Hum()
    hum.learn(np.random.default_rng(1).normal(0.5, 0.01, (2, 4000)), time)
    assert hum.frequency_hz is None
    assert hum.at(time) == 0.0


@pytest.mark.parametrize(("n", "rate"), [(0, RATE), (5, RATE), (400, RATE), (100, 100.0)])
def test_a_rest_too_short_or_too_coarse_teaches_nothing(n: int, rate: float) -> None:
    time = np.arange(n) / rate
    hum = Hum()
    hum.learn(np.sin(314.0 * time)[None], time)
    assert hum.frequency_hz is None
