"""Crosstalk of a multiplexer: what it adds to the channels, and that it is found, or switched off."""

from __future__ import annotations

import numpy as np
import pytest
from support.small_problem import small_problem

from radargui.estimation.forward.bins import Multiplexer
from radargui.estimation.select.converge import converge
from radargui.estimation.solve.problem import linearise


def test_a_channel_keeps_a_share_of_the_one_before_and_the_first_of_the_last_scans_last() -> None:
    time = np.linspace(0.0, 1.0, 101)
    value = np.stack([np.full(101, 2.0), np.full(101, 3.0), 10.0 * time])
    excess = Multiplexer(np.array([0.5, 1.0, 2.0]), 0.1).excess(value, time)
    assert excess[0, 50] == pytest.approx(0.5 * 10.0 * 0.4 - 2.0)
    assert excess[1, 50] == pytest.approx(2.0 - 3.0)
    assert excess[2, 50] == pytest.approx(2.0 * 3.0 - 5.0)


def test_the_model_shows_the_crosstalk_of_its_own_channels() -> None:
    made = small_problem(crosstalk=0.006, delay_s=2e-5)
    at = linearise(made.problem, made.truth)
    theta = made.truth.theta.copy()
    assert at.excess.any()
    assert not theta[made.problem.layout.crosstalk].any()
    theta[made.problem.layout.crosstalk] = 0.006
    with_it = linearise(made.problem, type(made.truth)(made.truth.coefficients, theta))
    assert (with_it.residual**2).mean() < 1.1 < (at.residual**2).mean()


@pytest.mark.parametrize("kappa", [0.0, 0.006])
def test_crosstalk_is_found_within_its_uncertainty(kappa: float) -> None:
    made = small_problem(crosstalk=kappa, delay_s=2e-5, sigma=0.003)
    solution = converge(made.start, 6, lambda: None)
    place = solution.problem.layout.crosstalk
    found = float(solution.state.theta[place][0])
    u = float(np.sqrt(solution.normal.global_variances()[place][0]))
    assert abs(found - kappa) < 3.0 * max(u, 1e-4)
    assert u < 1e-3
