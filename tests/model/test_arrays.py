"""What arrays are asked again and again."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, strategies as st
from hypothesis.extra import numpy as hnp

from radargui.model.arrays import median, robust_sd

rows = hnp.arrays(np.float64, st.tuples(st.integers(1, 4), st.integers(1, 30)), elements=st.floats(-1e6, 1e6))


@given(rows, st.sampled_from([None, 0, 1, -1]))
def test_the_median_is_that_of_numpy(values: np.ndarray, axis: int | None) -> None:
    assert median(values, axis) == pytest.approx(np.median(values, axis=axis), rel=1e-15, abs=1e-15)


def test_a_median_of_nothing_or_with_a_number_that_is_none_is_none() -> None:
    assert np.isnan(median(np.empty(0)))
    assert np.isnan(median(np.array([1.0, np.nan, 3.0])))
    assert median(np.array([[1.0, np.nan], [3.0, 5.0]]), axis=1).tolist() == pytest.approx([np.nan, 4.0], nan_ok=True)
    assert median(np.array([1, 2, 4, 8])) == 3.0


def test_a_robust_deviation_is_that_of_the_noise_and_not_of_what_stands_out() -> None:
    values = 0.3 * np.random.default_rng(2).standard_normal(20000)
    assert robust_sd(values) == pytest.approx(0.3, rel=0.02)
    values[::50] = 1e3
    assert robust_sd(values) == pytest.approx(0.3, rel=0.04)
    assert np.isnan(robust_sd(np.empty(0)))
