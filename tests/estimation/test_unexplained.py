"""Stretches of one receiver that no motion explains: told where they are alone, not where all is wrong."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.small_problem import small_problem

from radargui.estimation.posterior.unexplained import Residuals, StretchSettings, unexplained_stretches
from radargui.estimation.solve.minimise import Solution, chi_square, minimise
from radargui.estimation.solve.problem import Start
from radargui.model.channel_quality import unexplained_of


def solved(
    *, receivers: tuple[int, ...] = (1,), begin_s: float = 0.2, end_s: float = 0.21, off: float = 1.0
) -> Solution:
    """A fall in which I of some receivers shows something else for a while."""
    made = small_problem(sigma=0.005)
    problem = made.problem
    bins = problem.bins
    value = bins.value.copy()
    for receiver in receivers:
        value[2 * receiver, (bins.time_s >= begin_s) & (bins.time_s < end_s)] += off
    return minimise(Start(replace(problem, bins=replace(bins, value=value)), made.truth), 1)


def left_by(
    *, receivers: tuple[int, ...] = (1,), begin_s: float = 0.2, end_s: float = 0.21, off: float = 1.0
) -> Residuals:
    """What `solved` leaves."""
    return Residuals.of_solution(solved(receivers=receivers, begin_s=begin_s, end_s=end_s, off=off))


@pytest.mark.parametrize("off", [0.13, 1.0])
def test_a_disturbance_of_milliseconds_is_told_with_its_receiver_and_its_time(off: float) -> None:
    (stretch,) = unexplained_stretches(left_by(off=off))
    assert stretch.receiver == 1
    assert 0.19 < stretch.begin_s < 0.2
    assert 0.209 < stretch.end_s < 0.22
    assert unexplained_of((stretch,))[1].text.startswith("shows from 0.")


def test_a_misfit_that_counts_as_good_over_all_hides_none() -> None:
    solution = solved(off=0.13)
    assert chi_square(solution).max() < 10.0
    assert unexplained_stretches(Residuals.of_solution(solution))


def test_what_all_receivers_show_is_the_motion_not_a_receiver() -> None:
    assert unexplained_stretches(left_by(receivers=(0, 1, 2))) == ()


def test_what_is_next_to_nothing_of_the_wave_is_what_a_model_may_lack() -> None:
    solution = solved(off=0.06)
    assert unexplained_stretches(Residuals.of_solution(solution)) == ()
    # though noise alone never makes it
    assert unexplained_stretches(Residuals.of_solution(solution), StretchSettings(min_share=0.01))


def test_nothing_is_told_where_all_fits_or_where_it_lasts() -> None:
    assert unexplained_stretches(left_by(off=0.0)) == ()
    assert unexplained_stretches(left_by(begin_s=0.1, end_s=0.4)) == ()
    # what chance explains is none
    assert unexplained_stretches(left_by(), StretchSettings(chance=1e-300)) == ()


def test_what_holds_little_of_what_is_wrong_with_a_receiver_is_no_stretch() -> None:
    left = left_by(off=0.3)
    assert unexplained_stretches(left)
    # a model that lacks a wall leaves as much in every bin together
    everywhere = replace(left, misfit=left.misfit + np.array([0.0, 60.0, 0.0])[:, None])
    assert unexplained_stretches(everywhere, StretchSettings(min_part=0.0))
    assert unexplained_stretches(everywhere) == ()
