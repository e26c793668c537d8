"""The pick-up of the mains is found while the tracer rests and taken off the motion too."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.changed import changed
from support.estimates import conditioned_of
from support.simulated_recording import simulate_recording

from radargui.model.arrays import FloatArray
from radargui.model.setup import read_setup
from radargui.signals.hum import find_hum
from radargui.signals.noise import white_noise_v
from radargui.system.resources import default_setup_path

RATE = 10000.0
REST = (slice(0, 5000), slice(25000, 30000))
LIVE_RATE = 4000.0


def hum_and_noise(frequency_hz: float, third: float = 0.0, noise: float = 0.005) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(0)
    time = np.arange(30000) / RATE
    phase = rng.uniform(0, 2 * np.pi, (4, 1))
    hum = 0.05 * np.sin(2 * np.pi * frequency_hz * time + phase)
    hum += third * np.sin(3 * 2 * np.pi * frequency_hz * time + 2 * phase)
    return hum, hum + 0.3 + 0.02 * time + noise * rng.normal(size=hum.shape)


@pytest.mark.parametrize("frequency", [49.93, 50.0, 60.05])
def test_frequency_and_amplitude_of_the_mains_are_found_from_the_rests(frequency: float) -> None:
    hum, volts = hum_and_noise(frequency, third=0.01)
    found = find_hum(volts, RATE, REST, np.full(4, 0.005))
    assert found is not None
    assert found.frequency_hz == pytest.approx(frequency, abs=0.003)
    assert found.orders == (1, 3)
    assert np.hypot(found.cosine_v, found.sine_v)[:, 0] == pytest.approx(np.full(4, 0.05), rel=0.02)
    assert np.sqrt(np.mean((found.at(np.arange(30000) / RATE) - hum) ** 2)) < 0.0015


def test_noise_has_no_hum() -> None:
    rng = np.random.default_rng(1)
    for _ in range(50):
        assert find_hum(rng.normal(0, 0.01, (6, 3000)), 2000.0, (slice(0, 3000),), np.full(6, 0.01)) is None


def test_without_a_rest_no_hum_is_found() -> None:
    _, volts = hum_and_noise(50.0)
    assert find_hum(volts, RATE, (), np.full(4, 0.005)) is None
    assert find_hum(volts, RATE, (slice(0, 999),), np.full(4, 0.005)) is None


def test_noise_whose_power_falls_with_the_frequency_has_no_hum() -> None:
    rng = np.random.default_rng(2)
    frequency = np.fft.rfftfreq(30000, 1.0 / RATE)
    colour = 0.6 / np.sqrt(np.maximum(frequency, 1.0))
    volts = np.fft.irfft(colour * np.fft.rfft(rng.normal(size=(6, 30000)), axis=1), 30000, axis=1)
    assert find_hum(volts + rng.normal(0.0, 0.005, volts.shape), RATE, REST, np.full(6, 0.005)) is None


def test_a_drop_under_a_hum_comes_out_as_if_there_were_none() -> None:
    setup = changed(read_setup(default_setup_path()), daq={"rate_hz": 10000.0}, simulation={"mismatch": 0.0})
    clean, _ = simulate_recording(setup)
    humming, _ = simulate_recording(changed(setup, simulation={"mains": 0.1}))
    conditioned = conditioned_of(humming, setup)
    left = conditioned.volts - clean.volts()
    assert np.sqrt(np.mean((humming.volts() - clean.volts()) ** 2)) > 0.03
    assert np.sqrt(np.mean(left**2)) < 0.002


def test_of_an_inverted_q_the_hum_is_taken_off_as_of_a_straight_one() -> None:
    setup = changed(
        read_setup(default_setup_path()), daq={"rate_hz": 10000.0}, simulation={"mismatch": 0.0, "mains": 0.1}
    )
    recording, _ = simulate_recording(setup)
    raw = recording.raw.copy()
    raw[1::2] = -raw[1::2]
    inverted = conditioned_of(replace(recording, raw=raw), changed(setup, radar={"phase_sign": -1}))
    straight = conditioned_of(recording, setup)
    np.testing.assert_allclose(inverted.volts, straight.volts, atol=1e-3)


def live_hum_v(time_s: FloatArray, frequency_hz: float) -> FloatArray:
    turn = 2.0 * np.pi * frequency_hz * time_s
    return np.stack([0.02 * np.cos(turn + 1.0), 0.01 * np.sin(turn) + 0.004 * np.cos(3.0 * turn), np.zeros_like(turn)])


@pytest.mark.parametrize("frequency_hz", [50.0, 60.0, 50.04, 59.95])
def test_a_hum_found_in_the_rest_before_a_motion_is_known_for_the_next_second(frequency_hz: float) -> None:
    time = np.arange(round(1.8 * LIVE_RATE)) / LIVE_RATE
    volts = live_hum_v(time, frequency_hz) + np.array([[0.3], [-0.2], [0.1]])
    volts = volts + np.random.default_rng(0).normal(0.0, 0.003, volts.shape)
    rest = volts[:, :3200]
    hum = find_hum(rest, LIVE_RATE, (slice(0, 3200),), white_noise_v(rest))
    assert hum is not None
    assert hum.frequency_hz == pytest.approx(frequency_hz, abs=0.03)
    left = live_hum_v(time, frequency_hz)[:, 3200:] - hum.at(time[3200:])
    assert np.abs(left).max() < 0.003
    assert np.abs(hum.at(time)[2]).max() < 0.0005
