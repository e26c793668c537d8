"""The pick-up of the mains is found while the tracer rests and taken off the motion too."""

from __future__ import annotations

import numpy as np
import pytest
from support.changed import changed

from radargui.correction.hum import find_hum, rests, without_hum
from radargui.model.resources import default_setup_path
from radargui.model.segment import Segment
from radargui.model.setup_file import read_setup
from radargui.motion.segment import find_segment, floor_of_noise
from radargui.sources.simulated.recording import simulate_recording

RATE = 10000.0
REST = (slice(0, 5000), slice(25000, 30000))


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
    assert found.amplitude_v == pytest.approx(np.full(4, 0.05), rel=0.02)
    assert np.sqrt(np.mean((found.at(np.arange(30000) / RATE) - hum) ** 2)) < 0.0015


def test_noise_has_no_hum() -> None:
    volts = np.random.default_rng(1).normal(0, 0.01, (6, 30000))
    assert find_hum(volts, RATE, REST, np.full(6, 0.01)) is None


def test_without_a_rest_nothing_is_taken_off() -> None:
    _, volts = hum_and_noise(50.0)
    assert find_hum(volts, RATE, (), np.full(4, 0.005)) is None
    assert without_hum(volts, RATE, None, np.full(4, 0.005)) is volts
    assert rests(Segment(0, 30000, 0, 0), 30000, RATE) == ()


def test_a_drop_under_a_hum_comes_out_as_if_there_were_none() -> None:
    setup = changed(read_setup(default_setup_path()), daq={"rate_hz": 10000.0}, simulation={"mismatch": 0.0})
    clean, _ = simulate_recording(setup)
    humming, _ = simulate_recording(changed(setup, simulation={"mains": 0.1}))
    volts = humming.volts()
    left = without_hum(volts, RATE, find_segment(volts, RATE), floor_of_noise(volts)) - clean.volts()
    assert np.sqrt(np.mean((volts - clean.volts()) ** 2)) > 0.03
    assert np.sqrt(np.mean(left**2)) < 0.002
