"""The echo of one receiver by itself: of two targets the weaker one is never taken for the stronger."""

import numpy as np
import pytest
from scipy.integrate import cumulative_trapezoid
from signals.test_condition import conditioned, recording_of, setup_of

from radargui.model.arrays import ComplexArray, FloatArray
from radargui.model.front_end import channels_of
from radargui.signals.doppler import measure_doppler
from radargui.signals.echo import Echo, follow_echo
from radargui.signals.followed import follow_receiver

RATE_HZ = 10000.0
TIME_S = np.arange(30000) / RATE_HZ
NOISE_V = 0.003


def pair_of(wave: ComplexArray) -> FloatArray:
    noise = NOISE_V * np.random.default_rng(3).normal(size=(2, wave.size))
    return np.stack([wave.real, wave.imag]) + noise


def turning(doppler_hz: FloatArray | float) -> ComplexArray:
    hz = np.broadcast_to(doppler_hz, TIME_S.shape)
    return np.asarray(np.exp(2j * np.pi * cumulative_trapezoid(hz, TIME_S, initial=0.0)))


def echo_of(wave: ComplexArray) -> Echo | None:
    pair_v, noise_v = pair_of(wave), np.full(2, NOISE_V)
    return follow_echo(
        pair_v, np.ones(pair_v.shape, dtype=np.bool_), noise_v, measure_doppler(pair_v, RATE_HZ, noise_v)
    )


@pytest.mark.parametrize("slow_hz", [12.0, 26.0])
def test_a_fast_target_below_a_stronger_slow_one_never_leads(slow_hz: float) -> None:
    swinging = 0.2 * turning(slow_hz * np.cos(2.0 * np.pi * 0.8 * TIME_S))
    found = conditioned(recording_of(pair_of(swinging + 0.05 * turning(-160.0)), RATE_HZ), setup_of())
    # not one sample: no echo is followed at all
    assert found.echoes[0] is None


def test_what_goes_on_weakly_where_the_target_stops_does_not_lead() -> None:
    stopping_hz = 345.0 * np.clip((1.6 - TIME_S) / 0.1, 0.0, 1.0)
    echo = echo_of(0.3 * turning(stopping_hz) + 0.05 * turning(352.0))
    assert echo is not None
    assert echo.leads[TIME_S < 1.4].all()
    assert not echo.leads[TIME_S > 1.8].any()


def test_a_target_that_fades_is_followed_down_to_a_tenth_and_up_again() -> None:
    strength = 0.55 + 0.45 * np.cos(2.0 * np.pi * TIME_S / 3.0)
    echo = echo_of(0.3 * strength * turning(345.0))
    assert echo is not None
    assert echo.leads.mean() > 0.99


@pytest.mark.parametrize("level_v", [0.30, 0.33])
def test_a_clipped_channel_is_filled_with_what_the_echo_shows_and_its_gain_holds_within_its_uncertainty(
    level_v: float,
) -> None:
    wave = 0.3 * turning(345.0 * np.cos(2.0 * np.pi * 0.4 * TIME_S))
    pair_v = np.asarray(channels_of(wave, wave, 1.2, np.radians(6.0)))
    pair_v = pair_v + NOISE_V * np.random.default_rng(3).normal(size=pair_v.shape)
    usable, clipped_v, noise_v = np.abs(pair_v) < level_v, np.clip(pair_v, -level_v, level_v), np.full(2, NOISE_V)
    _, filled = follow_receiver(clipped_v, usable, RATE_HZ, noise_v, ())
    as_it_is = follow_echo(clipped_v, usable, noise_v, measure_doppler(clipped_v, RATE_HZ, noise_v))
    assert filled is not None
    assert as_it_is is not None
    off = 1.2 - filled.front_end.gain_ratio
    assert 0.0 < off < 2.0 * filled.front_end.u_gain_ratio < 0.15
    assert off < 0.85 * (1.2 - as_it_is.front_end.gain_ratio)
    assert filled.front_end.quadrature_error_deg == pytest.approx(6.0, abs=0.2)
