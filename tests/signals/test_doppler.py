"""Doppler frequencies, interference, fading and what is no receiver, on signals whose frequencies are known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from benchmarks.world.broken.drops import drop_setup
from benchmarks.world.broken.garbage import make_garbage
from benchmarks.world.broken.reflecting import make_scene_drop
from support.words import words

from radargui.model.arrays import FloatArray
from radargui.model.front_end import channels_of
from radargui.signals.condition import condition
from radargui.signals.conditioned import Conditioned
from radargui.signals.doppler import Doppler, measure_doppler
from radargui.signals.echo import Echo, follow_echo
from radargui.signals.interference import find_interference, without_interference
from radargui.signals.receiver_check import check_receiver, is_worse_pair, same_channels
from radargui.signals.stretch import NoMotion

RATE = 20000.0
TIME = np.arange(40000) / RATE
NOISE = np.full(2, 0.01)


def echo(phase: FloatArray, gain: float = 1.0, eps: float = 0.0, amplitude: FloatArray | float = 1.0) -> FloatArray:
    z = amplitude * np.exp(1j * phase)
    pair = channels_of(z, z, gain, eps)
    return np.asarray(pair + 0.01 * np.random.default_rng(1).normal(size=pair.shape) + [[0.7], [-2.0]])


def usable(pair: FloatArray) -> np.ndarray:
    return np.ones(pair.shape, dtype=np.bool_)


def measured(pair: FloatArray) -> Doppler:
    return measure_doppler(pair, RATE, NOISE)


@pytest.mark.parametrize("doppler_hz", [25.0, 150.0, 187.0, 200.0, 400.0, 1990.0])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_steady_target_has_its_doppler_frequency_in_every_frame(doppler_hz: float, sign: float) -> None:
    found = measured(echo(sign * 2 * np.pi * doppler_hz * TIME, 1.4, 0.5))
    assert found.clear.all()
    assert found.frequency_hz == pytest.approx(np.full(found.centre.size, doppler_hz), abs=0.1 * found.resolution_hz)


def test_noise_has_no_line() -> None:
    found = measured(0.01 * np.random.default_rng(0).normal(size=(2, 40000)))
    assert not found.clear.any()
    assert not found.mixed.any()
    assert found.highest_hz is None


def test_the_lines_of_i_and_q_tell_gain_and_quadrature_error() -> None:
    found = measured(echo(2 * np.pi * 240.0 * TIME, 0.7, np.radians(27.0)))
    assert np.median(np.abs(found.q / found.i)) == pytest.approx(0.7, rel=0.002)
    assert 90.0 - np.median(np.abs(np.degrees(np.angle(found.q * found.i.conj())))) == pytest.approx(27.0, abs=0.2)


def test_two_equal_targets_are_mixed() -> None:
    pair = echo(2 * np.pi * 240.0 * TIME) + echo(-2 * np.pi * 700.0 * TIME)
    found = measured(pair)
    assert found.mixed.mean() > 0.9


def test_a_hum_and_a_tone_that_stand_are_found_and_taken_off_and_the_target_is_left() -> None:
    target = echo(2 * np.pi * 300.0 * TIME)
    tones = np.stack([np.cos(2 * np.pi * 50.03 * TIME), 0.6 * np.cos(2 * np.pi * 50.03 * TIME + 0.4)])
    tones += 0.5 * np.stack([np.cos(2 * np.pi * 874.4 * TIME), np.cos(2 * np.pi * 874.4 * TIME + 0.3)])
    clean, lines, _ = without_interference(target + tones, RATE, NOISE)
    assert sorted(lines) == pytest.approx([50.03, 874.4], abs=0.05)
    inside = slice(4000, -4000)
    assert np.abs(clean - target)[:, inside].max() < 0.08


@pytest.mark.parametrize("mains_hz", [49.95, 60.03])
def test_a_hum_that_turns_one_way_as_a_target_does_is_found_by_its_frequency(mains_hz: float) -> None:
    phase = 2 * np.pi * mains_hz * TIME
    hum = 2.0 * np.stack([np.cos(phase), 0.9 * np.sin(phase + 0.1)])
    clean, lines, _ = without_interference(echo(2 * np.pi * 300.0 * TIME) + hum, RATE, NOISE)
    assert lines == pytest.approx([mains_hz], abs=0.05)
    assert np.abs(clean - echo(2 * np.pi * 300.0 * TIME))[:, 4000:-4000].max() < 0.08
    assert find_interference(echo(2 * np.pi * (mains_hz + 1.0) * TIME), RATE, NOISE) == ()
    # a target that passes there again and again
    swinging = 30.0 * np.sin(2 * np.pi * 1.3 * TIME)
    assert find_interference(echo(2 * np.pi * (mains_hz * TIME + swinging)), RATE, NOISE) == ()


@pytest.mark.parametrize("speed", ["steady", "to and fro"])
def test_a_target_is_no_standing_line(speed: str) -> None:
    turn = 300.0 * TIME if speed == "steady" else 300.0 * np.abs((TIME % 1.0) - 0.5)
    assert find_interference(echo(2 * np.pi * turn, 1.6, np.radians(35.0)), RATE, NOISE) == ()


def followed(pair: FloatArray) -> Echo:
    found = follow_echo(pair, usable(pair), NOISE, measured(pair))
    assert found is not None
    return found


def test_an_echo_that_sinks_into_the_noise_is_lost_and_one_that_turns_round_is_not() -> None:
    beam = np.clip(1.5 * np.cos(2 * np.pi * TIME / 2.0) ** 2 - 0.4, 0.0, 1.0)
    leads = followed(echo(2 * np.pi * 300.0 * TIME, amplitude=beam)).leads
    assert leads[beam < 0.02].mean() < 0.05
    assert leads[beam > 0.5].mean() > 0.98
    assert followed(echo(2 * np.pi * 300.0 * np.abs(TIME - 1.0))).leads.mean() > 0.98


def test_a_tone_that_is_left_where_the_echo_fades_does_not_lead() -> None:
    beam = np.where(np.abs(TIME - 1.0) < 0.3, 0.0, 1.0)
    tone = 0.3 * np.stack([np.cos(2 * np.pi * 290.0 * TIME), np.cos(2 * np.pi * 290.0 * TIME + 0.4)])
    found = followed(echo(2 * np.pi * 300.0 * TIME, 0.8, 0.3, beam) + tone)
    assert found.leads[np.abs(TIME - 1.0) < 0.2].mean() < 0.05
    assert found.leads[np.abs(TIME - 1.0) > 0.4].mean() > 0.95


def test_what_is_wrong_with_a_receiver_is_named() -> None:
    good = echo(2 * np.pi * 240.0 * TIME)
    other = echo(2 * np.pi * 333.0 * TIME)
    noise = 0.01 * np.random.default_rng(5).normal(size=TIME.size)
    cases = {
        "shows nothing of the motion": np.stack([good[0], noise]),
        "one signal on both": np.stack([good[0], 1.0 - good[0] + noise]),
        "0 degrees apart": np.stack([good[0], 1.2 * good[0] + noise]),
        "do not belong together": np.stack([good[0], other[1]]),
    }
    for told, pair in cases.items():
        assert told in words(check_receiver(measured(pair), pair, NOISE, usable(pair))), told
    clipped = usable(good)
    clipped[0, ::3] = False
    assert "33 % of its samples" in words(check_receiver(measured(good), good, NOISE, clipped))


def test_white_noise_that_comes_and_goes_is_no_echo() -> None:
    noise = np.random.default_rng(3).normal(size=(2, TIME.size))
    assert "no echo" in words(check_receiver(measured(noise), noise, NOISE, usable(noise)))
    drowned = noise + echo(2 * np.pi * 240.0 * TIME, amplitude=0.45)
    assert check_receiver(measure_doppler(drowned, RATE, np.ones(2)), drowned, np.ones(2), usable(drowned)) is None


def test_what_tones_leave_at_both_ends_is_no_motion() -> None:
    setup, recording = drop_setup(3), make_garbage(13, "sinusoids")
    found = condition(recording, setup)
    assert isinstance(found, NoMotion)
    assert found.finding.text.startswith("nothing but a hum or tones (242, 226,")


def test_one_cable_on_two_inputs_is_found() -> None:
    first, second = echo(2 * np.pi * 240.0 * TIME), echo(2 * np.pi * 250.0 * TIME + 1.0)
    no_rest = np.zeros((4, 0))
    assert same_channels(np.concatenate([first, second]), np.full(4, 0.01), no_rest) == ()
    second[1] = first[0] + 0.01 * np.random.default_rng(9).normal(size=TIME.size)
    assert same_channels(np.concatenate([first, second]), np.full(4, 0.01), no_rest) == ((0, 3),)


@pytest.mark.parametrize("snr_db", [40.0, 60.0, 80.0])
@pytest.mark.parametrize("delay_s", [0.0, 5e-6])
def test_receivers_around_a_fall_on_the_axis_are_told_from_one_cable_by_their_noise(
    snr_db: float, delay_s: float
) -> None:
    """All show the same wave, and a multiplexer's delay parts them by more than noise does."""
    delays = delay_s * np.arange(4)[:, None]
    phase = 2 * np.pi * 180.0 * (np.maximum(TIME + delays - 0.5, 0.0)) ** 2
    sigma = np.sqrt(0.5 * 10.0 ** (-snr_db / 10.0))
    noise = sigma * np.random.default_rng(0).normal(size=phase.shape)
    wave = np.where((np.arange(4) % 2 == 0)[:, None], np.cos(phase), np.sin(phase))
    rest, moving = slice(0, 10000), slice(10000, None)

    def told(volts: FloatArray) -> tuple[tuple[int, int], ...]:
        return same_channels(volts[:, moving], np.full(4, sigma), volts[:, rest])

    assert told(wave + noise) == ()
    doubled = wave + noise
    doubled[2] = wave[2] + noise[0]
    assert told(doubled) == ((0, 2),)


def test_of_two_receivers_with_one_cable_the_one_whose_i_and_q_are_no_pair_is_named() -> None:
    good, tilted = (measured(echo(2 * np.pi * 240.0 * TIME, 1.0, np.radians(eps))) for eps in (5.0, 40.0))
    assert is_worse_pair(tilted, good)
    assert not is_worse_pair(good, tilted)
    assert not is_worse_pair(tilted, tilted)
    assert not is_worse_pair(measured(echo(0.0 * TIME)), good)


@pytest.mark.parametrize("phase_sign", [1, -1])
def test_a_cable_on_the_q_of_another_receiver_is_found_however_q_is_wired(phase_sign: int) -> None:
    drop = next(
        drop
        for seed in range(20)
        if (drop := make_scene_drop(seed, "whole", 3, "generic")).setup.radar.phase_sign == phase_sign
    )
    raw = drop.recording.raw.copy()
    raw[0] = raw[3]
    found = condition(replace(drop.recording, raw=raw), drop.setup)
    assert isinstance(found, Conditioned)
    assert words(found.faults[0]) == "I1 shows what Q2 shows: one cable on both"
    assert not found.faults[2]
