"""A level motion whose bias maps have grown until they stand for the signal is lost; one that flies is not."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from support.small_problem import START_S, small_problem

from radargui.estimation.select.loose_maps import is_lost
from radargui.estimation.solve.minimise import chi_square
from radargui.estimation.solve.problem import linearise

GOOD, BAD = 1.9, 5.0


def lost(
    loose: tuple[int, ...] = (0, 1, 2),
    *,
    misfit: float = BAD,
    flies: bool = False,
    point: bool = False,
    beyond: float = 0.5,
) -> bool:
    """Return whether a motion is, with the maps of some receivers grown and one offset of so many waves."""
    small = small_problem(n_bins=20)
    for own in (small.problem.layout.receivers[k] for k in loose):
        small.problem.prior.sd[[own.bias_i.start, own.bias_q.start]] = 0.4
    own, theta = small.problem.layout.receivers[2], small.truth.theta.copy()
    at, moving = linearise(small.problem, small.truth), small.problem.bins.time_s > START_S
    share = np.abs(small.problem.inputs.bias[moving, 0] / at.signals[2].field[moving])
    theta[own.bias_i.start] = beyond / share.max()
    problem = replace(
        small.problem,
        in_flight=np.full(small.problem.in_flight.size, flies),
        sphere=None if point else SimpleNamespace(),  # type: ignore[arg-type]
    )
    solution: Any = SimpleNamespace(problem=problem, state=replace(small.truth, theta=theta), at=at)
    at.residual[4:] *= np.sqrt(misfit / chi_square(solution)[2])
    return is_lost(solution, START_S)


def test_maps_that_have_grown_in_all_receivers_and_still_explain_nothing_are_lost() -> None:
    assert lost()
    assert not lost(misfit=GOOD)


def test_an_offset_beyond_its_wave_is_lost_whatever_the_misfit() -> None:
    assert lost(misfit=GOOD, beyond=1.5)


@pytest.mark.parametrize("kept", [{"loose": (0, 1)}, {"flies": True}, {"point": True}])
def test_one_stiff_receiver_or_a_flight_holds_a_motion_and_a_point_has_maps_for_what_it_is(
    kept: dict[str, Any],
) -> None:
    assert not lost(**kept)
