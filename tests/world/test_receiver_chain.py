"""Mixer, noise, multiplexer and converter against their equations."""

from __future__ import annotations

import numpy as np
import pytest
from benchmarks.world.receiver_chain import Converter, Mixer, Noise


def test_the_mixer_makes_the_ellipse_of_its_gain_error_and_offsets() -> None:
    phase = np.linspace(0.0, 2.0 * np.pi, 100)
    mixer = Mixer(0.5, 1.1, 0.1, (0.2, -0.3))
    np.testing.assert_allclose(mixer.volts(np.exp(1j * phase), 0), 0.5 * (np.cos(phase) + 0.2))
    np.testing.assert_allclose(mixer.volts(np.exp(1j * phase), 1), 0.5 * (1.1 * np.sin(phase + 0.1) - 0.3))


def test_each_channel_keeps_a_share_of_the_one_converted_before_it() -> None:
    converter = Converter(1000.0, 1e-4, crosstalk=0.01)
    volts = np.random.default_rng(1).uniform(-4.0, 4.0, (6, 50))
    expected, held = np.empty_like(volts), volts[0, 0]
    for scan in range(50):
        for channel in range(6):
            held = volts[channel, scan] + 0.01 * (held - volts[channel, scan])
            expected[channel, scan] = held
    np.testing.assert_array_equal(converter.codes(volts), np.round(expected / converter.step_v))


def test_codes_are_the_voltage_in_steps_and_stop_at_the_range() -> None:
    converter = Converter(1000.0, 0.0, range_v=5.0)
    codes = converter.codes(np.array([[0.0, 1.0, 6.0, -6.0]] * 2))
    np.testing.assert_array_equal(codes[0], [0, round(32768 / 5.0), 32767, -32768])


@pytest.mark.parametrize(("largest_v", "range_v"), [(0.1, 5.0), (5.0, 5.0), (5.1, 10.0), (21.0, 40.0)])
def test_the_range_is_doubled_until_the_signals_fit(largest_v: float, range_v: float) -> None:
    assert Converter(1000.0, 0.0, range_v=5.0).for_signals(largest_v).range_v == range_v


def test_channels_are_converted_one_skew_after_the_other() -> None:
    converter = Converter(2000.0, 80e-6)
    np.testing.assert_allclose(converter.times_s(3, 5), [4e-4, 9e-4, 14e-4])


def test_noise_has_the_sizes_asked_for_and_slow_noise_is_slow() -> None:
    rng = np.random.default_rng(2)
    white = Noise(0.01).made(rng, 100_000, 20e3)
    assert white.std() == pytest.approx(0.01, rel=0.02)
    slow = Noise(0.0, flicker=0.004).made(rng, 100_000, 20e3)
    assert slow.std() == pytest.approx(0.004, rel=1e-9)
    power = np.abs(np.fft.rfft(slow)) ** 2
    frequency = np.fft.rfftfreq(slow.size, 1.0 / 20e3)
    decades = [power[(frequency >= f) & (frequency < 10.0 * f)].sum() for f in (1.0, 10.0, 100.0)]
    np.testing.assert_allclose(decades, decades[0], rtol=0.15)  # equal power in each decade: 1/f
    assert power[frequency > 1000.0].sum() < 1e-9 * power.sum()
    drift = Noise(0.0, drift=0.01).made(rng, 1000, 20e3)
    np.testing.assert_allclose(np.diff(drift, 2), 0.0, atol=1e-12)
    assert np.ptp(drift) > 1e-4
