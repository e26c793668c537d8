"""Rounds of a model: when noise follows the misfit, when they end, which solution of several is kept."""

from __future__ import annotations

from dataclasses import replace

import pytest
from support.small_problem import SmallProblem, small_problem

from radargui.estimation.select.converge import (
    COARSE,
    convergence,
)


@pytest.fixture(scope="module")
def louder() -> SmallProblem:
    """Noise of a bin that is twice what its deviation says."""
    made = small_problem(n_bins=120)
    bins = replace(made.problem.bins, sigma=0.5 * made.problem.bins.sigma)
    return replace(made, problem=replace(made.problem, bins=bins))


@pytest.mark.parametrize("first", [0, 2])
def test_the_noise_follows_the_misfit_from_its_round_on_and_never_before(louder: SmallProblem, first: int) -> None:
    settings = replace(COARSE, noise_from_round=first, least_rounds=99)
    scales = [one.problem.noise_scale for one, _ in convergence(louder.start, first + 1, settings)]
    assert len(scales) == first + 2
    assert all(one.tolist() == [1.0] * 3 for one in scales[:-1])
    # by no more than its largest step
    assert scales[-1] == pytest.approx(1.3)
