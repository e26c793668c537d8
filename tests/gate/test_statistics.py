"""Intervals of rates, medians and differences hold what they promise."""

from __future__ import annotations

import numpy as np
import pytest
from benchmarks.gate.statistics import (
    clustered_share,
    paired_difference,
    quantile,
    ratio_of_medians,
    share,
)


def test_a_share_has_wilsons_interval() -> None:
    # Newcombe, Stat. Med. 17, 857 (1998), table I: 81 of 263, 15 of 148, 0 of 20
    assert share(81, 263) == pytest.approx((0.3080, 0.2553, 0.3662), abs=5e-5)
    assert share(15, 148) == pytest.approx((0.1014, 0.0624, 0.1605), abs=5e-5)
    assert share(0, 20) == pytest.approx((0.0, 0.0, 0.1611), abs=5e-5)
    assert np.isnan(share(0, 0).value)


def test_values_that_hang_together_count_as_one_scene() -> None:
    rng = np.random.default_rng(1)
    hits = 10 * (rng.random(100) < 0.8)
    together = clustered_share(hits, np.full(100, 10))
    alone = share(int(hits.sum()), 1000)
    assert together.value == alone.value
    assert together.high - together.low > 2.5 * (alone.high - alone.low)
    assert together == pytest.approx(share(int(hits.sum()) // 10, 100), abs=0.02)


def test_where_all_values_hit_the_interval_is_that_of_so_many_scenes() -> None:
    assert clustered_share([3, 2, 0, 4], [3, 2, 0, 4]) == share(3, 3)
    assert clustered_share([0, 0], [3, 2]) == share(0, 2)


def test_the_interval_of_a_quantile_holds_it_as_often_as_promised() -> None:
    rng = np.random.default_rng(2)
    for q, true in ((0.5, np.log(2.0)), (0.9, np.log(10.0))):
        intervals = [quantile(rng.exponential(size=100), q) for _ in range(100)]
        assert 88 <= sum(one.low <= true <= one.high for one in intervals) <= 100


def test_values_that_are_not_known_are_left_out_of_a_quantile() -> None:
    assert quantile([1.0, np.nan, 3.0, 2.0], 0.5).value == 2.0
    assert np.isnan(quantile([np.nan], 0.5).value)
    assert np.isnan(quantile([], 0.5).value)


def test_a_quantile_of_sessions_draws_sessions() -> None:
    each = np.random.default_rng(3).exponential(size=40)
    values, session = np.repeat(each, 10), np.repeat(np.arange(40), 10)
    alone, together = quantile(values, 0.5), quantile(values, 0.5, session)
    assert together.high - together.low > 2.0 * (alone.high - alone.low)


def test_the_ratio_of_medians_of_the_same_scenes_is_sharper_than_its_parts() -> None:
    rng = np.random.default_rng(4)
    before = rng.lognormal(0.0, 2.0, 300)
    now = before * rng.lognormal(np.log(1.05), 0.02, 300)
    ratio, median = ratio_of_medians(now, before), quantile(before, 0.5)
    assert 1.0 < ratio.low < 1.05 < ratio.high < 1.1
    assert median.high / median.low > 1.3


def test_a_paired_difference_of_nothing_is_no_point() -> None:
    nothing = paired_difference(0, 0, 300)
    assert nothing.value == 0.0
    assert -0.01 < nothing.low < -0.004
    assert nothing.high == -nothing.low


def test_the_interval_of_a_paired_difference_holds_it_as_often_as_promised() -> None:
    rng = np.random.default_rng(5)
    drawn = rng.multinomial(300, (0.03, 0.01, 0.96), 1000)
    held = [one.low <= 0.02 <= one.high for one in (paired_difference(int(b), int(c), 300) for b, c, _ in drawn)]
    assert 0.93 <= np.mean(held) <= 0.98
