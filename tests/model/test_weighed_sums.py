"""Weighed sums of neighbouring samples are what their definition says, however they are reckoned."""

import numpy as np
import pytest

from radargui.model.arrays import weighed_sums


@pytest.mark.parametrize(
    ("n_samples", "n_weights"), [(5, 5), (40, 12), (90, 60), (256, 256), (300, 257), (5000, 301), (4097, 1024)]
)
def test_each_sum_weighs_the_samples_from_its_own_on(n_samples: int, n_weights: int) -> None:
    draw = np.random.default_rng(n_samples)
    values, weights = draw.standard_normal(n_samples), draw.standard_normal(n_weights)
    wanted = np.lib.stride_tricks.sliding_window_view(values, n_weights) @ weights
    assert weighed_sums(values, weights) == pytest.approx(wanted, abs=1e-12 * n_weights)
