"""The Doppler band: as few samples as hold the motion, what cannot be used told, times of the means."""

from __future__ import annotations

import numpy as np
import pytest
from support.changed import changed
from support.small_setups import quick_setup

from radargui.model.arrays import FloatArray
from radargui.model.recording import Digitisation, Gap, Recording, iq_names
from radargui.signals.band import JOINT, SETTINGS, band_signals

RATE_HZ = 200_000.0
COUNT = 100_003
SETUP = changed(quick_setup(), floor={"height_m": None})
ALL = slice(0, COUNT)


def circling(doppler_hz: float, noise: float = 0.01) -> FloatArray:
    phase = 2.0 * np.pi * doppler_hz * np.arange(COUNT) / RATE_HZ
    volts = np.tile(np.stack([np.cos(phase), np.sin(phase)]), (3, 1))
    return np.asarray(volts + noise * np.random.default_rng(1).standard_normal(volts.shape))


def recording_of(volts: FloatArray, **more: object) -> Recording:
    return Recording("made", volts, Digitisation(iq_names(3), RATE_HZ), **more)  # type: ignore[arg-type]


@pytest.mark.parametrize("doppler_hz", [20.0, 150.0, 1000.0, 4000.0])
def test_the_rate_holds_the_fastest_line_with_its_margin(doppler_hz: float) -> None:
    found = band_signals(recording_of(circling(doppler_hz)), ALL, 0, SETUP)
    rate_hz = RATE_HZ / found.size
    assert rate_hz >= max(SETTINGS.least_hz, 0.97 * SETTINGS.per_fringe * doppler_hz)
    # not much higher either: whatever comes after costs by the sample
    assert found.size >= min(6, 0.5 * RATE_HZ / max(SETTINGS.least_hz, SETTINGS.per_fringe * doppler_hz))
    radius = np.hypot(*found.volts[:2])
    assert radius.mean() == pytest.approx(1.0, abs=0.003)


def test_a_short_fast_moment_in_a_long_rest_is_found() -> None:
    volts = np.full((6, COUNT), 0.3) + 0.001 * np.random.default_rng(2).standard_normal((6, COUNT))
    moment = slice(60_000, 66_000)
    volts[:, moment] = circling(1500.0)[:, moment]
    found = band_signals(recording_of(volts), ALL, 0, SETUP)
    assert RATE_HZ / found.size >= 0.97 * SETTINGS.per_fringe * 1500.0


def test_a_fall_that_the_setup_tells_is_held_though_the_samples_show_nothing() -> None:
    volts = 0.01 * np.random.default_rng(3).standard_normal((6, COUNT))
    deep = changed(SETUP, floor={"height_m": -9.0})
    speed_m_s = np.sqrt(2.0 * 9.80665 * (SETUP.tracer.release_position_m[2] + 9.0))
    found = band_signals(recording_of(volts), ALL, 0, deep)
    assert RATE_HZ / found.size >= SETTINGS.per_fringe * 2.0 * speed_m_s / SETUP.radar.wavelength_m
    assert found.size < band_signals(recording_of(volts), ALL, 0, changed(SETUP, floor={"height_m": -0.1})).size


def test_the_joint_estimate_keeps_more_and_no_correction_keeps_all() -> None:
    recording = recording_of(circling(100.0))
    joint = band_signals(recording, ALL, 0, changed(SETUP, processing={"correction": "joint"}))
    assert RATE_HZ / joint.size >= JOINT.least_hz
    assert band_signals(recording, ALL, 0, changed(SETUP, processing={"correction": "none"})).size == 1


def test_a_mean_of_a_sample_that_is_no_number_or_clipped_is_not_usable() -> None:
    volts = circling(100.0)
    volts[2, 50_000] = np.nan
    found = band_signals(recording_of(volts), ALL, 0, SETUP)
    assert np.isfinite(found.volts).all()
    assert np.flatnonzero(~found.usable[2]).tolist() == [50_000 // found.size]
    assert found.usable[[0, 1, 3, 4, 5]].all()
    codes = np.round(10_000 * circling(100.0)).astype(np.int16)
    codes[5, 70_001] = 32767
    coded = Digitisation(iq_names(3), RATE_HZ, ((0.0, 1e-4),) * 6)
    found = band_signals(Recording("made", codes, coded), ALL, 0, SETUP)
    assert np.flatnonzero(~found.usable[5]).tolist() == [70_001 // found.size]


def test_times_are_the_means_of_the_samples_times_also_after_a_gap() -> None:
    recording = recording_of(circling(100.0), gaps=(Gap(40_000, 17),))
    after = slice(40_000, COUNT)
    found, own = band_signals(recording, after, 40_017, SETUP), recording.time_s()[after]
    assert found.size >= 2
    count = own.size // found.size
    expected = own[: count * found.size].reshape(count, found.size).mean(axis=1)
    assert np.allclose(found.time_s, expected, rtol=0.0, atol=1e-12)
    assert found.rate_hz == pytest.approx(1.0 / (found.time_s[1] - found.time_s[0]))
