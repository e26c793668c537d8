"""A drop by its flights as what the joint estimate begins with: motion, setup, floor and front ends go over whole."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from benchmarks.gate.worker import setup_of_version
from benchmarks.world.kinds import PopulationRecord, draw
from support.estimates import conditioned_of

from radargui.estimation.flights.estimate import DropEstimate, estimate_drop
from radargui.estimation.select.fall import FoundFall
from radargui.estimation.signals import scaled_signals
from radargui.estimation.solve.minimise import solved_at
from radargui.model.setup import Setup
from radargui.physics.mirrors import has_floor


def _found(**held: Any) -> tuple[PopulationRecord, Setup, FoundFall]:
    usual = {"rate_hz": 10000.0, "height_m": 0.2, "snr_db": 35.0, "walls": 0, "told": True, "amplitude_v": 0.5}
    scene = draw("modelled", 44, 0, {**usual, "exact": False, **held})
    setup, _ = setup_of_version(scene.setup)
    record = scene.record()
    signals = scaled_signals(conditioned_of(record.recording, setup))
    estimate = estimate_drop(signals, setup)
    assert isinstance(estimate, DropEstimate)
    return record, setup, FoundFall.of(estimate, signals, setup)


@pytest.fixture(scope="module")
def strong() -> tuple[PopulationRecord, Setup, FoundFall]:
    """The sphere still bounces when the record ends."""
    return _found(floor=0.8, e=0.7, exchange=True)


@pytest.mark.slow
def test_a_start_is_near_its_signals_where_the_floor_that_was_found_is_in_it(
    strong: tuple[PopulationRecord, Setup, FoundFall],
) -> None:
    found = strong[2]
    bare, floored = (solved_at(start) for start in found.starts(found.data, 0.09, None))
    assert not has_floor(bare.problem.inputs.planes)
    assert has_floor(floored.problem.inputs.planes)
    while_followed = found.data.bins.time_s < found.estimate.end_s
    # of the two channels of each receiver together, which one wave fills
    left, without = (
        np.median(one.at.residual[:, while_followed] ** 2, axis=1).reshape(-1, 2).sum(axis=1) for one in (floored, bare)
    )
    # no step has been taken: maps take what is left
    assert (left < 1e-2 * without).all()


def test_a_start_flies_from_the_antennas_that_the_flights_found(
    strong: tuple[PopulationRecord, Setup, FoundFall],
) -> None:
    _, _, found = strong
    start = found.starts(found.data, 0.09, None)[1]
    assert start.problem.in_flight.any()
    stated = found.estimate.model.setup
    now = start.problem.placed(start.state.theta).inputs.antennas
    wanted = stated.antennas(found.estimate.at.values.setup)
    moved = np.linalg.norm(wanted.receivers_m - stated.antennas(stated.stated).receivers_m, axis=1)
    assert moved.max() > 1e-4
    # over turns of a degree the unknowns of the joint estimate are straight
    assert np.linalg.norm(now.receivers_m - wanted.receivers_m, axis=1).max() < 0.1 * moved.max()


def test_what_bounces_on_unfollowed_is_expected_to_and_then_lies(
    strong: tuple[PopulationRecord, Setup, FoundFall],
) -> None:
    record, _, lies = _found(floor=0.3, e=0.35)
    impacts = [impact[0] for impact in record.impacts]
    assert lies.estimate.flights.impact_s.size < len(impacts)
    assert lies.lies_s < lies.signals.time_s[-1]
    assert np.abs(lies.break_s[-1] - impacts).min() < 0.01
    at_end = lies.offset_m(np.array([lies.lies_s, lies.signals.time_s[-1]]))
    assert at_end[2, 1] == pytest.approx(at_end[2, 0], abs=1e-9)
    # one that is still in the air flies to the end
    assert strong[2].break_s.tolist() == strong[2].flights.impact_s.tolist()
