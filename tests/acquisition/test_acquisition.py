"""The acquisition reads, records and shows; it always ends with the source closed and the recording kept."""

from __future__ import annotations

import itertools
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from types import FrameType

import numpy as np
from support.controlled_source import LONGEST_S, ControlledSource, MemoryRun, codes, digitisation
from support.simulated_setup import simulated_setup

from radargui.acquisition.acquisition import Acquisition
from radargui.acquisition.health import Health
from radargui.acquisition.recorder import Recorder
from radargui.acquisition.run_output import OpenRun
from radargui.acquisition.run_plan import AcquisitionState, Ending, RecorderState
from radargui.acquisition.stream import TOO_SLOW
from radargui.files.run_file import read_run, run_is_complete
from radargui.files.run_writer import RunWriter
from radargui.model.daq import RecordingLimits
from radargui.model.errors import DeviceError, FaultError, FileError
from radargui.model.recording import Block, Digitisation, Gap

LIMITS = RecordingLimits(pretrigger_s=0.2, quiet_s=0.15, maximum_s=2.0, wait_s=5.0)
SETUP = simulated_setup(daq={"buffer_s": 0.5})


class Events:
    """A recorder's changes of state, to wait for."""

    def __init__(self) -> None:
        self.seen = {state: threading.Event() for state in RecorderState}

    def __call__(self, state: RecorderState) -> None:
        self.seen[state].set()

    def wait_for(self, state: RecorderState) -> None:
        assert self.seen[state].wait(LONGEST_S)


def recorder(
    run: OpenRun, *, seconds: float | None = None, on_change: Callable[[RecorderState], None] | None = None
) -> Recorder:
    return Recorder(run, LIMITS, seconds=seconds, on_change=on_change)


def disk_run(folder: Path, make: type[RunWriter] = RunWriter) -> OpenRun:
    def open_run(how: Digitisation, *, started_at: str, trigger_index: int | None) -> RunWriter:
        return make(folder / "run-0001.h5", how, started_at=started_at, trigger_index=trigger_index)

    return open_run


def ended(acquisition: Acquisition) -> None:
    assert acquisition.wait(LONGEST_S)


def test_a_run_recorded_to_disk_is_bit_exact_from_before_the_trigger(tmp_path: Path) -> None:
    source = ControlledSource()
    samples = codes(20000, moving=slice(8000, 12000))
    source.push_all(samples)
    recording = recorder(disk_run(tmp_path))
    acquisition = Acquisition(source, SETUP, recorder=recording, live=False, patient=True)
    acquisition.start()
    ended(acquisition)
    assert acquisition.error is None
    assert acquisition.state is AcquisitionState.STOPPED
    assert recording.ending is Ending.QUIET
    stored = read_run(tmp_path / "run-0001.h5")
    assert np.array_equal(stored.raw, samples[:, recording.output.first_index :][:, : recording.count])
    assert stored.trigger_index == 2000
    assert stored.digitisation == source.digitisation
    assert run_is_complete(tmp_path / "run-0001.h5")
    assert source.calls[:2] == ["open", "start"]
    assert source.calls[-1] == "close"


def test_a_gap_is_told_from_the_source_to_the_file_the_ring_and_the_health(tmp_path: Path) -> None:
    source = ControlledSource()
    samples = codes(9000, moving=slice(2000, 9000))
    source.push_all(samples[:, :5000])
    source.push(samples[:, 5500:5700], lost=500)
    source.push_all(samples[:, 5700:])
    recording = recorder(disk_run(tmp_path))
    acquisition = Acquisition(source, SETUP, recorder=recording, patient=True)
    acquisition.start()
    source.wait_until_taken()
    ring = acquisition.ring
    assert ring is not None
    volts = ring.since(4990).volts[:, :520]
    assert np.isnan(volts[:, 10:510]).all()
    assert np.isfinite(volts[:, :10]).all()
    assert np.isfinite(volts[:, 510:]).all()
    health = acquisition.health
    assert (health.samples_lost, health.gaps, health.samples_read) == (500, 1, 8500)
    assert "500 lost" in health.line()
    acquisition.stop()
    stored = read_run(tmp_path / "run-0001.h5")
    assert stored.gaps == (Gap(5000 - recording.output.first_index, 500, "buffer overflow"),)
    assert np.array_equal(stored.raw, samples[:, np.r_[recording.output.first_index : 5000, 5500:9000]])


def test_stop_from_several_threads_at_once_ends_it_once() -> None:
    source = ControlledSource()
    run = MemoryRun()
    changes = Events()
    acquisition = Acquisition(source, SETUP, recorder=recorder(run, seconds=60.0, on_change=changes))
    acquisition.start()
    acquisition.start()
    source.push_all(codes(2000))
    changes.wait_for(RecorderState.RECORDING)
    source.wait_until_taken()
    barrier = threading.Barrier(6)

    def stop() -> None:
        barrier.wait(LONGEST_S)
        acquisition.stop()

    threads = [threading.Thread(target=stop) for _ in range(6)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(LONGEST_S)
    assert not any(thread.name.startswith("acquisition") for thread in threading.enumerate())
    assert acquisition.state is AcquisitionState.STOPPED
    assert source.calls.count("open") == source.calls.count("close") == 1
    assert run.raw.shape[1] == 2000
    assert run.complete is True
    assert acquisition.recorder is not None
    assert acquisition.recorder.ending is Ending.STOPPED


def test_an_acquisition_that_was_stopped_before_it_started_never_opens_its_source() -> None:
    source = ControlledSource()
    acquisition = Acquisition(source, SETUP)
    acquisition.stop()
    acquisition.start()
    ended(acquisition)
    assert source.calls == []
    assert acquisition.state is AcquisitionState.STOPPED
    assert acquisition.health.samples_read == 0


def test_a_source_that_cannot_be_opened_is_told_and_closed() -> None:
    source = ControlledSource(opening_error=DeviceError("Dev1 is not there", remedy="Plug it in."))
    acquisition = Acquisition(source, SETUP, recorder=recorder(MemoryRun()))
    acquisition.start()
    ended(acquisition)
    assert isinstance(acquisition.error, DeviceError)
    assert acquisition.state is AcquisitionState.FAILED
    assert "start" not in source.calls
    assert source.calls[-1] == "close"
    assert acquisition.recorder is not None
    assert acquisition.recorder.is_done


def test_a_source_that_fails_in_the_middle_keeps_every_sample_that_was_read(tmp_path: Path) -> None:
    source = ControlledSource()
    samples = codes(7300)
    source.push_all(samples)
    source.fail()
    acquisition = Acquisition(source, SETUP, recorder=recorder(disk_run(tmp_path), seconds=60.0), patient=True)
    acquisition.start()
    ended(acquisition)
    assert str(acquisition.error) == "The device was removed"
    assert acquisition.state is AcquisitionState.FAILED
    assert np.array_equal(read_run(tmp_path / "run-0001.h5").raw, samples)
    assert not run_is_complete(tmp_path / "run-0001.h5")
    assert source.calls[-1] == "close"


def test_an_unexpected_failure_is_told_as_a_fault_of_the_program() -> None:
    source = ControlledSource()
    source.fail(ZeroDivisionError("oops"))
    acquisition = Acquisition(source, SETUP, live=False)
    acquisition.start()
    ended(acquisition)
    assert type(acquisition.error) is FaultError
    assert (
        "Reading the source failed unexpectedly: ZeroDivisionError: oops (radargui/acquisition/acquisition.py, line "
        in str(acquisition.error)
    )
    assert isinstance(acquisition.error.__cause__, ZeroDivisionError)


def test_a_source_that_breaks_its_contract_is_stopped() -> None:
    source = ControlledSource()
    source.push_raw(Block(np.zeros((4, 10), dtype=np.int16), 0))
    acquisition = Acquisition(source, SETUP, live=False)
    acquisition.start()
    ended(acquisition)
    assert "promised 6 channels" in str(acquisition.error)


def test_a_stalled_writer_does_not_hold_the_reader_back_and_what_did_not_fit_is_a_gap() -> None:
    source = ControlledSource()
    run = MemoryRun()
    run.go.clear()
    samples = codes(12000)
    acquisition = Acquisition(source, SETUP, recorder=recorder(run, seconds=60.0), live=False)
    acquisition.start()
    source.push(samples[:, :200])
    assert run.wrote.wait(LONGEST_S)
    source.push_all(samples[:, 200:9000])
    source.wait_until_taken()
    health = acquisition.health
    assert health.samples_read == 9000
    assert health.samples_lost == 0
    assert health.writer_queue_samples == health.writer_queue_capacity_samples == 5000
    assert health.samples_not_written == 9000 - 200 - 5000
    assert "3800 not written" in health.line()
    assert "writer queue 100 %" in health.line()
    run.wrote.clear()
    run.go.set()
    assert run.wrote.wait(LONGEST_S)
    source.push_all(samples[:, 9000:])
    source.wait_until_taken()
    acquisition.stop()
    assert run.gaps[0].first_index == 5200
    assert run.gaps[0].reason == TOO_SLOW
    kept = np.ones(12000, dtype=np.bool_)
    for gap in run.gaps:
        kept[gap.first_index : gap.first_index + gap.count] = False
    assert np.array_equal(run.raw, samples[:, kept])


def test_a_writer_that_stalls_for_less_than_its_queue_loses_nothing() -> None:
    source = ControlledSource()
    run = MemoryRun()
    run.go.clear()
    samples = codes(5000)
    acquisition = Acquisition(source, SETUP, recorder=recorder(run, seconds=60.0), live=False)
    acquisition.start()
    source.push_all(samples)
    source.wait_until_taken()
    run.go.set()
    acquisition.stop()
    assert np.array_equal(run.raw, samples)
    assert run.gaps == []


class FullAfter20000(RunWriter):
    """Writes to a disk that has room for 20000 samples."""

    def write(self, block: Block) -> None:
        if block.first_index >= 20000:
            raise FileError("The disk is full")
        super().write(block)


def test_a_full_disk_is_told_and_what_was_written_is_readable(tmp_path: Path) -> None:
    source = ControlledSource()
    samples = codes(30000)
    made = recorder(disk_run(tmp_path, FullAfter20000), seconds=60.0)
    acquisition = Acquisition(source, SETUP, recorder=made, patient=True)
    acquisition.start()
    source.push_all(samples)
    ended(acquisition)
    assert str(acquisition.error) == "The disk is full"
    assert acquisition.state is AcquisitionState.FAILED
    assert np.array_equal(read_run(tmp_path / "run-0001.h5").raw, samples[:, :20000])


def test_a_run_file_that_cannot_be_made_is_told(tmp_path: Path) -> None:
    source = ControlledSource()
    source.push_all(codes(400))
    acquisition = Acquisition(source, SETUP, recorder=recorder(disk_run(tmp_path / "nowhere"), seconds=1.0))
    acquisition.start()
    ended(acquisition)
    assert isinstance(acquisition.error, FileError)
    assert source.calls[-1] == "close"


def test_the_end_is_told_once_and_a_failing_listener_does_not_keep_the_source_open() -> None:
    source = ControlledSource()
    source.end()
    told: list[str] = []

    def on_end() -> None:
        told.append("end")
        raise ValueError("listener")

    acquisition = Acquisition(source, SETUP, live=False, on_end=on_end)
    acquisition.start()
    ended(acquisition)
    assert told == ["end"]
    assert source.calls[-1] == "close"


def test_a_source_that_fails_to_stop_is_still_closed() -> None:
    class StubbornSource(ControlledSource):
        def stop(self) -> None:
            super().stop()
            raise DeviceError("It does not stop")

    source = StubbornSource()
    source.end()
    acquisition = Acquisition(source, SETUP, live=False)
    acquisition.start()
    ended(acquisition)
    assert source.calls[-1] == "close"
    assert str(acquisition.error) == "It does not stop"


def test_a_source_that_hangs_is_told_by_stop() -> None:
    go = threading.Event()

    class HangingSource(ControlledSource):
        def read(self) -> Block | None:
            assert go.wait(LONGEST_S)
            return None

    source = HangingSource()
    acquisition = Acquisition(source, SETUP, live=False)
    acquisition.start()
    assert source.running.wait(LONGEST_S)
    acquisition.stop(timeout_s=0.01)
    assert "did not end within" in str(acquisition.error)
    go.set()
    ended(acquisition)
    acquisition.stop()
    assert acquisition.state is AcquisitionState.FAILED


def test_stop_may_be_called_from_inside() -> None:
    source = ControlledSource()
    run = MemoryRun()
    acquisition: Acquisition

    def on_change(state: RecorderState) -> None:
        if state is RecorderState.RECORDING:
            acquisition.stop()

    acquisition = Acquisition(source, SETUP, recorder=recorder(run, seconds=9.0, on_change=on_change), live=False)
    acquisition.start()
    source.push(codes(100))
    ended(acquisition)
    assert run.complete is True


def health_interrupted(acquisition: Acquisition, place: int) -> tuple[Health, bool]:
    """Return the health, looked at while the acquisition goes through its whole life before instruction `place`.

    And whether there is such an instruction.
    """
    left = place

    def trace(frame: FrameType, event: str, _: object) -> object:
        nonlocal left
        if not frame.f_code.co_filename.endswith(("acquisition.py", "health.py")):
            return None
        frame.f_trace_opcodes = True
        if event == "opcode":
            left -= 1
            if left == -1:
                acquisition.start()
                ended(acquisition)
        return trace

    before = sys.gettrace()
    sys.settrace(trace)
    try:
        health = acquisition.health
    finally:
        sys.settrace(before)
    return health, left < 0


def test_health_is_of_one_moment_whatever_happens_between_two_instructions_of_who_looks() -> None:
    seen = set()
    for place in itertools.count():
        source = ControlledSource(opening_error=DeviceError("Dev1 is not there"))
        health, interrupted = health_interrupted(Acquisition(source, SETUP), place)
        if not interrupted:
            break
        seen.add((health.state, health.error is None))
    assert seen == {(AcquisitionState.IDLE, True), (AcquisitionState.FAILED, False)}


def test_health_before_during_and_after() -> None:
    source = ControlledSource()
    acquisition = Acquisition(source, SETUP, ring_s=1.0)
    assert acquisition.health.state is AcquisitionState.IDLE
    assert (acquisition.ring, acquisition.live, acquisition.digitisation) == (None, None, None)
    acquisition.start()
    samples = codes(4000)
    samples[2, 3900] = 32767
    source.push_all(samples)
    source.wait_until_taken()
    health = acquisition.health
    assert health.state is AcquisitionState.RUNNING
    assert health.sample_rate_hz == 10000.0
    assert health.backlog_samples == 7
    assert health.clipped == ("I2",)
    assert len(health.levels) == 6
    assert acquisition.digitisation == digitisation()
    acquisition.stop()
    assert acquisition.health.state is AcquisitionState.STOPPED
    assert acquisition.ring is not None
    assert acquisition.ring.latest == 4000
