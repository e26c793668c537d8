"""Some bins are looked at, the others lie between them."""

from __future__ import annotations

import numpy as np
import pytest

from radargui.estimation.forward.thinned import Thinned


@pytest.mark.parametrize("n_bins", [1, 2, 8, 9, 10, 17, 100])
def test_values_between_some_bins_lie_on_straight_lines(n_bins: int) -> None:
    thinned = Thinned(n_bins, 8)
    assert {0, n_bins - 1} <= set(thinned.bins.tolist())
    assert np.diff(thinned.bins, prepend=-8).max() <= 8
    values = np.random.default_rng(1).normal(size=(3, thinned.bins.size, 2)) @ np.array([1.0, 1.0j])
    expected = [np.interp(np.arange(n_bins), thinned.bins, row) for row in values]
    assert thinned(values) == pytest.approx(np.array(expected), abs=1e-15)
