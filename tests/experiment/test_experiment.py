"""The experiment arms, records, processes and saves; both doors call it."""

from __future__ import annotations

import threading
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, NoReturn

import h5py
import numpy as np
import pytest
from support.changed import changed
from support.controlled_source import LONGEST_S, ControlledSource, codes
from support.one_run import record_run
from support.run_contents import read_run_truth, read_summary
from support.simulated_recording import simulate_recording
from support.simulated_setup import simulated_setup

from radargui.acquisition.run_plan import AcquisitionState, Ending
from radargui.experiment.event import Event, EventKind, ExperimentState, RecordedRun
from radargui.experiment.processing_apart import ProcessingApart, ProcessingHere
from radargui.experiment.series import Experiment
from radargui.files.run_file import read_run, run_is_complete
from radargui.files.run_results import results_are_current
from radargui.model.errors import DeviceError, ProcessingError, SourceError
from radargui.model.setup import Setup
from radargui.processing.process import STOPPED
from radargui.session.session import Session
from radargui.sources.contract import Source
from radargui.sources.simulated.model import SimulatedSource

NOW = datetime(2026, 11, 20, 15, 4, 5, tzinfo=UTC)
QUIET = {"recording": {"pretrigger_s": 0.3, "quiet_s": 0.3, "maximum_s": 5.0, "wait_s": 20.0}}


def drop_setup(**simulation: object) -> Setup:
    settings = {"snr_db": 45.0, "mismatch": 0.01, "restitution": 0.6, "rest_s": 0.5, "settle_s": 0.5, **simulation}
    setup = simulated_setup(**settings)
    return Setup.model_validate({**setup.model_dump(by_alias=True, exclude_unset=True), **QUIET})


class Listener:
    """Keeps the events; may do something at the first that is in a state."""

    def __init__(self) -> None:
        self.events: list[Event] = []
        self.reactions: dict[ExperimentState, Callable[[], None]] = {}

    def __call__(self, event: Event) -> None:
        self.events.append(event)
        reaction = self.reactions.pop(event.state, None)
        if reaction is not None:
            reaction()

    @property
    def states(self) -> list[ExperimentState]:
        return [event.state for event in self.events if event.kind is EventKind.STATE]

    def of(self, kind: EventKind) -> list[Event]:
        return [event for event in self.events if event.kind is kind]


def experiment(
    folder: Path,
    setup: Setup,
    source: Callable[[int], Source] | None = None,
    *,
    seconds: float | None = None,
    process: bool = True,
    processing: Callable[[], ProcessingApart] | None = None,
    then: Callable[[Experiment, Event], None] = lambda _experiment, _event: None,
) -> tuple[Experiment, Listener]:
    """Return an experiment and its events; `then` is told of each."""
    listener = Listener()

    def told(event: Event) -> None:
        listener(event)
        then(made, event)

    session = Session.create(folder, setup, now=NOW)
    made = Experiment(
        setup,
        source or (lambda run: SimulatedSource(setup, run=run)),
        session,
        seconds=seconds,
        process=process,
        processing=processing,
        listener=told,
        live=False,
        patient=True,
        attributes={"source": "test"},
    )
    return made, listener


def test_a_simulated_drop_is_recorded_bit_exact_with_its_truth_processed_and_saved(tmp_path: Path) -> None:
    setup = drop_setup()
    an_experiment, listener = experiment(tmp_path, setup)
    run = record_run(an_experiment)
    assert run.path == tmp_path / "2026-11-20T15-04-05" / "run-0001.h5"
    assert run.ending in (Ending.QUIET, Ending.END_OF_DATA)
    whole, truth = simulate_recording(setup)
    stored = read_run(run.path)
    recorder = an_experiment.acquisition and an_experiment.acquisition.recorder
    assert recorder is not None
    first, last = recorder.output.first_index, recorder.output.first_index + recorder.count
    assert recorder.count > 8000
    assert np.array_equal(stored.raw, whole.raw[:, first:last])
    assert stored.trigger_index == 3000
    assert first + 3000 == pytest.approx(5000, abs=300)
    assert stored.gaps == ()
    kept = read_run_truth(run.path)
    assert kept is not None
    assert np.array_equal(kept.position_m, truth.position_m[:, first:last])
    inside = truth.impact_time_s[truth.impact_time_s < last / 10000.0]
    np.testing.assert_allclose(kept.impact_time_s, inside - first / 10000.0, atol=1e-9)
    assert run.result is not None
    assert run.result.status == "ok"
    bounce = run.result.bounces.impacts[0]
    assert bounce.e == pytest.approx(0.6, rel=0.05)
    summary = read_summary(run.path)
    assert summary is not None
    assert summary["e"] == pytest.approx(bounce.e)
    assert an_experiment.state is ExperimentState.DONE
    assert listener.states == [
        ExperimentState.ARMED,
        ExperimentState.RECORDING,
        ExperimentState.PROCESSING,
        ExperimentState.DONE,
    ]
    fractions = [event.fraction for event in listener.of(EventKind.PROGRESS)]
    assert fractions == sorted(fractions)  # type: ignore[type-var]
    assert "e = 0." in listener.of(EventKind.RUN)[0].message


def test_runs_follow_each_other_with_other_noise_in_files_of_their_own(tmp_path: Path) -> None:
    an_experiment, listener = experiment(tmp_path, drop_setup(), process=False)
    runs = list(an_experiment.record(2))
    assert [run.path and run.path.name for run in runs] == ["run-0001.h5", "run-0002.h5"]
    assert [run.result for run in runs] == [None, None]
    first, second = (read_run(run.path) for run in runs if run.path)
    n = min(first.n_samples, second.n_samples)
    assert not np.array_equal(first.raw[:, :n], second.raw[:, :n])
    assert [event.number for event in listener.of(EventKind.RUN)] == [1, 2]
    assert ExperimentState.PROCESSING not in listener.states


def test_a_fixed_time_is_recorded_without_waiting_for_motion(tmp_path: Path) -> None:
    setup = drop_setup(scene="rest", settle_s=2.0)
    an_experiment, listener = experiment(tmp_path, setup, seconds=0.5)
    run = record_run(an_experiment)
    assert run.path is not None
    assert read_run(run.path).n_samples == 5000
    assert run.ending is Ending.SECONDS
    assert run.result is not None
    assert run.result.status == "no_motion"
    assert ExperimentState.ARMED not in listener.states
    assert "no motion" in run.message


def test_a_scene_in_which_nothing_moves_ends_with_a_clear_message_and_no_file(tmp_path: Path) -> None:
    an_experiment, listener = experiment(tmp_path, drop_setup(scene="rest"))
    runs = list(an_experiment.record(3))
    assert len(runs) == 1
    assert runs[0].path is None
    assert runs[0].message == "No run was recorded: nothing moved as much as the trigger asks for until the end."
    assert an_experiment.state is ExperimentState.IDLE
    assert an_experiment.session.run_paths() == ()
    assert len(listener.of(EventKind.RUN)) == 1


def test_waiting_for_motion_has_a_limit(tmp_path: Path) -> None:
    setup = drop_setup()
    limited = setup.model_copy(update={"recording": setup.recording.model_copy(update={"wait_s": 0.3})})
    source = ControlledSource()
    source.push_all(codes(4000))
    an_experiment, _ = experiment(tmp_path, limited, lambda _: source)
    run = record_run(an_experiment)
    assert run.ending is Ending.WAITED
    assert "nothing moved in the time allowed" in run.message
    assert source.calls[-1] == "close"


def test_a_source_that_fails_leaves_its_file_and_says_where_it_is(tmp_path: Path) -> None:
    source = ControlledSource()
    samples = codes(12000, moving=slice(5000, 12000))
    source.push_all(samples)
    source.fail(DeviceError("The device was removed", remedy="Plug it in again."))
    an_experiment, listener = experiment(tmp_path, drop_setup(), lambda _: source)
    with pytest.raises(
        DeviceError, match=r"The device was removed\. Plug it in again\. What was recorded is kept in .*h5"
    ):
        record_run(an_experiment)
    assert an_experiment.state is ExperimentState.FAILED
    (path,) = an_experiment.session.run_paths()
    assert np.array_equal(read_run(path).raw[:, -2000:], samples[:, -2000:])
    assert not run_is_complete(path)
    assert listener.events[-1].error is not None


def test_a_source_that_cannot_be_made_is_told(tmp_path: Path) -> None:
    def refuse(_: int) -> Source:
        raise SourceError("No such device")

    an_experiment, listener = experiment(tmp_path, drop_setup(), refuse)
    with pytest.raises(SourceError, match="No such device"):
        record_run(an_experiment)
    assert listener.states == [ExperimentState.FAILED]


class Refusing(ProcessingHere):
    """Refuses each job."""

    def process(self, *_: object) -> NoReturn:
        raise ProcessingError("It does not fit")


def test_a_failed_processing_keeps_the_recording_and_the_series_goes_on(tmp_path: Path) -> None:
    an_experiment, listener = experiment(tmp_path, drop_setup(), processing=Refusing)
    runs = list(an_experiment.record(2))
    assert len(runs) == 2
    assert all(isinstance(run.error, ProcessingError) and run.result is None for run in runs)
    assert runs[0].path is not None
    assert run_is_complete(runs[0].path)
    assert "What was recorded is kept in" in str(runs[0].error)
    assert listener.states[-1] is ExperimentState.FAILED


def test_finish_ends_a_recording_and_processes_it(tmp_path: Path) -> None:
    source = ControlledSource()
    source.push_all(codes(9000, moving=slice(5000, 9000)))
    an_experiment, listener = experiment(tmp_path, drop_setup(), lambda _: source)
    listener.reactions[ExperimentState.RECORDING] = lambda: (source.wait_until_taken(), an_experiment.finish())
    (run,) = an_experiment.record(3)
    assert run.ending is Ending.STOPPED
    assert run.result is not None
    assert run_is_complete(an_experiment.session.run_paths()[0])


def test_cancel_while_recording_keeps_the_file_and_processes_nothing(tmp_path: Path) -> None:
    source = ControlledSource()
    source.push_all(codes(9000, moving=slice(5000, 9000)))
    an_experiment, listener = experiment(tmp_path, drop_setup(), lambda _: source)
    listener.reactions[ExperimentState.RECORDING] = lambda: (source.wait_until_taken(), an_experiment.cancel())
    runs = list(an_experiment.record(5))
    assert len(runs) == 1
    assert runs[0].path is not None
    assert runs[0].result is None
    assert run_is_complete(runs[0].path)
    assert ExperimentState.PROCESSING not in listener.states
    assert an_experiment.is_cancelled


def test_cancel_while_armed_ends_at_once_without_a_file(tmp_path: Path) -> None:
    source = ControlledSource()
    an_experiment, listener = experiment(tmp_path, drop_setup(), lambda _: source)
    listener.reactions[ExperimentState.ARMED] = an_experiment.cancel
    run = record_run(an_experiment)
    assert run.message == "No run was recorded: stopped by the operator."
    assert source.calls[-1] == "close"


def test_cancel_while_processing_keeps_the_recording(tmp_path: Path) -> None:
    an_experiment, listener = experiment(tmp_path, drop_setup())
    listener.reactions[ExperimentState.PROCESSING] = an_experiment.cancel
    run = record_run(an_experiment)
    assert run.path is not None
    assert run.result is None
    assert run.error is None
    assert read_summary(run.path) is None


def test_a_cancelled_experiment_records_nothing_more(tmp_path: Path) -> None:
    source = ControlledSource()
    an_experiment, _ = experiment(tmp_path, drop_setup(), lambda _: source)
    an_experiment.cancel()
    assert list(an_experiment.record(3)) == []
    assert source.calls == []


def test_lost_samples_are_told_to_the_listener_and_by_the_result(tmp_path: Path) -> None:
    source = ControlledSource()
    samples = codes(14000, moving=slice(5000, 9000))
    source.push_all(samples[:, :4500])
    source.push(samples[:, 4600:4800], lost=100)
    source.push_all(samples[:, 4800:])
    an_experiment, listener = experiment(tmp_path, drop_setup(), lambda _: source)
    run = record_run(an_experiment)
    warnings = [event.message for event in listener.of(EventKind.WARNING)]
    assert any("100 samples of each channel were lost by the source" in warning for warning in warnings)
    assert run.result is not None
    assert run.result.recording.gaps[0].count == 100
    assert any("gaps" in warning for warning in run.result.warnings)


def test_the_acquisition_can_be_pulled_from_while_it_runs(tmp_path: Path) -> None:
    source = ControlledSource()
    an_experiment, _ = experiment(tmp_path, drop_setup(), lambda _: source)
    worker = threading.Thread(target=record_run, args=(an_experiment,))
    worker.start()
    assert source.running.wait(LONGEST_S)
    source.push_all(codes(3000))
    source.wait_until_taken()
    acquisition = an_experiment.acquisition
    assert acquisition is not None
    assert acquisition.state is AcquisitionState.RUNNING
    assert acquisition.ring is not None
    assert acquisition.ring.latest == 3000
    an_experiment.cancel()
    worker.join(LONGEST_S)
    assert not worker.is_alive()


def test_further_facts_are_kept_with_the_run(tmp_path: Path) -> None:
    an_experiment, _ = experiment(tmp_path, drop_setup(), process=False)
    run = record_run(an_experiment)
    with h5py.File(run.path) as file:
        source = file.attrs["source"]
    assert source in ("test", b"test")


def test_the_next_source_is_armed_while_the_run_before_is_processed(tmp_path: Path) -> None:
    armed_again = threading.Event()

    class Waiting(ProcessingHere):
        """Does a job once the next run is armed."""

        def process(self, *job: Any) -> Any:
            assert armed_again.wait(LONGEST_S)
            return super().process(*job)

    def listen(_: Experiment, event: Event) -> None:
        if event.state is ExperimentState.ARMED and event.number == 2:
            armed_again.set()

    an_experiment, listener = experiment(tmp_path, drop_setup(), processing=Waiting, then=listen)
    runs = list(an_experiment.record(2))
    assert [(run.number, run.result is not None) for run in runs] == [(1, True), (2, True)]
    assert listener.states == [
        *2 * [ExperimentState.ARMED, ExperimentState.RECORDING],
        ExperimentState.PROCESSING,
        ExperimentState.DONE,
    ]


def test_a_second_source_that_cannot_be_made_is_told_after_the_first_result(tmp_path: Path) -> None:
    setup = drop_setup()

    def once(run: int) -> Source:
        if run:
            raise SourceError("No such device any more")
        return SimulatedSource(setup)

    an_experiment, listener = experiment(tmp_path, setup, once)
    runs: list[RecordedRun] = []
    with pytest.raises(SourceError, match="any more"):
        runs.extend(an_experiment.record(3))
    told = [event.run for event in listener.of(EventKind.RUN)]
    assert [run.result is not None for run in told if run] == [True]
    assert listener.states[-1] is ExperimentState.FAILED


JOINT_DROP = changed(drop_setup(), processing={"correction": "joint"}, recording={"maximum_s": 0.8})


def test_cancelling_in_the_joint_correction_keeps_the_preliminary_result_and_says_so(tmp_path: Path) -> None:
    def stop(experiment: Experiment, event: Event) -> None:
        if event.kind is EventKind.PRELIMINARY:
            experiment.cancel()

    an_experiment, listener = experiment(tmp_path, JOINT_DROP, then=stop)
    run = record_run(an_experiment)
    (event,) = listener.of(EventKind.PRELIMINARY)
    assert event.run is not None
    assert event.run.result is not None
    assert event.run.result.preliminary
    assert event.message.endswith(", preliminary")
    assert event.run.result.bounces.impacts[0].e == pytest.approx(0.6, rel=0.02)
    assert run.error is None
    assert run.result is not None
    assert run.result.preliminary
    assert run.result.findings[0] == STOPPED
    assert run.path is not None
    summary = read_summary(run.path) or {}
    assert (summary["correction"], summary["preliminary"]) == ("flights", True)
    assert not results_are_current(run.path, JOINT_DROP), "a batch must make up for it"
    assert an_experiment.state is ExperimentState.DONE
    assert STOPPED.text in [event.message for event in listener.of(EventKind.WARNING)]


def test_who_leaves_while_a_run_is_processed_does_not_wait_for_the_joint_correction(tmp_path: Path) -> None:
    def interrupted(_: Experiment, event: Event) -> None:
        if event.kind is EventKind.PRELIMINARY:
            raise KeyboardInterrupt

    an_experiment, _ = experiment(tmp_path, JOINT_DROP, then=interrupted)
    with pytest.raises(KeyboardInterrupt):
        record_run(an_experiment)
    assert an_experiment.is_cancelled
    summary = read_summary(an_experiment.session.run_paths()[0]) or {}
    assert (summary["status"], summary["correction"], summary["preliminary"]) == ("ok", "flights", True)
