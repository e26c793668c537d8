"""Noise, bins, maps and onset: the stages that adaptive and joint share."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import savgol_filter

from radargui.conditioning.noise import white_noise_v
from radargui.conditioning.onset import find_onset
from radargui.estimation.forward.bins import bin_by_fringe
from radargui.estimation.forward.position_map import make_basis
from radargui.estimation.motion_estimate import channel_qualities
from radargui.estimation.signals import ScaledSignals
from radargui.model.arrays import savitzky_golay
from radargui.model.front_end import FrontEnd


def signals_of(value: np.ndarray, rate: float) -> ScaledSignals:
    n = value.shape[1]
    return ScaledSignals(
        np.arange(n) / rate,
        value,
        np.ones(n, bool),
        np.ones((value.shape[0] // 2, n), bool),
        np.zeros(value.shape[0] // 2),
        np.full(value.shape[0], 0.01),
        np.ones(value.shape[0] // 2),
        np.zeros(value.shape[0]),
        (None,) * (value.shape[0] // 2),
        None,
        rate,
        0.0,
        0.0,
    )


def test_noise_is_found_under_a_fast_signal() -> None:
    rng = np.random.default_rng(0)
    t = np.arange(20000) / 10000.0
    signal = np.sin(2 * np.pi * 80.0 * t) + 0.02 * rng.standard_normal((2, t.size))
    assert white_noise_v(signal) == pytest.approx(0.02, rel=0.06)


def test_a_bin_never_holds_samples_from_both_sides_of_a_break_or_a_gap() -> None:
    signals = signals_of(np.zeros((2, 3000)), 10000.0)
    time = signals.time_s.copy()
    time[2000:] += 0.05
    gapped = ScaledSignals(time, *(getattr(signals, name) for name in ScaledSignals.__slots__[1:]))
    bins = bin_by_fringe(gapped, time, np.full(time.size, 5.0), 0.05, np.array([0.10003]))
    assert not ((bins.first_s < 0.10003) & (bins.last_s > 0.10003)).any()
    assert (bins.last_s - bins.first_s).max() < 0.0101
    assert bins.count.sum() == 3000


def test_two_nodes_stand_for_the_mean_over_a_bin() -> None:
    rate = 33333.0
    t = np.arange(3000) / rate
    value = np.stack([np.cos(2 * np.pi * 140.0 * t), np.sin(2 * np.pi * 140.0 * t)])
    bins = bin_by_fringe(signals_of(value, rate), t, np.full(t.size, 140.0), 0.0, np.zeros(0))
    nodes = [np.cos(2 * np.pi * 140.0 * (bins.time_s + sign * bins.node_s)) for sign in (-1, 1)]
    assert np.abs(bins.value[0] - (nodes[0] + nodes[1]) / 2).max() < 1e-5


def test_a_map_follows_a_smooth_function_of_position() -> None:
    z = np.linspace(0.0, 0.25, 800)
    place = np.stack([0.01 * np.sin(20 * z), 0 * z, z])
    basis = make_basis(place, 0.1)
    wanted = 0.2 * np.cos(2 * np.pi * z / 0.3) + z**2
    functions = basis(place)
    found = functions @ np.linalg.lstsq(functions, wanted, rcond=1e-10)[0]
    assert np.abs(found - wanted).max() < 2e-4


def test_onset_is_the_end_of_the_rest_and_none_without_motion() -> None:
    rng = np.random.default_rng(1)
    t = np.arange(10000) / 10000.0
    value = 0.02 * rng.standard_normal((4, t.size))
    assert find_onset(t, value) is None
    moving = value + np.where(t > 0.4, np.sin(40 * (t - 0.4)), 0.0)
    assert find_onset(t, moving) == pytest.approx(0.4, abs=0.011)
    early = value + np.where(t > 0.03, np.sin(60 * (t - 0.03)), 0.0)
    assert find_onset(t, early) == float("-inf")


@pytest.mark.parametrize("derivative", [0, 1])
def test_a_wide_parabola_is_the_one_of_scipy(derivative: int) -> None:
    x = np.cumsum(np.random.default_rng(2).standard_normal((2, 3000)), axis=1)
    wanted = savgol_filter(x, 401, 2, deriv=derivative, delta=1e-3, axis=-1)
    assert savitzky_golay(x, 401, derivative=derivative, spacing=1e-3) == pytest.approx(wanted, rel=1e-9, abs=1e-8)


def test_the_noise_of_a_receiver_is_told_in_its_amplitude_and_its_quality_is_that_of_the_motion() -> None:
    n, amplitude = 2000, np.array([2.0, 0.5])
    phase = np.stack([np.linspace(0.0, 60.0, n)] * 2)
    signals = replace(signals_of(np.zeros((4, n)), 1000.0), unusable_share=np.array([0.0, 0.02]))
    moving = np.arange(n) >= 200
    valid = np.ones((2, n), dtype=np.bool_)
    valid[1, 200:290] = False
    # what is off the circle before the motion does not count
    i, q = np.where(moving, np.cos(phase), 3.0), np.where(moving, np.sin(phase), 3.0)
    ends = (FrontEnd(1.1, 0.01, 2.0, 0.1), FrontEnd(0.9, 0.02, -3.0, 0.2))
    one, other = channel_qualities(
        signals, moving, (i, q), valid, phase, amplitude, np.array([0.3, 0.3]), np.array([1.0, 1.0]), ends
    )
    # 10 log10(A^2 / 2 sigma^2), sigma 0.01
    assert one.snr_db == pytest.approx(10.0 * np.log10(2.0**2 / 2e-4))
    assert other.snr_db == pytest.approx(10.0 * np.log10(0.5**2 / 2e-4))
    assert (one.name, other.name) == ("1", "2")
    assert (one.gain_ratio, one.u_gain_ratio, other.quadrature_error_deg, other.u_quadrature_error_deg) == (
        1.1,
        0.01,
        -3.0,
        0.2,
    )
    assert one.circularity == pytest.approx(0.0, abs=1e-9)
    assert (one.fraction_valid, other.fraction_valid) == (1.0, 0.95)
    assert (one.fraction_clipped, other.fraction_clipped) == (0.0, 0.02)
    # the same noise of a bin, in amplitudes: 15 % and 60 %
    assert (one.verdict, other.verdict) == ("good", "rejected")
    assert other.reason.startswith("noise of 60 % of the amplitude")
