"""Samples against each other, sessions against their own scatter: textbook values and known components."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import ttest_ind

from radargui.restitution.comparison import compare, repeatability_of

A, B = (
    [27.5, 21.0, 19.0, 23.6, 17.0, 17.9, 16.9, 20.1, 21.9, 22.6, 23.1, 19.6, 19.0, 21.7, 21.4],
    [
        *(27.1, 22.0, 20.8, 23.4, 23.4, 23.5, 25.8, 22.0, 24.8, 20.2, 21.9, 22.1, 22.9, 30.5, 23.5, 24.8),
    ],
)


def test_two_samples_by_welchs_t() -> None:
    found = compare({"a": A, "b": B, "of one drop": [1.0]})
    assert found is not None
    assert found.groups == ("a", "b")
    a, b = np.array(A), np.array(B)
    u = np.sqrt(a.var(ddof=1) / a.size + b.var(ddof=1) / b.size)
    assert found.statistic == pytest.approx((a.mean() - b.mean()) / u)
    assert found.difference == pytest.approx(a.mean() - b.mean())
    interval = ttest_ind(a, b, equal_var=False).confidence_interval(0.95)
    assert (found.difference_low, found.difference_high) == pytest.approx((interval.low, interval.high))
    assert interval.high < 0.0
    assert found.differ
    assert "differ at 5 %" in found.words


def test_three_samples_by_welchs_analysis_of_variance() -> None:
    rng = np.random.default_rng(1)
    alike = [
        compare(
            {name: rng.normal(0.8, s, n).tolist() for name, s, n in (("a", 1e-3, 5), ("b", 5e-3, 12), ("c", 2e-3, 8))}
        )
        for _ in range(300)
    ]
    wrong = sum(one is not None and one.differ for one in alike)
    # unequal scatter and unequal numbers: still 5 of 100
    assert 4 <= wrong <= 28
    other = compare({"a": [0.80, 0.801, 0.799], "b": [0.81, 0.811, 0.809], "c": [0.80, 0.802, 0.798]})
    assert other is not None
    assert other.difference is None
    assert other.differ


def test_nothing_to_compare_is_none() -> None:
    assert compare({"a": A}) is None
    assert compare({"a": A, "b": [1.0]}) is None
    assert compare({"a": [1.0, 1.0], "b": [2.0, 3.0]}) is None


def test_the_components_of_a_balanced_table_are_those_of_the_mean_squares() -> None:
    groups = [[1.0, 3.0], [4.0, 6.0], [8.0, 10.0]]
    found = repeatability_of(groups)
    assert found is not None
    # mean squares: within 2, between 2 * var(2, 5, 9)
    between = 2.0 * np.var([2.0, 5.0, 9.0], ddof=1)
    assert found.repeatability_sd == pytest.approx(np.sqrt(2.0))
    assert found.between_sd == pytest.approx(np.sqrt((between - 2.0) / 2.0))
    assert found.reproducibility_sd == pytest.approx(np.hypot(found.repeatability_sd, found.between_sd))
    assert found.f == pytest.approx(between / 2.0)
    assert found.mean == pytest.approx(16.0 / 3.0)


def test_the_components_of_unbalanced_sessions_come_out_and_the_mean_holds() -> None:
    rng = np.random.default_rng(2)
    found = []
    for _ in range(400):
        days = rng.normal(0.8, 0.004, 6)
        one = repeatability_of(
            [rng.normal(day, 0.002, n).tolist() for day, n in zip(days, (3, 5, 8, 4, 10, 2), strict=True)]
        )
        assert one is not None
        found.append(one)
    assert np.mean([one.repeatability_sd**2 for one in found]) == pytest.approx(0.002**2, rel=0.05)
    assert np.mean([one.between_sd**2 for one in found]) == pytest.approx(0.004**2, rel=0.1)
    inside = np.mean([one.interval_low <= 0.8 <= one.interval_high for one in found])
    assert 0.91 <= inside <= 0.985


def test_sessions_without_a_scatter_of_their_own_have_none() -> None:
    found = repeatability_of([[0.79, 0.81], [0.80, 0.80], [0.795, 0.805]])
    assert found is not None
    assert found.between_sd == 0.0
    assert repeatability_of([[0.8, 0.81]]) is None
    assert repeatability_of([[0.8], [0.81]]) is None
