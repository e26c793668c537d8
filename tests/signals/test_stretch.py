"""A stretch between gaps: hum and tones are taken off, and a stretch that only they move hides no other."""

from __future__ import annotations

import numpy as np
import pytest
from support.drops import Drop

from radargui.model.arrays import FloatArray
from radargui.model.recording import Digitisation, Gap, Recording
from radargui.model.setup import Setup
from radargui.signals.condition import condition
from radargui.signals.conditioned import Conditioned
from radargui.signals.stretch import NoMotion, Stretch, find_stretch

RATE = 20000.0
SETUP = Setup.model_validate(
    {
        "schema": 1,
        "radar": {"phase_sign": 1},
        "transmitter": {"distance_m": 0.7},
        "receiver": [{"tilt_deg": 40.0, "azimuth_deg": 90.0, "distance_m": 0.7}],
    }
)
NOISE_V = 0.005


def drop_of(hum_v: float) -> FloatArray:
    """Return I and Q of a drop after a rest of a second, with a hum in I alone."""
    drop = Drop(rate_hz=RATE, rest_s=1.0)
    phase = -2.0 * np.pi * 1.77 * drop.height(drop.time_s) / 0.03
    pair = np.stack([np.cos(phase), np.sin(phase)])
    pair[0] += hum_v * np.cos(2.0 * np.pi * 50.0 * drop.time_s)
    return np.asarray(pair + NOISE_V * np.random.default_rng(3).normal(size=pair.shape))


def hum_alone(seconds: float) -> FloatArray:
    time = np.arange(round(seconds * RATE)) / RATE
    pair = np.stack([1.0 + np.cos(2.0 * np.pi * 50.0 * time), np.zeros_like(time)])
    return np.asarray(pair + NOISE_V * np.random.default_rng(4).normal(size=pair.shape))


def recording_of(volts: FloatArray, *gaps: Gap) -> Recording:
    return Recording("made", volts, Digitisation(("I1", "Q1"), RATE), gaps=gaps)


def test_a_hum_measured_at_rest_is_taken_off_the_whole_stretch() -> None:
    volts = drop_of(0.2)
    found = find_stretch(recording_of(volts), slice(0, volts.shape[1]), 0, SETUP)
    assert isinstance(found, Stretch)
    assert found.hum is not None
    assert found.hum.frequency_hz == pytest.approx(50.0, abs=0.01)
    rest = slice(0, round(0.9 * RATE))
    # the hum had 28 times the noise
    assert found.signals.volts[0, rest].std() == pytest.approx(NOISE_V, rel=0.1)
    assert found.motion.first == pytest.approx(RATE, abs=0.06 * RATE)


def test_times_count_from_the_first_sample_of_all() -> None:
    volts = drop_of(0.0)
    found = find_stretch(recording_of(volts), slice(100, volts.shape[1]), 350, SETUP)
    assert isinstance(found, Stretch)
    np.testing.assert_allclose(found.signals.time_s[:2], [350 / RATE, 351 / RATE])


def test_a_hum_of_the_mains_with_harmonics_and_drift_is_no_motion() -> None:
    rng = np.random.default_rng(1)
    time = np.arange(40000) / RATE
    phase = rng.uniform(0, 2 * np.pi, (2, 3))
    hum = sum(0.1 / k * np.sin(2 * np.pi * 50 * k * time + phase[:, k - 1 : k]) for k in (1, 2, 3))
    volts = hum + 0.05 * np.sin(2 * np.pi * 0.05 * time) + rng.normal(0, 0.003, (2, 40000))
    found = find_stretch(recording_of(np.asarray(volts)), slice(0, 40000), 0, SETUP)
    assert isinstance(found, NoMotion)
    assert found.finding.code == "tones_only"


def test_a_stretch_that_only_tones_move_does_not_hide_the_drop_in_another() -> None:
    hum, drop = hum_alone(4.0), drop_of(0.0)
    gap = Gap(hum.shape[1], 500, "lost")
    alone = condition(recording_of(hum), SETUP)
    assert isinstance(alone, NoMotion)
    found = condition(recording_of(np.concatenate([hum, drop], axis=1), gap), SETUP)
    assert isinstance(found, Conditioned)
    assert found.samples.start == hum.shape[1]
    quiet = NOISE_V * np.random.default_rng(6).normal(size=(2, 20000))
    # of two that do not move the one with a hum is told
    both = condition(recording_of(np.concatenate([quiet, hum], axis=1), Gap(20000, 500, "lost")), SETUP)
    assert both == alone
