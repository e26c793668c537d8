"""The time axis: rate and gaps from times, rounded as files have them."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from radargui.files.signals import rate_of_step, uniform
from radargui.model.errors import FileError


@settings(max_examples=100, deadline=None)
@given(
    rate_hz=st.one_of(st.integers(1, 1_000_000).map(float), st.floats(0.5, 1e6)),
    start_s=st.floats(-100.0, 1e4),
    lost=st.lists(st.tuples(st.integers(1, 398), st.integers(1, 1000)), max_size=4, unique_by=lambda one: one[0]),
)
def test_rate_and_gaps_come_back_from_exact_times(rate_hz: float, start_s: float, lost: list[tuple[int, int]]) -> None:
    steps = np.ones(399)
    for place, count in lost:
        steps[place] += count
    index = np.concatenate([[0.0], np.cumsum(steps)])
    found, gaps = uniform(start_s + index / rate_hz, "here")
    assert found == pytest.approx(rate_hz, rel=1e-7 + 1e-11 * rate_hz)
    assert [(gap.first_index, gap.count) for gap in gaps] == [
        (int(index[place]) + 1, count) for place, count in sorted(lost)
    ]


@pytest.mark.parametrize("digits", [5, 6, 9])
def test_rounding_of_the_times_cancels_out(digits: int) -> None:
    time_s = np.round(np.arange(40_000) / 33333.0, digits)
    assert uniform(time_s, "here") == (33333.0, ())


def test_a_rate_between_whole_numbers_is_not_rounded_away() -> None:
    found, _ = uniform(np.arange(40_000) / 33333.3333, "here")
    assert found == pytest.approx(33333.3333, rel=1e-12)


def test_too_few_digits_are_refused_with_the_remedy() -> None:
    with pytest.raises(FileError, match=r"times do not increase at sample 2.*too few digits.*--rate-hz"):
        uniform(np.round(np.arange(1000) / 33333.0, 3), "here")


def test_a_change_of_rate_is_refused() -> None:
    steps = np.concatenate([np.full(500, 1e-3), np.full(500, 1.3e-3)])
    with pytest.raises(FileError, match="times are not uniform"):
        uniform(np.cumsum(steps), "here")


@pytest.mark.parametrize(
    ("step_s", "rate_hz"),
    [(1.9999999999999998e-05, 50000.0), (0.001, 1000.0), (3e-5, 1 / 3e-5), (0.0, None), (-1.0, None), (np.nan, None)],
)
def test_a_sampling_interval_is_a_rate(step_s: float, rate_hz: float | None) -> None:
    assert rate_of_step(step_s) == rate_hz
