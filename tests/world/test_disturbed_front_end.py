"""Faults of the front end and hum: each does to the samples what its name says, and to the others nothing."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from benchmarks.world.disturbed.draw import disturbed
from benchmarks.world.disturbed.front_end import Clip, Contact, Oscillator, Slip, StuckBit
from benchmarks.world.disturbed.interference import Mains
from benchmarks.world.scene import Scene

SEEDS = range(5)
TIME_S = np.arange(0.0, 1.0, 1e-4)


def made(which: str, seed: int) -> tuple[Scene, Any]:
    scene = disturbed(which, seed, rate_hz=2000.0, skew_s=0.0, walls=0)
    (one,) = scene.disturbances
    return scene, one


def ramps() -> np.ndarray[Any, np.dtype[np.int16]]:
    return (np.arange(40)[None] + 100 * np.arange(6)[:, None]).astype(np.int16)


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("variant", ["jump", "drift"])
def test_the_oscillator_turns_the_echo_by_the_wavenumber_times_the_way_beyond_the_mixers(
    variant: str, seed: int
) -> None:
    scene, one = made(f"steps/{variant}", seed)
    assert isinstance(one, Oscillator)
    place = np.repeat(scene.drop.position(np.zeros(1)), TIME_S.size, axis=1)
    quiet = replace(one, leaks=np.zeros(3, complex))
    turned = np.angle(quiet.echo(1, TIME_S, place, np.ones(TIME_S.size, complex)))
    assert np.all(turned[one.begin_s > TIME_S] == 0.0)
    last = np.array([one.begin_s + one.lasts_s])
    assert 1e-6 <= abs(one.off(last)[0]) <= 1e-4
    way = scene.room.path_m(place[:, :1])[1, 0] - one.to_mixer_m
    np.testing.assert_allclose(turned, scene.room.sphere.wavenumber_rad_m * way * one.off(TIME_S), atol=1e-12)
    assert np.abs(one.echo(1, last, place[:, :1], np.zeros(1, complex))).max() > 0.0  # the direct wave turns too


@pytest.mark.parametrize("seed", SEEDS)
def test_a_loose_contact_drops_one_channel_for_a_while_and_a_lost_one_for_good(seed: int) -> None:
    for variant, longest_s in (("contact", 0.0601), ("lost", 2.0)):
        _, one = made(f"steps/{variant}", seed)
        assert isinstance(one, Contact)
        time_s = np.arange(0.0, 1.5, 1e-4)
        volts = np.array([one.volts(channel, time_s, np.ones(time_s.size), 1.0) for channel in range(6)])
        dropped = volts < 0.5
        assert np.flatnonzero(dropped.any(axis=1)).tolist() == [one.channel]
        assert 0.9e-3 < 1e-4 * dropped.sum() < longest_s
        assert dropped[one.channel, -1] == (variant == "lost")


def test_a_stuck_bit_is_the_same_in_every_code_after_it_stuck_negative_ones_too() -> None:
    codes = np.array([[0, 1, 4, 5, -1, -4, 32767, -32768]] * 2, dtype=np.int16)
    high, low = (StuckBit(1, 2, at, 1).codes(codes) for at in (1, 0))
    np.testing.assert_array_equal(high[0], codes[0])
    np.testing.assert_array_equal(high[1], [0, 5, 4, 5, -1, -4, 32767, -32764])
    np.testing.assert_array_equal(low[1], [0, 1, 0, 1, -5, -8, 32763, -32768])
    assert high.dtype == np.int16


@pytest.mark.parametrize("by", [1, -1])
def test_a_slipped_channel_tells_one_sample_twice_or_loses_one(by: int) -> None:
    codes = ramps()
    slipped = Slip(2, 10, by).codes(codes)
    others = [0, 1, 3, 4, 5]
    np.testing.assert_array_equal(slipped[others], codes[others])
    np.testing.assert_array_equal(slipped[2, :10], codes[2, :10])
    np.testing.assert_array_equal(slipped[2, 10:39], codes[2, 10 - by : 39 - by])
    assert (slipped[2, 10] == slipped[2, 9]) == (by == 1)


@pytest.mark.parametrize("side", [1, -1])
def test_a_stage_that_saturates_lets_a_twentieth_through_on_its_side_within_its_time(side: int) -> None:
    volts = side * np.linspace(0.0, 2.0, TIME_S.size)
    clip = Clip(4, 0.6, 0.9, side * 0.5, side)
    np.testing.assert_array_equal(clip.volts(3, TIME_S, volts, 2.0), volts)
    found = clip.volts(4, TIME_S, volts, 2.0)
    inside = (TIME_S >= 0.6) & (TIME_S < 0.9)
    np.testing.assert_array_equal(found[~inside], volts[~inside])
    np.testing.assert_allclose(found[inside], side * (1.0 + 0.05 * (np.abs(volts[inside]) - 1.0)))


@pytest.mark.parametrize("seed", SEEDS)
def test_hum_is_of_fifty_hertz_with_harmonics_and_changes_with_the_lamp(seed: int) -> None:
    _, one = made("mains/hum", seed)
    assert isinstance(one, Mains)
    steady = replace(one, switched_s=9.0)
    hum = steady.volts(1, TIME_S, np.zeros(TIME_S.size), 2.0)
    sizes = 2.0 * np.abs(np.fft.rfft(hum)) / hum.size
    orders = [50 * order for order, _ in one.harmonics]
    assert sizes[50] == pytest.approx(2.0 * abs(one.channels[1]), rel=0.05)
    assert sizes[orders].min() > 0.03 * sizes[50]
    assert 0.3 * 0.01 <= np.abs(one.channels).min() <= np.abs(one.channels).max() <= 0.1
    switched = replace(one, switched_s=0.5).volts(1, TIME_S, np.zeros(TIME_S.size), 2.0)
    late = TIME_S >= 0.5
    np.testing.assert_allclose(switched[late], one.factor * hum[late])
    np.testing.assert_array_equal(switched[~late], hum[~late])
    assert not 0.6 < one.factor < 1.5
