"""Stretches of one receiver that no motion explains: told where they are alone, not where all is wrong."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from support.small_problem import small_problem

from radargui.estimation.readout import unexplained
from radargui.estimation.readout.unexplained import (
    StretchSettings,
    UnexplainedStretch,
    unexplained_of,
    unexplained_stretches,
)
from radargui.estimation.solve.minimise import Solution, chi_square, minimise
from radargui.estimation.solve.problem import Start


def solved(*, receiver: int = 1, begin_s: float = 0.2, end_s: float = 0.21, off: float = 1.0) -> Solution:
    """A fall in which I of a receiver shows something else for a while."""
    made = small_problem(sigma=0.005)
    problem = made.problem
    bins = problem.bins
    value = bins.value.copy()
    value[2 * receiver, (bins.time_s >= begin_s) & (bins.time_s < end_s)] += off
    return minimise(Start(replace(problem, bins=replace(bins, value=value)), made.truth), 1)


def test_a_disturbance_of_milliseconds_is_told_with_its_receiver_and_its_time() -> None:
    solution = solved()
    assert chi_square(solution).max() > 100.0
    (stretch,) = unexplained_stretches(solution)
    assert stretch.receiver == 1
    assert stretch.begin_s == pytest.approx(0.2, abs=0.007)
    assert stretch.end_s == pytest.approx(0.21, abs=0.007)
    assert unexplained_of((stretch,))[1].startswith("shows from 0.")


def misfits(wrong: dict[int, float], typical: float = 1.0) -> Any:
    """Return a fall of a second in windows of ten bins, some of them with another misfit of receiver 1."""
    # a little more than half a millisecond apart, so that rounding puts none into the window before
    time, misfit = 0.3 + 5.00001e-4 * np.arange(2000), np.full((3, 2000), typical)
    for window, value in wrong.items():
        misfit[1, 10 * window : 10 * window + 10] = value
    use = np.ones(2000, bool)
    # bins that hold a break say nothing
    use[500:505], misfit[1, 500:505] = False, 1e6
    return SimpleNamespace(problem=SimpleNamespace(bins=SimpleNamespace(time_s=time), use=use), at=misfit)


def test_windows_that_stand_out_are_told_with_a_margin_on_both_sides(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(unexplained, "receiver_misfits", lambda problem, at: at)
    first, second = unexplained_stretches(misfits({20: 31.0, 21: 500.0, 60: 29.0, 199: 1000.0}))
    assert (first.receiver, second.receiver) == (1, 1)
    # 5 ms each, from the first bin on
    assert (first.begin_s, first.end_s) == pytest.approx((0.399, 0.411))
    assert (second.begin_s, second.end_s) == pytest.approx((1.294, 1.301))


@pytest.mark.parametrize(
    ("wrong", "typical", "told"),
    [
        (30, 1.0, True),
        (31, 1.0, False),  # of two hundred: for longer than that the model is wrong
        (1, 3.0, True),
        (1, 3.4, False),  # thirty times what it has elsewhere
    ],
)
def test_what_lasts_or_is_not_far_above_the_receivers_own_misfit_is_no_stretch(
    monkeypatch: pytest.MonkeyPatch, wrong: int, typical: float, told: bool
) -> None:
    monkeypatch.setattr(unexplained, "receiver_misfits", lambda problem, at: at)
    assert bool(unexplained_stretches(misfits(dict.fromkeys(range(wrong), 100.0), typical))) is told
    # however small it is elsewhere, thirty is the least
    assert unexplained_stretches(misfits({20: 29.0}, 0.5)) == ()
    assert unexplained_stretches(misfits({20: 31.0}, 0.5))


def test_nothing_is_told_where_all_fits_or_where_it_lasts() -> None:
    assert unexplained_stretches(solved(off=0.0)) == ()
    assert unexplained_stretches(solved(begin_s=0.1, end_s=0.4)) == ()
    # what is left would not fit either
    assert unexplained_stretches(solved(), StretchSettings(least_misfit=1e9)) == ()


def test_one_sentence_names_all_stretches_of_a_receiver() -> None:
    said = unexplained_of(
        [UnexplainedStretch(2, 0.1, 0.2), UnexplainedStretch(0, 0.3, 0.4), UnexplainedStretch(2, 0.5, 0.6)]
    )
    assert list(said) == [0, 2]
    assert said[2].startswith("shows from 0.100 to 0.200, 0.500 to 0.600 s")
