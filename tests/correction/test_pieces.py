"""Pieces of a path, phases held against spectra, and the echo in its Doppler band."""

from __future__ import annotations

import numpy as np
import pytest
from signals.test_condition import conditioned, recording_of, setup_of

from radargui.correction.agreement import strays
from radargui.correction.phase import join_pieces
from radargui.model.front_end import channels_of
from radargui.signals.doppler import measure_doppler
from radargui.signals.echo import follow_echo
from radargui.signals.follows import follows, missed_frames
from radargui.signals.spectral_front_end import front_end_of

RATE = 20000.0
TIME = np.arange(40000) / RATE
PHASE = 2 * np.pi * 240.0 * TIME


def wrapped(phase: np.ndarray) -> np.ndarray:
    return np.asarray(np.unwrap(np.angle(np.exp(1j * phase))))


def test_a_hole_shorter_than_the_motion_can_change_in_is_bridged_with_its_turns() -> None:
    valid = np.ones((1, TIME.size), dtype=np.bool_)
    valid[0, 20000:20100] = False  # 5 ms, more than a turn
    phase = np.where(valid, PHASE, np.nan)
    phase[0, 20100:] -= 2 * np.pi
    joined, piece = join_pieces(phase, valid, RATE)
    assert not piece.any()
    np.testing.assert_allclose(joined[0, 20100:], PHASE[20100:], atol=1e-6)


@pytest.mark.parametrize("samples", [400, 4000])
def test_after_a_longer_hole_a_new_piece_begins(samples: int) -> None:
    valid = np.ones((1, TIME.size), dtype=np.bool_)
    valid[0, 20000 : 20000 + samples] = False
    _, piece = join_pieces(np.where(valid, PHASE, np.nan), valid, RATE)
    assert piece[19999] == 0
    assert piece[20000 + samples] == 1


def test_a_phase_that_stands_still_does_not_follow_a_signal_that_turns() -> None:
    pair = np.stack([np.cos(PHASE), np.sin(PHASE)]) + 0.01 * np.random.default_rng(0).normal(size=(2, TIME.size))
    doppler = measure_doppler(pair, RATE, np.full(2, 0.01))
    everywhere = np.ones(TIME.size, dtype=np.bool_)
    assert follows(*missed_frames(PHASE, everywhere, doppler))
    missed, share = missed_frames(np.zeros(TIME.size), everywhere, doppler)
    assert share == 1.0
    assert not follows(missed, share)


def swinging() -> tuple[np.ndarray, np.ndarray]:
    """Return times of 3.4 s and the phase of a pendulum that turns round once in the middle half of a frame."""
    time = np.arange(6800) / 2000.0
    return time, 8.0 * np.sin(2 * np.pi * time / 0.6)


def test_a_phase_that_swings_follows_a_line_that_it_has_for_a_moment() -> None:
    time, phase = swinging()
    pair = np.stack([np.cos(phase), np.sin(phase)]) + 0.01 * np.random.default_rng(0).normal(size=(2, time.size))
    doppler = measure_doppler(pair, 2000.0, np.full(2, 0.01))
    assert doppler.steady.sum() > 3
    missed, share = missed_frames(phase, np.ones(time.size, dtype=np.bool_), doppler)
    assert share < 0.1
    assert follows(missed, share)


def test_a_phase_that_an_offset_makes_waver_does_not_follow() -> None:
    time = np.arange(6800) / 2000.0
    turning = 2 * np.pi * 9.0 * time
    pair = np.stack([np.cos(turning), np.sin(turning)]) + 0.01 * np.random.default_rng(0).normal(size=(2, time.size))
    doppler = measure_doppler(pair, 2000.0, np.full(2, 0.01))
    # as far to and fro as it can without going round
    wavering = np.angle(1.02 + np.exp(1j * turning))
    missed, share = missed_frames(np.unwrap(wavering), np.ones(time.size, dtype=np.bool_), doppler)
    assert not follows(missed, share)


def test_in_its_band_a_target_is_followed_above_an_offset_that_swings_as_far_as_it() -> None:
    z = np.exp(1j * PHASE)
    slow = 0.9 * np.sin(2 * np.pi * 3.0 * TIME)
    pair = channels_of(z, z, 0.75, np.radians(26.0)) + np.stack([slow, 0.8 * slow + 2.0])
    pair += 0.01 * np.random.default_rng(0).normal(size=pair.shape)
    found = conditioned(recording_of(pair), setup_of())
    echo = found.echoes[0]
    assert echo is not None
    assert echo.front_end.gain_ratio == pytest.approx(0.75, abs=2 * echo.front_end.u_gain_ratio)
    assert echo.front_end.quadrature_error_deg == pytest.approx(26.0, abs=2 * echo.front_end.u_quadrature_error_deg)
    inside = slice(2000, -2000)
    assert echo.leads[inside].all()
    away = echo.phase_rad[inside] - PHASE[inside]
    assert np.ptp(away) < 0.2


def test_a_target_that_hardly_moves_has_no_band() -> None:
    pair = np.stack([np.cos(2.0 * TIME), np.sin(2.0 * TIME)]) + 0.01 * np.random.default_rng(0).normal(size=(2, 40000))
    assert front_end_of(measure_doppler(pair, RATE, np.full(2, 0.01))) is None


def test_a_second_reflection_at_twice_the_frequency_moves_no_front_end() -> None:
    z = np.exp(1j * PHASE) + 0.1 * np.exp(2j * PHASE + 1j)
    pair = channels_of(z, z, 0.76, np.radians(25.0)) + 0.001 * np.random.default_rng(2).normal(size=(2, TIME.size))
    found = front_end_of(measure_doppler(pair, RATE, np.full(2, 0.001)))
    assert found is not None
    assert found.gain_ratio == pytest.approx(0.76, rel=0.002)
    assert found.quadrature_error_deg == pytest.approx(25.0, abs=0.1)


def test_a_path_that_leaves_its_echo_strays_there_and_only_there() -> None:
    pair = np.stack([np.cos(PHASE), np.sin(PHASE)]) + 0.01 * np.random.default_rng(0).normal(size=(2, TIME.size))
    noise, everywhere = np.full(2, 0.01), np.ones(TIME.size, dtype=np.bool_)
    echo = follow_echo(pair, np.ones(pair.shape, dtype=np.bool_), noise, measure_doppler(pair, RATE, noise))
    assert echo is not None
    assert not strays(PHASE, everywhere, echo, RATE).any()
    lost = np.where((TIME > 1.0) & (TIME < 1.2), PHASE[20000], np.where(TIME < 1.1, PHASE, PHASE - PHASE[24000]))
    found = strays(lost, everywhere, echo, RATE)
    assert found[20400:23600].all()
    assert not found[:19000].any()
    assert not found[25000:].any()
