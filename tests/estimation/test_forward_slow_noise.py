"""When 1/f noise and drift count and how much of them each function carries: against closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from radargui.estimation.forward.bins import Bins
from radargui.estimation.forward.slow_noise import Drift, SlowNoiseSettings, measure_drift
from radargui.estimation.signals import ScaledSignals

SIGMA, RATE_HZ, BEGIN_S = 0.01, 4000.0, 7.0


def signals_of(value: np.ndarray, sigma: float = SIGMA) -> ScaledSignals:
    """Return channels that begin at 7 s."""
    n_channels, n = value.shape
    return ScaledSignals(
        time_s=BEGIN_S + np.arange(n) / RATE_HZ,
        value=value,
        valid=np.ones((n_channels // 2, n), bool),
        usable=np.ones(n, bool),
        unusable_share=np.zeros(n_channels // 2),
        sigma=np.full(n_channels, sigma),
        scale_v=np.ones(n_channels // 2),
        delay_s=np.zeros(n_channels),
        mixers=(None,) * (n_channels // 2),
        before=None,
        rate_hz=RATE_HZ,
        rest_end_s=BEGIN_S + 0.5,
        onset_s=BEGIN_S + 0.5,
    )


def test_a_drift_of_the_offsets_is_carried_by_the_slowest_functions_alone() -> None:
    time, slope = np.arange(4001) / RATE_HZ, 0.3
    white = SlowNoiseSettings(gain_a_channel=np.inf)
    drift = measure_drift(signals_of(np.tile(slope * time, (4, 1)), 1e-5), BEGIN_S + 0.5, white)
    # a function of k half cycles of the record of one second
    order = np.tile(np.arange(1.0, 7.0), 2)
    assert drift.sd == pytest.approx(np.tile(2.0 * slope / (np.pi * order**2), (4, 1)), rel=1e-3)
    assert drift.functions(np.array([BEGIN_S, BEGIN_S + 1.0])) == pytest.approx(
        np.array([[1.0] * 6 + [0.0] * 6, [-1.0, 1.0] * 3 + [0.0] * 6]), abs=1e-12
    )


def bins_of(node_s: float, n: int = 200) -> Bins:
    edge = np.linspace(0.0, 1.0, n + 1)
    ones = np.ones((2, n))
    sigma = SIGMA * ones
    return Bins(
        0.5 * (edge[1:] + edge[:-1]), np.full(n, node_s), 0.0 * ones, sigma, np.full(n, 8), edge[:-1], edge[1:], ones
    )


def test_what_a_bin_shows_of_the_noise_that_widens_it_is_what_lies_between_function_and_bin() -> None:
    level = 3e-6
    drift = Drift(0.0, 1.0, 80, np.ones((2, 80)), np.array([level, 0.0]))
    # 20 cycles are 20 Hz; a bin 1 ms long, by its nodes
    bins = bins_of(0.5e-3 / np.sqrt(3.0))
    wide = drift.widen(bins)
    assert wide.sigma[0] ** 2 == pytest.approx(SIGMA**2 + 12.0 * level)
    seen = SIGMA**2 + level * np.log(1.0 / (2.0 * 1e-3 * 20.0))
    assert wide.expected[0] == pytest.approx(seen / (SIGMA**2 + 12.0 * level), rel=1e-4)
    # white noise shows as it is
    assert wide.sigma[1] == pytest.approx(SIGMA)
    assert wide.expected[1] == pytest.approx(1.0)
    # of a bin longer than the fastest cycle something is left
    long = drift.widen(bins_of(0.1))
    assert long.expected[0] == pytest.approx((SIGMA**2 + level * np.log(1.5)) / (SIGMA**2 + 12.0 * level))
