"""Hands-free: drop after drop from one source, nothing lost between them, the hand set aside, results in order."""

from __future__ import annotations

import threading
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.changed import changed
from support.controlled_source import LONGEST_S, ControlledSource, codes
from support.one_run import record_run
from support.run_contents import read_run_truth, read_summary
from support.simulated_setup import simulated_setup

from radargui.acquisition.run_plan import Ending, RecorderState
from radargui.experiment.event import Event, EventKind, ExperimentState, RecordedRun
from radargui.experiment.processing_apart import ProcessingApart, ProcessingHere
from radargui.experiment.series import Experiment
from radargui.files.run_card import read_health
from radargui.files.run_file import read_run
from radargui.model.errors import DeviceError
from radargui.model.setup import Setup
from radargui.session.session import Session
from radargui.sources.contract import Source
from radargui.sources.simulated.model import SimulatedRadar, SimulatedSource

NOW = datetime(2026, 11, 20, 15, 4, 5, tzinfo=UTC)


def drops() -> Setup:
    """Quick drops that are processed in a moment."""
    setup = simulated_setup(snr_db=45.0, mismatch=0.005, restitution=0.5, rest_s=0.5, settle_s=0.5)
    return changed(
        setup,
        recording={"pretrigger_s": 0.3, "quiet_s": 0.3, "maximum_s": 5.0, "wait_s": 20.0},
        processing={"correction": "ellipse"},
    )


class Endless(SimulatedSource):
    """Counts how often it was opened."""

    opened = 0

    def open(self):  # type: ignore[no-untyped-def]
        type(self).opened += 1
        return super().open()


def series(
    folder: Path,
    setup: Setup,
    source: Callable[[int], Source],
    *,
    live: bool = False,
    processing: Callable[[], ProcessingApart] | None = None,
    then: Callable[[Experiment, Event], None] = lambda _experiment, _event: None,
) -> tuple[Experiment, list[Event]]:
    """Return an experiment that goes on from one source, and its events; `then` is told of each."""
    events: list[Event] = []

    def told(event: Event) -> None:
        events.append(event)
        then(made, event)

    session = Session.create(folder, setup, now=NOW)
    made = Experiment(
        setup, source, session, listener=told, live=live, patient=True, continuous=True, processing=processing
    )
    return made, events


def test_three_drops_are_recorded_hands_free_and_the_hand_in_between_is_set_aside(tmp_path: Path) -> None:
    setup = drops()
    Endless.opened = 0
    experiment, events = series(tmp_path, setup, lambda _: Endless(setup, repeat=True))
    runs = list(experiment.record(3))
    assert Endless.opened == 1
    wanted = [run for run in runs if not run.set_aside]
    aside = [run for run in runs if run.set_aside]
    assert [run.number for run in wanted] == [1, 3, 5]
    assert [run.number for run in aside] == [2, 4]
    assert all(run.result is not None and run.result.status == "ok" for run in wanted)
    assert all(run.result is None and "set aside, nothing in it falls freely" in run.message for run in aside)
    session = experiment.session
    assert [path.name for path in session.run_paths()] == ["run-0001.h5", "run-0003.h5", "run-0005.h5"]
    assert dict(session.rejected) == {
        "run-0002.h5": "nothing in it falls freely",
        "run-0004.h5": "nothing in it falls freely",
    }
    whole = SimulatedRadar(setup, repeat=True)
    for path in session.run_paths(with_rejected=True):
        stored, health = read_run(path), read_health(path)
        assert health is not None
        assert health["samples_recorded"] == stored.n_samples
        truth = read_run_truth(path)
        assert truth is not None
        assert stored.trigger_index is not None
        assert 0 < stored.trigger_index <= 3000
    first = read_run(session.run_paths()[1])
    seconds = (
        datetime.fromisoformat(first.started_at) - datetime.fromisoformat(read_run(session.run_paths()[0]).started_at)
    ).total_seconds()
    # one period of the scene lies between the two starts
    period = whole.scene.period_s
    assert seconds == pytest.approx(period, abs=0.1)
    states = [event.state for event in events if event.kind is EventKind.STATE]
    assert states.count(ExperimentState.ARMED) == 5
    assert states.count(ExperimentState.RECORDING) == 5
    assert states[-2:] == [ExperimentState.PROCESSING, ExperimentState.DONE]


def test_every_sample_between_two_drops_was_taken_from_one_stream(tmp_path: Path) -> None:
    setup = drops()
    experiment, _ = series(tmp_path, setup, lambda _: SimulatedSource(setup, repeat=True))
    runs = [read_run(run.path) for run in experiment.record(2) if run.path]
    whole = SimulatedRadar(setup, repeat=True).samples(0, sum(run.n_samples for run in runs) + 60_000)
    begun, ended, end = runs[0].started_at, [], 0
    for run in runs:
        # when it began says where it lies, to a millisecond
        since = datetime.fromisoformat(run.started_at) - datetime.fromisoformat(begun)
        places = np.flatnonzero((whole == run.raw[:, :1]).all(axis=0))
        first = next(one for one in places if np.array_equal(whole[:, one : one + run.n_samples], run.raw))
        if ended:
            assert since.total_seconds() == pytest.approx((first - ended[0]) / 10000, abs=2e-3)
            # the pre-trigger history of the next one reaches back into the quiet end of the one before
            assert end - 0.3 * 10000 - 400 < first <= end + 15000
        ended.append(first)
        end = first + run.n_samples
    assert len(runs) == 3


def test_a_run_set_aside_can_be_taken_back_and_processed(tmp_path: Path) -> None:
    setup = drops()
    experiment, _ = series(tmp_path, setup, lambda _: SimulatedSource(setup, repeat=True))
    runs = list(experiment.record(2))
    session = experiment.session
    hand = next(run.path for run in runs if run.set_aside)
    assert hand is not None
    assert hand not in session.run_paths()
    session.restore(hand)
    assert hand in session.run_paths()
    session.reject(hand, "false trigger")
    assert Session.open(session.path).rejected == {hand.name: "false trigger"}


def test_a_run_that_the_operator_rejects_is_recorded_again(tmp_path: Path) -> None:
    setup = changed(drops(), recording={"falls_only": False})
    source = ControlledSource()

    def listen(experiment: Experiment, event: Event) -> None:
        if event.kind is EventKind.STATE and event.state is ExperimentState.ARMED and event.number == 2:
            (first,) = experiment.session.run_paths()
            experiment.reject(first)
            experiment.reject(first, "a cable moved")
            source.push_all(codes(14000, moving=slice(5000, 9000), seed=2))
            source.push_all(codes(14000, moving=slice(5000, 9000), seed=3))

    experiment, _ = series(tmp_path, setup, lambda _: source, then=listen)
    source.push_all(codes(14000, moving=slice(5000, 9000)))
    runs = list(experiment.record(2))
    assert [run.number for run in runs] == [1, 2, 3]
    assert experiment.session.rejected == {"run-0001.h5": "a cable moved"}
    assert len(experiment.session.run_paths()) == 2


def test_all_that_moves_is_a_run_where_the_setup_says_so(tmp_path: Path) -> None:
    setup = changed(drops(), recording={"falls_only": False})
    experiment, _ = series(tmp_path, setup, lambda _: SimulatedSource(setup, repeat=True))
    runs = list(experiment.record(2))
    assert [run.set_aside for run in runs] == ["", ""]
    assert [run.number for run in runs] == [1, 2]


def test_a_run_is_processed_while_the_next_is_armed_and_results_come_in_order(tmp_path: Path) -> None:
    setup = changed(drops(), recording={"falls_only": False})
    source = ControlledSource()
    go, armed_again = threading.Event(), threading.Event()
    armed = 0

    class Waiting(ProcessingHere):
        """Does a job once it may."""

        def process(self, *job: Any) -> Any:
            assert go.wait(LONGEST_S)
            return super().process(*job)

    def listen(_: Experiment, event: Event) -> None:
        nonlocal armed
        armed += event.kind is EventKind.STATE and event.state is ExperimentState.ARMED
        if armed == 2:
            armed_again.set()

    experiment, events = series(tmp_path, setup, lambda _: source, processing=Waiting, then=listen)
    runs: list[RecordedRun] = []
    worker = threading.Thread(target=lambda: runs.extend(experiment.record(2)))
    worker.start()
    source.push_all(codes(14000, moving=slice(5000, 9000)))
    # the first run waits for its processing, and the next one is armed all the same
    assert armed_again.wait(LONGEST_S)
    assert not any(event.kind is EventKind.RUN for event in events)
    source.push_all(codes(14000, moving=slice(5000, 9000), seed=2))
    go.set()
    worker.join(LONGEST_S)
    assert [run.number for run in runs] == [1, 2]
    assert [run.path.name for run in runs if run.path] == ["run-0001.h5", "run-0002.h5"]


def test_the_agreement_of_live_and_result_is_kept_with_the_run(tmp_path: Path) -> None:
    setup = simulated_setup(mismatch=0.005, restitution=0.5, rest_s=0.5, settle_s=0.6)
    setup = changed(setup, processing={"correction": "ellipse"}, daq={"rate_hz": 5000.0})
    session = Session.create(tmp_path, setup, now=NOW)
    experiment = Experiment(setup, lambda run: SimulatedSource(setup, run=run, realtime=True), session)
    run = record_run(experiment)
    assert run.path is not None
    assert run.agreement is not None
    assert run.agreement.rms_m < 0.3e-3
    assert run.agreement.max_m < 2e-3
    assert run.agreement.share_known == 1.0
    assert "live within 0." in run.message
    health = read_health(run.path)
    assert health is not None
    assert health["live_rms_m"] == run.agreement.rms_m
    assert health["samples_recorded"] == read_run(run.path).n_samples
    assert read_summary(run.path) is not None
    assert experiment.memory.is_warm


def test_a_motion_without_end_is_settling_until_it_is_quiet(tmp_path: Path) -> None:
    setup = changed(drops(), recording={"falls_only": False, "maximum_s": 0.4, "quiet_s": 0.1})
    source = ControlledSource()
    source.push_all(codes(30000, moving=slice(5000, 14000)))
    source.push_all(codes(14000, moving=slice(5000, 6000), seed=3))
    experiment, events = series(tmp_path, setup, lambda _: source)
    runs = list(experiment.record(2))
    assert [run.ending for run in runs] == [Ending.MAXIMUM, Ending.QUIET]
    states = [event.state for event in events if event.kind is EventKind.STATE]
    settling = states.index(ExperimentState.SETTLING)
    assert states[settling - 1 : settling + 3] == [
        ExperimentState.RECORDING,
        ExperimentState.SETTLING,
        ExperimentState.ARMED,
        ExperimentState.RECORDING,
    ]


def test_stopping_between_two_drops_keeps_those_that_were_recorded(tmp_path: Path) -> None:
    setup = changed(drops(), recording={"falls_only": False})
    source = ControlledSource()
    source.push_all(codes(14000, moving=slice(5000, 9000)))
    experiment, _ = series(tmp_path, setup, lambda _: source)
    runs = []
    for run in experiment.record(5):
        runs.append(run)
        experiment.finish()
    assert [run.path is None for run in runs] == [False, True]
    assert runs[1].message == "No run was recorded: stopped by the operator."


def test_a_device_that_fails_between_two_drops_is_told_after_the_results(tmp_path: Path) -> None:
    setup = changed(drops(), recording={"falls_only": False})
    source = ControlledSource()
    source.push_all(codes(14000, moving=slice(5000, 9000)))
    source.fail(DeviceError("The device was removed"))
    experiment, events = series(tmp_path, setup, lambda _: source)
    runs: list[RecordedRun] = []
    with pytest.raises(DeviceError, match="The device was removed"):
        runs.extend(experiment.record(3))
    told = [event.run for event in events if event.kind is EventKind.RUN]
    assert [run.number for run in told if run] == [1]
    assert told[0] is not None
    assert told[0].result is not None
    assert experiment.state is ExperimentState.FAILED


def test_cancel_leaves_a_series_at_once_and_what_was_recorded_is_kept(tmp_path: Path) -> None:
    setup = changed(drops(), recording={"falls_only": False})
    source = ControlledSource()
    source.push_all(codes(14000, moving=slice(5000, 9000)))

    def stop(experiment: Experiment, event: Event) -> None:
        if event.kind is EventKind.STATE and event.number == 2:
            experiment.cancel()

    experiment, _ = series(tmp_path, setup, lambda _: source, then=stop)
    runs = list(experiment.record(9))
    assert runs[0].path is not None
    assert source.calls[-1] == "close"
    assert experiment.acquisition is not None
    recorder = experiment.acquisition.recorder
    assert recorder is not None
    assert recorder.state is RecorderState.DONE
