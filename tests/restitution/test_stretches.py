"""Sums and fits over stretches of a curve at once, against each stretch by itself."""

from __future__ import annotations

import numpy as np
import pytest

from radargui.restitution.stretches import MIN_RESIDUALS, Stretches

TIME_S = np.cumsum(np.random.default_rng(1).uniform(0.5, 1.5, 300)) * 1e-3
BEGIN, END = np.array([5, 20, 100, 150]), np.array([30, 60, 107, 290])


@pytest.fixture
def stretches() -> Stretches:
    """Some that overlap, and one too short to tell anything of its noise."""
    return Stretches.between(TIME_S, BEGIN, END)


def test_sums_means_and_lines_are_those_of_each_by_itself(stretches: Stretches) -> None:
    curve = np.random.default_rng(2).standard_normal((2, 300))
    samples = stretches.of(curve)
    level, slope = stretches.lines(samples)
    for k, (begin, end) in enumerate(zip(BEGIN, END, strict=True)):
        own = curve[:, begin:end]
        assert stretches.sums(samples)[:, k] == pytest.approx(own.sum(axis=1))
        assert stretches.means(samples)[:, k] == pytest.approx(own.mean(axis=1))
        time = TIME_S[begin:end] - TIME_S[begin:end].mean()
        wanted = np.polyfit(time, own.T, 1)
        assert slope[:, k] == pytest.approx(wanted[0])
        assert level[:, k] == pytest.approx(wanted[1])
    assert stretches.spread(np.arange(4.0))[[0, 24, 25, -1]].tolist() == [0.0, 0.0, 1.0, 3.0]


def test_some_stretches_are_what_they_were_among_all(stretches: Stretches) -> None:
    some = stretches.chosen(np.array([False, True, False, True]))
    curve = np.arange(300.0)
    assert some.sums(some.of(curve)) == pytest.approx([curve[20:60].sum(), curve[150:290].sum()])
    assert some.lines(some.of(TIME_S))[1] == pytest.approx([1.0, 1.0])
    assert stretches.chosen(np.ones(4, dtype=bool)) is stretches


def test_a_correlation_length_is_one_and_twice_the_correlations_up_to_their_first_zero(stretches: Stretches) -> None:
    noise = np.random.default_rng(3).standard_normal(310)
    curve = np.convolve(noise, np.ones(6) / 6.0, mode="valid")[:300]
    samples = stretches.of(curve)
    found = stretches.correlation_lengths(samples)
    for k, (begin, end) in enumerate(zip(BEGIN, END, strict=True)):
        own = curve[begin:end] - curve[begin:end].mean()
        n = own.size
        if n < MIN_RESIDUALS:
            assert found[k] == 1.0
            continue
        correlation = np.array([(own[: n - lag] * own[lag:]).sum() for lag in range(n // 2)])
        stop = int(np.argmax(correlation <= 0.0)) if (correlation <= 0.0).any() else correlation.size
        assert found[k] == pytest.approx(max(1.0, 2.0 * correlation[:stop].sum() / correlation[0] - 1.0))
    assert found[3] > 4.0
