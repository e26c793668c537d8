"""Channels brought to one time, against the quintic spline through all samples."""

import numpy as np
import pytest
from scipy.interpolate import make_interp_spline

from radargui.conditioning.skew import REACH, remove_skew

RATE = 1000.0


@pytest.mark.parametrize("size", [4 * REACH, 4 * REACH + 1, 1000])
@pytest.mark.parametrize("back", [0.03, 0.5, 0.83, 2.3])
def test_it_is_the_spline_through_all_samples_also_at_the_ends(size: int, back: float) -> None:
    volts = np.random.default_rng(3).normal(size=(2, size))
    index = np.arange(float(size))
    expected = make_interp_spline(index, volts[1], 5)(index - back)
    found = remove_skew(volts, RATE, np.array([0.0, back / RATE]))
    assert found[1] == pytest.approx(expected, abs=1e-7)
    assert (found[0] == volts[0]).all()


def test_a_late_wave_is_what_it_would_have_been_in_time() -> None:
    time_s = np.arange(1000) / RATE
    late = np.sin(2.0 * np.pi * 50.0 * (time_s + 0.4 / RATE))
    found = remove_skew(np.stack([late, late]), RATE, np.array([0.0, 0.4 / RATE]))[1]
    assert found[3:-3] == pytest.approx(np.sin(2.0 * np.pi * 50.0 * time_s)[3:-3], abs=2e-5)
