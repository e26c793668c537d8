"""Extremes by prominence and the spline through them, against scipy's."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.signal import find_peaks

from radargui.correction.published import prominent, spline_through, turning_points


@pytest.mark.parametrize("seed", range(40))
def test_those_stand_out_whose_prominence_is_large_enough_and_the_spline_goes_through_them(seed: int) -> None:
    rng = np.random.default_rng(seed)
    count = int(rng.integers(50, 3000))
    x = rng.uniform(0.0, 0.3) * np.cumsum(rng.normal(size=count)) + np.sin(np.arange(count) * rng.uniform(0.01, 0.2))
    x += rng.uniform(0.0, 0.2) * rng.normal(size=count)
    least = rng.uniform(0.2, 2.0)
    place, peak = turning_points(x)
    number = prominent(x, place, least)
    assert place[number][peak[number]].tolist() == find_peaks(x, prominence=least)[0].tolist()
    assert place[number][~peak[number]].tolist() == find_peaks(-x, prominence=least)[0].tolist()
    if number.size >= 4:
        at = place[number]
        wanted = CubicSpline(at, x[at])(np.arange(at[0], at[-1] + 1))
        assert spline_through(at, x[at]) == pytest.approx(wanted, abs=1e-9 * np.abs(wanted).max())


def test_a_share_of_its_own_is_asked_of_each_extreme() -> None:
    x = np.array([0.0, 5.0, 4.0, 6.0, 0.0, 3.0, 2.0, 5.0, 0.0])
    place, _ = turning_points(x)
    assert place.tolist() == [1, 2, 3, 4, 5, 6, 7]
    least = np.where(place < 4, 0.5, 1.5)
    assert place[prominent(x, place, least)].tolist() == [1, 2, 3, 4, 7]


def test_the_middle_of_a_plateau_is_its_extreme() -> None:
    place, peak = turning_points(np.array([0.0, 1.0, 1.0, 1.0, 0.0, 0.0, 2.0]))
    assert place.tolist() == [2, 4]
    assert peak.tolist() == [True, False]
