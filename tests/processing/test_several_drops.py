"""Several drops in one record: one is measured from its rest, all other motions are told with their times."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.changed import changed
from support.simulated_setup import simulated_setup

from radargui.model.errors import ProcessingError
from radargui.model.recording import Gap, Recording, Truth
from radargui.model.result import RunResult
from radargui.model.setup import Setup
from radargui.processing.process import process
from radargui.sources.simulated.model import SimulatedRadar
from radargui.sources.simulated.scene import RETURN_S

RATE_HZ, REST_S, SETTLE_S = 5000.0, 0.7, 0.6


def _setup(correction: str) -> Setup:
    setup = simulated_setup(
        daq={"rate_hz": RATE_HZ},
        floor={"height_m": 0.0},
        restitution=0.4,
        rest_s=REST_S,
        settle_s=SETTLE_S,
        snr_db=40.0,
        mismatch=0.0,
    )
    return setup.model_copy(update={"processing": setup.processing.model_copy(update={"correction": correction})})


def _two_drops(setup: Setup, begin_s: float = 0.0) -> tuple[Recording, Truth]:
    """Return a drop, the hand that carries the sphere back, and the next drop, from a time on."""
    radar = SimulatedRadar(setup, repeat=True)
    period_s = REST_S + radar.scene.trajectory.duration_s + SETTLE_S + RETURN_S
    first, last = (round(time_s * RATE_HZ) for time_s in (begin_s, 2.0 * period_s - RETURN_S))
    recording = Recording("two drops", radar.samples(first, last - first), radar.digitisation)
    return recording, radar.truth(first, last - first)


def _moves(truth: Truth) -> tuple[np.ndarray, np.ndarray]:
    """Return when the motions begin and end: rests of more than half a second lie between them."""
    moves = np.flatnonzero(np.diff(truth.position_m, axis=1).any(axis=0)) / RATE_HZ
    apart = np.flatnonzero(np.diff(moves) > 0.5)
    return np.append(moves[0], moves[apart + 1]), np.append(moves[apart], moves[-1])


def _further(result: RunResult) -> list[tuple[float, float]]:
    return [(one.facts["begin_s"], one.facts["end_s"]) for one in result.findings if one.code == "further_motion"]


def test_the_first_drop_is_measured_from_its_rest_and_the_other_motions_are_told() -> None:
    setup = _setup("flights")
    recording, truth = _two_drops(setup)
    result = process(recording, setup)
    assert result.status == "ok"
    assert result.corrected is not None
    assert result.corrected.method == "flights"
    assert {one.code for one in result.findings} == {"further_motion"}
    first = result.bounces.impacts[0]
    assert first.time_s == pytest.approx(truth.impact_time_s[0], abs=2e-4)
    assert first.e == pytest.approx(0.4, abs=4.0 * first.u_stated)
    begins_s, ends_s = _moves(truth)
    hand, second = _further(result)
    # a hand's slow start and end, and a fall's, are seen late
    assert hand == pytest.approx((begins_s[1], ends_s[1]), abs=0.25)
    assert second == pytest.approx((begins_s[2], ends_s[2]), abs=0.1)
    track = result.track
    assert track is not None
    # nothing is said of where the sphere is in the motions that are only told
    assert track.time_s[track.valid][-1] < begins_s[1]
    assert all(one.time_s < begins_s[1] for one in result.bounces.impacts)


@pytest.mark.slow
def test_another_drop_of_the_record_is_measured_where_the_setup_asks_for_it() -> None:
    setup = changed(_setup("flights"), processing={"drop": 2})
    recording, truth = _two_drops(setup)
    result = process(recording, setup)
    begins_s, _ = _moves(truth)
    second = next(time_s for time_s in truth.impact_time_s if time_s > begins_s[2])
    first = result.bounces.impacts[0]
    assert first.time_s == pytest.approx(second, abs=2e-4)
    assert first.e == pytest.approx(0.4, abs=4.0 * first.u_stated)
    assert [begin_s for begin_s, _ in _further(result)] == pytest.approx(begins_s[:2], abs=0.25)
    asked_too_much = changed(setup, processing={"drop": 3})
    with pytest.raises(ProcessingError, match="drop 3 is asked for, and 2 of the motions"):
        process(recording, asked_too_much)


@pytest.mark.slow
def test_a_drop_after_another_motion_is_measured_from_its_own_rest() -> None:
    setup = _setup("flights")
    _, both = _two_drops(setup)
    carried_s = _moves(both)[0][1]
    # the sphere lies on the floor, is carried to the release, rests and falls
    recording, truth = _two_drops(setup, carried_s - 0.5 * SETTLE_S)
    result = process(recording, setup)
    assert result.corrected is not None
    assert result.corrected.method == "flights"
    first = result.bounces.impacts[0]
    assert first.time_s == pytest.approx(truth.impact_time_s[0], abs=2e-4)
    assert first.e == pytest.approx(0.4, abs=4.0 * first.u_stated)
    ((_, ended_s),) = _further(result)
    assert ended_s < first.time_s - 0.5


def test_lost_samples_before_do_not_shift_the_motions() -> None:
    setup = _setup("flights")
    recording, truth = _two_drops(setup)
    gap = Gap(100, 50, "lost")
    lossy = replace(recording, raw=np.delete(recording.raw, np.s_[100:150], axis=1), gaps=(gap,))
    result = process(lossy, setup)
    assert len(_further(result)) == 2
    assert result.bounces.impacts[0].time_s == pytest.approx(truth.impact_time_s[0], abs=2e-4)


@pytest.mark.slow
def test_the_joint_estimate_is_that_of_the_drop_by_itself() -> None:
    setup = _setup("joint")
    recording, truth = _two_drops(setup)
    alone = round((_moves(truth)[1][0] + 0.5 * SETTLE_S) * RATE_HZ)
    both, one = (process(part, setup) for part in (recording, replace(recording, raw=recording.raw[:, :alone])))
    for result in (both, one):
        assert result.corrected is not None
        assert result.corrected.method == "joint"
    assert both.bounces.impacts[0].e == pytest.approx(one.bounces.impacts[0].e, abs=one.bounces.impacts[0].u_stated)
    assert len(_further(both)) == 2


def test_circles_measure_all_motions_of_a_record() -> None:
    setup = _setup("adaptive")
    recording, truth = _two_drops(setup)
    result = process(recording, setup)
    assert _further(result) == []
    second_s = truth.impact_time_s[truth.impact_time_s.size // 2]
    assert min(abs(one.time_s - second_s) for one in result.bounces.impacts) < 1e-3
