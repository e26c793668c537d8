"""Decimated curves keep what the eye would see."""

from __future__ import annotations

import numpy as np
from hypothesis import given, strategies as st
from hypothesis.extra import numpy as hnp

from radargui.report.curves import envelope, every

values = hnp.arrays(np.float64, st.integers(0, 3000), elements=st.floats(-10.0, 10.0))


@given(values, st.integers(1, 200))
def test_the_lowest_and_highest_point_survive_in_order_of_time(y: np.ndarray, columns: int) -> None:
    curve = envelope(np.arange(y.size, dtype=np.float64), y, columns=columns)
    assert len(curve.x) <= 2 * columns + 4
    assert (np.diff(curve.x) > 0).all()
    if y.size:
        assert curve.y.min() == y.min()
        assert curve.y.max() == y.max()
        assert curve.x[0] == 0
        assert curve.x[-1] == y.size - 1
        np.testing.assert_array_equal(curve.y, y[curve.x.astype(int)])


def test_a_single_spike_in_a_million_samples_is_seen() -> None:
    y = np.zeros(1_000_000)
    y[765_432] = 1.0
    curve = envelope(np.arange(y.size) / 1e4, y)
    assert curve.x[curve.y == 1.0] == 76.5432
    assert len(curve.x) < 1500


def test_unknown_stretches_break_the_curve_and_hide_nothing_known() -> None:
    y = np.ones(10_000)
    y[4000:6000] = np.nan
    y[4999] = 5.0
    curve = envelope(np.arange(10_000.0), y, columns=100)
    inside = (curve.x >= 4100) & (curve.x < 4900)
    assert np.isnan(curve.y[inside]).all()
    assert np.nanmax(curve.y) == 5.0


def test_lost_samples_break_the_curve() -> None:
    x = np.concatenate([np.arange(500.0), np.arange(800.0, 1300.0)])
    curve = envelope(x, np.ones(1000), breaks=[500], columns=50)
    assert np.isnan(curve.y).sum() == 1
    assert curve.x[np.isnan(curve.y)] == 800.0


def test_evenly_spread_indices_include_both_ends() -> None:
    assert list(every(5, 10)) == [0, 1, 2, 3, 4]
    kept = every(100_000, 2500)
    assert (kept[0], kept[-1]) == (0, 99_999)
    assert kept.size == 2500
    assert every(0, 10).size == 0
