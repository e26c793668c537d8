"""Stretches of one receiver that no motion explains: told where they are alone, not where all is wrong."""

from __future__ import annotations

from dataclasses import replace

import pytest
from support.small_problem import small_problem

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
