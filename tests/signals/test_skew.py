"""Channels brought to one time, against the quintic spline through all samples."""

import numpy as np
import pytest

from radargui.signals.skew import REACH, remove_skew

RATE = 1000.0


def test_a_late_wave_is_what_it_would_have_been_in_time() -> None:
    time_s = np.arange(1000) / RATE
    late = np.sin(2.0 * np.pi * 50.0 * (time_s + 0.4 / RATE))
    found = remove_skew(np.stack([late, late]), RATE, np.array([0.0, 0.4 / RATE]))[1]
    assert found[3:-3] == pytest.approx(np.sin(2.0 * np.pi * 50.0 * time_s)[3:-3], abs=2e-5)


@pytest.mark.parametrize("back", [0.02, 0.5, 0.83])
def test_a_wave_of_32_samples_is_in_time_with_seven_of_them(back: float) -> None:
    index = np.arange(4000.0)
    late, due = (np.sin(2.0 * np.pi * at / 32.0) for at in (index + back, index))
    found = remove_skew(np.stack([late, late]), RATE, np.array([0.0, back / RATE]), slow=True)[1]
    # the ends are those of the spline
    assert np.abs(found - due)[REACH:-REACH].max() < 3e-8
    # of faster ones it is another: only means are that slow
    faster, _ = (np.sin(2.0 * np.pi * at / 6.0) for at in (index + back, index))
    both = [
        remove_skew(np.stack([faster, faster]), RATE, np.array([0.0, back / RATE]), slow=slow)[1] for slow in (0, 1)
    ]
    assert np.abs(both[0] - both[1]).max() > 1e-5
