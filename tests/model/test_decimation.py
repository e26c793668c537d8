"""Lowest and highest of each bin: no peak is lost, however the samples come."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, strategies as st
from hypothesis.extra import numpy as hnp

from radargui.model.arrays import extremes, lowest_and_highest
from radargui.signals.rows import order_statistics


@given(st.integers(0, 300), st.integers(1, 40), st.integers(0, 500))
def test_bins_stay_at_multiples_of_their_size_whatever_sample_a_block_begins_with(
    count: int, size: int, first_index: int
) -> None:
    values = np.random.default_rng(count).standard_normal((2, count))
    low, high = lowest_and_highest(values, size, first_index)
    bins = (first_index + np.arange(count)) // size
    expected = [values[:, bins == one] for one in np.unique(bins)]
    assert low.shape == high.shape == (2, len(expected))
    for column, part in enumerate(expected):
        np.testing.assert_array_equal(low[:, column], part.min(axis=1))
        np.testing.assert_array_equal(high[:, column], part.max(axis=1))


@pytest.mark.parametrize("dtype", [np.int16, np.float64])
def test_the_type_of_the_samples_is_kept(dtype: type) -> None:
    low, high = lowest_and_highest(np.arange(10, dtype=dtype)[None], 4)
    assert low.dtype == high.dtype == dtype
    assert (low.tolist(), high.tolist()) == ([[0, 4, 8]], [[3, 7, 9]])


def test_what_is_unknown_hides_nothing_known() -> None:
    values = np.array([np.nan, 2.0, np.nan, np.nan, np.nan, 1.0])
    low, high = lowest_and_highest(values, 2)
    np.testing.assert_array_equal(low, [2.0, np.nan, 1.0])
    np.testing.assert_array_equal(high, [2.0, np.nan, 1.0])


@given(hnp.arrays(np.float64, st.integers(0, 400), elements=st.floats(-9.0, 9.0)), st.integers(3, 50))
def test_the_extremes_of_every_bin_are_kept_with_both_ends_and_in_order(y: np.ndarray, size: int) -> None:
    kept = extremes(y, size)
    assert (np.diff(kept) > 0).all()
    for first in range(0, y.size, size):
        inside = y[kept[(kept >= first) & (kept < first + size)]]
        assert inside.min() == y[first : first + size].min()
        assert inside.max() == y[first : first + size].max()
    if y.size:
        assert (kept[0], kept[-1]) == (0, y.size - 1)
        assert kept.size <= 2 * -(-y.size // size) + 2


def test_a_bin_without_a_number_keeps_one_sample_so_that_the_curve_breaks() -> None:
    y = np.ones(40)
    y[10:30] = np.nan
    kept = extremes(y, 10)
    assert np.isnan(y[kept]).sum() == 2


def test_order_statistics_are_values_near_the_quantiles() -> None:
    values = np.random.default_rng(3).permuted(np.tile(np.arange(101.0), (2, 1)), axis=1)
    assert order_statistics(values, 0.05, 0.5, 0.98).tolist() == [[5.0, 50.0, 98.0]] * 2
    assert order_statistics(np.array([7.0]), 0.95).tolist() == [7.0]
