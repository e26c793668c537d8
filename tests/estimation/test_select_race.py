"""Alternatives run side by side: who is behind is given up, wherever the steps are done."""

from __future__ import annotations

import numpy as np
import pytest
from support.small_problem import WALL_PLANE, small_problem

from radargui.estimation.select.converge import converge
from radargui.estimation.select.race import best_started, race
from radargui.estimation.select.wall_grid import upright_planes
from radargui.estimation.solve.changed_problem import positions_at_bins, problem_with_mirrors
from radargui.estimation.solve.minimise import Solution, log_evidence
from radargui.estimation.solve.problem import Start
from radargui.model.errors import CancelledError
from radargui.system.cores import on_cores

UP = np.array([0.0, 0.0, 1.0])


def nothing() -> None:
    """Report no progress."""


@pytest.fixture(scope="module")
def hidden() -> Solution:
    """The data have a wall 14 cm along +x; the model has none."""
    return converge(small_problem(reflection=0.06, shown=(WALL_PLANE,), sigma=0.005).start, 3, nothing)


def starts_at(solution: Solution, *azimuth_deg: float) -> list[Start]:
    planes = upright_planes(positions_at_bins(solution).mean(axis=1), UP, np.radians(azimuth_deg), np.array([0.14]))
    return [problem_with_mirrors(solution, (plane,)) for plane in planes]


def test_each_round_of_each_alternative_is_counted_once_and_a_cancelled_race_ends(hidden: Solution) -> None:
    counted: list[int] = []

    def third() -> None:
        counted.append(1)
        if len(counted) == 3:
            raise CancelledError

    with pytest.raises(CancelledError):
        race(starts_at(hidden, 180.0, 0.0), 4, third, (1e9,))
    assert len(counted) == 3
    counted.clear()
    race(starts_at(hidden, 180.0), 2, lambda: counted.append(1), (1e9,))
    assert len(counted) == 2


def test_a_race_on_other_cores_ends_as_it_does_here(hidden: Solution) -> None:
    starts = starts_at(hidden, 180.0, 182.0, 120.0, 0.0)
    here = race(starts, 2, nothing, (200.0,))
    first = best_started(starts, 2, nothing)
    with on_cores(2) as others:
        # nobody waits for processes to begin
        race(starts, 1, nothing, (1e9,))
        assert others.wait_ready(60.0)
        apart = race(starts, 2, nothing, (200.0,))
        apart_first = best_started(starts, 2, nothing)
    assert [one is None for one in apart] == [one is None for one in here]
    for one, other in zip([one for one in here if one], [one for one in apart if one], strict=True):
        assert log_evidence(other) == pytest.approx(log_evidence(one), abs=1e-6)
        assert positions_at_bins(other) == pytest.approx(positions_at_bins(one), abs=1e-10)
    for before, after in zip(first, apart_first, strict=True):
        assert after.problem.inputs.planes[-1].foot_m == pytest.approx(before.problem.inputs.planes[-1].foot_m)
        assert after.state.theta == pytest.approx(before.state.theta, abs=1e-8)
