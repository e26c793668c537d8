"""Statistics of repeated values: intervals that hold, scatter against stated u, outliers flagged and kept."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, strategies as st
from scipy import stats

from radargui.restitution.statistics import outliers_of, probability, statistics_of

ROSNER = """
-0.25 0.68 0.94 1.15 1.20 1.26 1.26 1.34 1.38 1.43 1.49 1.49 1.55 1.56 1.58 1.65 1.69 1.70 1.76 1.77 1.81 1.91 1.94 1.96
1.99 2.06 2.09 2.10 2.14 2.15 2.23 2.24 2.26 2.35 2.37 2.40 2.47 2.54 2.62 2.64 2.90 2.92 2.92 2.93 3.21 3.26 3.30 3.59
3.68 4.30 4.64 5.34 5.42 6.01
"""
"""Rosner 1983, as in NIST/SEMATECH e-Handbook 1.3.5.17.3."""


def test_the_interval_is_students() -> None:
    values = [0.79, 0.80, 0.81, 0.802]
    found = statistics_of(values)
    low, high = stats.t.interval(0.95, 3, np.mean(values), stats.sem(values))
    assert (found.interval_low, found.interval_high) == pytest.approx((low, high), rel=1e-12)
    assert found.expanded is None
    assert found.consistency is None


def test_the_interval_holds_the_mean_in_95_of_100_series() -> None:
    rng = np.random.default_rng(11)
    found = [statistics_of(rng.normal(0.8, 0.003, 5).tolist()) for _ in range(2000)]
    inside = sum((one.interval_low or 0.0) <= 0.8 <= (one.interval_high or 0.0) for one in found)
    # four standard deviations of the binomial
    assert abs(inside - 1900) < 40


def test_the_expanded_uncertainty_takes_fewer_degrees_of_freedom_where_the_scatter_dominates() -> None:
    values, own = [0.79, 0.80, 0.81], [0.001] * 3
    scatter = statistics_of(values, own, [math.hypot(0.001, 1e-7)] * 3)
    assert scatter.expanded == pytest.approx(stats.t.ppf(0.975, 2) * 0.01 / math.sqrt(3), rel=1e-3)
    shared = statistics_of(values, own, [math.hypot(0.001, 1.0)] * 3)
    assert shared.combined == pytest.approx(1.0, rel=1e-4)
    assert shared.expanded == pytest.approx(1.96, rel=1e-3)


def test_scatter_is_held_against_the_stated_uncertainties() -> None:
    values, u = np.array([0.790, 0.800, 0.812]), np.array([0.004, 0.005, 0.004])
    found = statistics_of(values.tolist(), u.tolist()).consistency
    assert found is not None
    mean = np.sum(values / u**2) / np.sum(1.0 / u**2)
    chi2 = np.sum(((values - mean) / u) ** 2)
    assert (found.weighted_mean, found.chi2) == pytest.approx((mean, chi2), rel=1e-12)
    assert found.p == pytest.approx(stats.chi2.sf(chi2, 2), rel=1e-12)
    assert found.birge_ratio == pytest.approx(math.sqrt(chi2 / 2))
    assert found.u_weighted_mean == pytest.approx(found.birge_ratio / math.sqrt(np.sum(1.0 / u**2)))
    assert "larger than the stated" in found.words
    smaller = statistics_of([0.8000, 0.8001, 0.8002], [0.01] * 3).consistency
    assert smaller is not None
    assert smaller.u_weighted_mean == pytest.approx(0.01 / math.sqrt(3))
    assert "smaller than the stated" in smaller.words


def test_a_value_without_its_own_u_leaves_the_comparison_out() -> None:
    assert statistics_of([0.79, 0.80], [0.001, None]).consistency is None
    of_two = statistics_of([0.79, 0.80], [0.01, 0.01]).consistency
    assert of_two is not None
    assert "of 1 degree of freedom, " in of_two.words


def test_rosners_example_has_three_outliers_at_5_percent() -> None:
    values = np.array(ROSNER.split(), dtype=np.float64)
    assert [values[place] for place in outliers_of(values, 0.05)] == [6.01, 5.42, 5.34]


def test_one_clean_series_in_a_hundred_is_flagged() -> None:
    rng = np.random.default_rng(12)
    flagged = sum(bool(outliers_of(rng.normal(size=10))) for _ in range(3000))
    # the second suspect of ten is a little less strict than the test's level
    assert 12 <= flagged <= 60


def test_an_outlier_hidden_by_another_is_found_and_both_stay_in_the_mean() -> None:
    values = [0.800, 0.801, 0.799, 0.8005, 0.7995, 0.8002, 0.7998, 0.8001, 0.83, 0.831]
    found = statistics_of([None, *values])
    assert sorted(found.outliers) == [9, 10]
    assert found.mean == pytest.approx(np.mean(values))


@pytest.mark.parametrize("values", [[], [1.0], [1.0, 2.0], [1.0, 1.0, 1.0, 1.0], [0.1 + 0.2, 0.3, 0.3, 0.3]])
def test_too_few_or_equal_values_have_no_outlier(values: list[float]) -> None:
    assert outliers_of(np.array(values)) == ()


spread = st.lists(st.floats(-1.0, 1.0), min_size=3, max_size=12, unique_by=lambda x: round(x, 3))


@given(spread, st.floats(0.01, 100.0), st.floats(-10.0, 10.0))
def test_unit_and_zero_change_nothing_but_the_numbers(values: list[float], scale: float, zero: float) -> None:
    there = [zero + scale * x for x in values]
    one, other = statistics_of(values, [0.1] * len(values)), statistics_of(there, [0.1 * scale] * len(values))
    for key in ("mean", "interval_low", "interval_high"):
        assert getattr(other, key) == pytest.approx(zero + scale * getattr(one, key), rel=1e-6, abs=1e-6)
    assert other.standard_error == pytest.approx(scale * (one.standard_error or 0.0), rel=1e-6)
    assert one.consistency is not None
    assert other.consistency is not None
    assert other.consistency.birge_ratio == pytest.approx(one.consistency.birge_ratio, rel=1e-6)


@pytest.mark.parametrize(
    ("p", "text"),
    [(1.0, "> 0.99"), (0.9951, "> 0.99"), (0.99, "= 0.99"), (0.8, "= 0.80"), (0.03, "= 0.030"), (5e-5, "< 0.0001")],
)
def test_a_probability_has_two_digits_and_nothing_is_certain(p: float, text: str) -> None:
    assert probability(p) == text
