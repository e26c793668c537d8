"""Conditioning: gaps, rest, sign and units of what every correction starts from."""

from __future__ import annotations

import numpy as np
import pytest
from support.drops import Drop

from radargui.model.arrays import FloatArray
from radargui.model.finding import refuse
from radargui.model.recording import Digitisation, Gap, Recording
from radargui.model.setup import Setup
from radargui.signals.condition import condition
from radargui.signals.conditioned import Conditioned
from radargui.signals.stretch import NoMotion

RATE = 20000.0


def setup_of(sign: int = 1, skew_s: float | None = None) -> Setup:
    plain: dict[str, object] = {
        "schema": 1,
        "radar": {"phase_sign": sign},
        "transmitter": {"distance_m": 0.7},
        "receiver": [{"tilt_deg": 40.0, "azimuth_deg": 90.0, "distance_m": 0.7}],
    }
    if skew_s is not None:
        plain["daq"] = {"channel_skew_s": skew_s}
    return Setup.model_validate(plain)


def recording_of(volts: FloatArray, rate_hz: float = RATE, **more: object) -> Recording:
    return Recording("made", volts, Digitisation(("I1", "Q1"), rate_hz), **more)  # type: ignore[arg-type]


def turning(phase: FloatArray, noise: float = 0.005, seed: int = 0) -> FloatArray:
    pair = np.stack([np.cos(phase), np.sin(phase)])
    return np.asarray(pair + noise * np.random.default_rng(seed).normal(size=pair.shape))


def drop_volts() -> tuple[Drop, FloatArray]:
    drop = Drop(rate_hz=RATE)
    return drop, turning(-2 * np.pi * 1.77 * drop.height(drop.time_s) / 0.03)


def conditioned(recording: Recording, setup: Setup | None = None) -> Conditioned:
    found = condition(recording, setup or setup_of())
    assert isinstance(found, Conditioned)
    return found


def test_a_drop_rests_until_a_little_before_its_release() -> None:
    drop, volts = drop_volts()
    found = conditioned(recording_of(volts))
    assert found.segment.has_rest
    assert found.onset_s == pytest.approx(drop.rest_s, abs=0.03)
    assert 0.5 * drop.rest_s < found.segment.rest_last / RATE < drop.rest_s


def test_noise_alone_is_no_motion() -> None:
    found = condition(recording_of(np.random.default_rng(0).normal(0.0, 0.01, (2, 20000))), setup_of())
    assert found == NoMotion(refuse("nothing_moves"))


def test_a_few_samples_are_no_motion() -> None:
    assert isinstance(condition(recording_of(turning(np.linspace(0, 9, 40))), setup_of()), NoMotion)


@pytest.mark.parametrize("doppler_hz", [150.0, 187.0, 200.0, 371.0, 400.0, 600.0])
def test_a_target_in_motion_from_the_first_sample_on_has_no_rest_whatever_its_doppler(doppler_hz: float) -> None:
    found = conditioned(recording_of(turning(2 * np.pi * doppler_hz * np.arange(20000) / RATE)))
    assert not found.segment.has_rest
    assert found.segment == found.segment.__class__(0, 20000, 0, 0)
    assert found.onset_s == -np.inf


def test_the_stretch_with_a_rest_before_its_motion_is_used() -> None:
    drop, volts = drop_volts()
    cut = round((drop.rest_s + 0.1) * RATE)
    # first a motion without rest, then, after lost samples, the whole drop
    both = np.concatenate([volts[:, cut:], volts], axis=1)
    first = volts.shape[1] - cut
    found = conditioned(recording_of(both, gaps=(Gap(first, 500, "lost"),)))
    assert found.samples == slice(first, both.shape[1])
    assert found.time_s[0] == pytest.approx((first + 500) / RATE)
    assert found.segment.has_rest


def test_q_is_inverted_once_where_the_wiring_inverts_it() -> None:
    _, volts = drop_volts()
    volts[1] *= -1.0
    found = conditioned(recording_of(volts), setup_of(-1))
    np.testing.assert_array_equal(found.volts[1], -volts[1])
    np.testing.assert_array_equal(found.volts[0], volts[0])


def test_the_multiplexers_delay_is_the_setups_where_the_samples_come_without_one() -> None:
    _, volts = drop_volts()
    found = conditioned(recording_of(volts), setup_of(skew_s=5e-6))
    np.testing.assert_allclose(found.delay_s, [0.0, 5e-6])


def test_samples_that_are_not_numbers_are_held_and_marked() -> None:
    _, volts = drop_volts()
    volts[1, 9000:9010] = np.nan
    found = conditioned(recording_of(volts))
    assert np.isfinite(found.volts).all()
    assert not found.usable[1, 9000:9010].any()
    assert found.usable.sum() == volts.size - 10
    assert found.unusable_share == pytest.approx([10 / volts.shape[1]])


def test_the_delay_of_the_multiplexer_is_taken_off_for_every_correction_alike() -> None:
    drop, skew_s = Drop(rate_hz=RATE), 2e-5

    def phase_at(time_s: FloatArray) -> FloatArray:
        return np.asarray(-2 * np.pi * 1.77 * drop.height(time_s) / 0.03)

    late = np.stack([np.cos(phase_at(drop.time_s)), np.sin(phase_at(drop.time_s + skew_s))])
    late += 1e-4 * np.random.default_rng(0).normal(size=late.shape)
    found = conditioned(recording_of(late), setup_of(skew_s=skew_s))
    falling = slice(found.segment.rest_last, round(drop.impact_s[0] * RATE) - 50)
    wanted = np.sin(phase_at(drop.time_s))[falling]
    assert np.abs(found.volts[1, falling] - wanted).max() > 1e-2
    assert found.at_one_time_v[1, falling] == pytest.approx(wanted, abs=1e-3)
    assert found.of_receivers([0]).at_one_time_v == pytest.approx(found.at_one_time_v)
