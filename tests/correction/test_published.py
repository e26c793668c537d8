"""The published correction, step by step, on signals whose mismatch is known."""

from __future__ import annotations

import numpy as np
import pytest
from support.drops import Drop

from radargui.correction.published import (
    correct_published,
    find_extremes,
    find_zero_crossings,
    local_scale,
    motion_turns,
    smooth,
)
from radargui.model.arrays import FloatArray
from radargui.model.errors import ProcessingError
from radargui.model.result import Segment

RATE = 20000.0


def sweep(seconds: float = 1.0) -> tuple[FloatArray, FloatArray]:
    """Time, and a phase that turns one way ever faster, 40 fringes in all."""
    time = np.arange(round(seconds * RATE)) / RATE
    return time, 2 * np.pi * 40 * (0.3 * time + 0.7 * time**2)


def test_each_turn_of_the_phase_has_one_peak_and_one_valley() -> None:
    time, phase = sweep()
    noisy = np.cos(phase) + np.random.default_rng(0).normal(0, 0.02, time.size)
    segment = Segment(0, time.size, 0, 0)
    peaks, valleys = find_extremes(smooth(noisy, RATE), segment)
    true_peaks = np.interp(2 * np.pi * np.arange(1, 40), phase, np.arange(time.size))
    true_valleys = np.interp(np.pi + 2 * np.pi * np.arange(40), phase, np.arange(time.size))
    assert peaks.size == 39
    assert valleys.size == 40
    assert phase[peaks] == pytest.approx(phase[np.round(true_peaks).astype(int)], abs=0.25)
    assert phase[valleys] == pytest.approx(phase[np.round(true_valleys).astype(int)], abs=0.25)


def test_extremes_follow_an_amplitude_that_falls_to_a_fifth() -> None:
    time, phase = sweep()
    segment = Segment(0, time.size, 0, 0)
    peaks, valleys = find_extremes((1 - 0.8 * time) * np.cos(phase), segment)
    assert (peaks.size, valleys.size) == (39, 40)


def test_zero_crossings_lie_between_extremes_and_noise_adds_none() -> None:
    time, phase = sweep()
    noisy = np.cos(phase) + np.random.default_rng(0).normal(0, 0.1, time.size)
    segment = Segment(0, time.size, 0, 0)
    peaks, valleys = find_extremes(smooth(noisy, RATE), segment)
    crossings = find_zero_crossings(noisy, peaks, valleys)
    assert crossings.size == peaks.size + valleys.size - 1
    assert np.abs(np.cos(phase[crossings])).max() < 0.4


def test_a_piece_whose_extreme_is_no_extreme_of_the_circle_takes_the_scale_between_its_neighbours() -> None:
    time, phase = sweep()
    x = (1 - 0.5 * time) * np.cos(phase)
    peaks, valleys = find_extremes(x, Segment(0, time.size, 0, 0))
    both = np.sort(np.concatenate([peaks, valleys]))
    crossings = find_zero_crossings(x, peaks, valleys)
    scale = local_scale(x, crossings, both)
    without = local_scale(x, crossings, np.delete(both, 20))
    assert without[both[20]] == pytest.approx(0.5 * (scale[both[19]] + scale[both[21]]), rel=1e-12)
    assert np.delete(without, slice(crossings[19], crossings[20])) == pytest.approx(
        np.delete(scale, slice(crossings[19], crossings[20]))
    )


def test_a_bounce_makes_no_extreme_of_the_circle() -> None:
    drop = Drop(rate_hz=RATE)
    phase = -2 * np.pi * 1.77 * drop.height(drop.time_s) / 0.03 + 0.7
    z = np.stack([np.cos(phase), np.sin(phase)])
    segment = Segment(round(drop.rest_s * RATE), round(drop.impact_s[4] * RATE), 0, 0)
    turning = motion_turns(smooth(z, RATE), RATE, segment)
    impact = np.round(drop.impact_s[:4] * RATE).astype(int)
    away = (np.abs(z[:, impact]) < 0.85).all(axis=0)
    assert away.sum() >= 2
    assert turning[impact[away]].all()
    apex = 0.5 * (drop.impact_s[:2] + drop.impact_s[1:3])
    assert turning[np.round(apex * RATE).astype(int)].all()
    falling = slice(round((drop.rest_s + 0.08) * RATE), round((drop.impact_s[0] - 0.01) * RATE))
    assert not turning[falling].any()


@pytest.mark.parametrize("start_rad", np.linspace(0, 2 * np.pi, 7)[:-1])
def test_a_drop_with_offset_and_gain_error_comes_back_to_the_circle(start_rad: float) -> None:
    drop = Drop(rate_hz=RATE)
    phase = -2 * np.pi * 1.77 * drop.height(drop.time_s) / 0.03 + start_rad
    volts = np.stack([0.4 + 1.0 * np.cos(phase), -0.2 + 1.2 * np.sin(phase)])
    volts += np.random.default_rng(1).normal(0, 0.005, volts.shape)
    segment = Segment(round(drop.rest_s * RATE), round(drop.impact_s[-1] * RATE), 0, 0)
    iq, steps = correct_published(volts, RATE, segment)
    wrong = np.angle(np.exp(1j * (np.arctan2(iq[1], iq[0]) - phase)))
    to_second = slice(segment.first, round(drop.impact_s[1] * RATE))
    assert np.sqrt(np.mean(wrong[to_second] ** 2)) < 0.06
    assert steps.i.peaks.size > 10
    assert steps.q.bias.shape == steps.q.scale.shape == (volts.shape[1],)


def test_motion_of_less_than_a_fringe_is_refused_with_a_reason() -> None:
    time = np.arange(4000) / RATE
    phase = 1.5 * np.sin(2 * np.pi * 3 * time)
    with pytest.raises(ProcessingError, match="peaks and"):
        correct_published(np.stack([np.cos(phase), np.sin(phase)])[:, :1000], RATE, Segment(0, 1000, 0, 0))
