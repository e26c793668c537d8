"""Faults one by one, end to end: what was read is in the file, what is missing is told everywhere, all ends clean."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from datetime import UTC, datetime
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from support.changed import changed
from support.controlled_source import ControlledSource, codes, digitisation
from support.ni_samples import code_recording, ni_setup
from support.ni_server import ByHand, serve
from support.one_run import record_run
from support.simulated_setup import simulated_setup

from radargui.acquisition.acquisition import Acquisition
from radargui.acquisition.recorder import Recorder
from radargui.acquisition.run_plan import Ending
from radargui.acquisition.stream import TOO_SLOW
from radargui.experiment.event import Event, EventKind, ExperimentState
from radargui.experiment.series import Experiment
from radargui.files.run_card import read_health
from radargui.files.run_file import read_run, run_is_complete
from radargui.files.run_writer import RunWriter
from radargui.model.errors import DeviceError, FileError, RadarGuiError
from radargui.model.recording import Block, Digitisation, Gap
from radargui.model.setup import Setup
from radargui.session.session import Session
from radargui.sources.contract import Source
from radargui.sources.factory import make_source
from radargui.sources.ni.source import NiSource

QUICK = changed(simulated_setup(), processing={"correction": "ellipse"})
NOW = datetime(2026, 11, 20, 15, 4, 5, tzinfo=UTC)
BLOCK = 200


class Told:
    """The events of an experiment; may do something when one state is entered."""

    def __init__(self) -> None:
        self.events: list[Event] = []
        self.reactions: dict[ExperimentState, Callable[[], object]] = {}

    def __call__(self, event: Event) -> None:
        self.events.append(event)
        if event.kind is EventKind.STATE:
            self.reactions.pop(event.state, lambda: None)()

    @property
    def warnings(self) -> str:
        return " | ".join(event.message for event in self.events if event.kind is EventKind.WARNING)

    @property
    def last_line(self) -> str:
        return [event.message for event in self.events if event.kind is EventKind.HEALTH][-1]


def recorded(
    folder: Path,
    setup: Setup,
    source: Source,
    *,
    seconds: float | None,
    told: Callable[[Event], None],
    process: bool = True,
    sessions: type[Session] = Session,
) -> Experiment:
    session = sessions.create(folder, setup, now=NOW)
    return Experiment(
        setup, lambda _: source, session, seconds=seconds, listener=told, live=False, patient=True, process=process
    )


def only_run(experiment: Experiment) -> Path:
    (path,) = experiment.session.run_paths()
    return path


FAULTS = {
    "overflow": (lambda server: server.fail("ReadBinaryI16", -200279, after=25), "-200279"),
    "onboard overflow": (lambda server: server.fail("ReadBinaryI16", -200361, after=25), "-200361"),
    "timeout": (lambda server: server.fail("ReadBinaryI16", -200284, after=25), "gives no samples"),
    "removal": (lambda server: server.fail("ReadBinaryI16", -201003, after=25), "cannot be reached any more"),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_device_that_fails_leaves_every_sample_that_was_read(fault: str, tmp_path: Path) -> None:
    inject, words = FAULTS[fault]
    recording = code_recording(40_000)
    told = Told()
    with serve(recording) as server:
        inject(server)
        setup = ni_setup(server.address)
        experiment = recorded(tmp_path, setup, NiSource(setup), seconds=3.0, told=told)
        with pytest.raises(DeviceError, match="What was recorded is kept in") as caught:
            record_run(experiment)
        assert server.tasks == []
    assert words in str(caught.value)
    path = only_run(experiment)
    stored = read_run(path)
    assert np.array_equal(stored.raw, recording.raw[:, : 25 * BLOCK])
    assert not run_is_complete(path)
    health = read_health(path)
    assert health is not None
    assert health["ending"] == Ending.FAILED.value
    assert health["samples_recorded"] == health["samples_read"] == 25 * BLOCK
    assert told.events[-1].state is ExperimentState.FAILED
    assert told.events[-1].error is caught.value
    assert f"{25 * BLOCK} samples" in told.last_line


@pytest.mark.parametrize("how", ["killed", "removed"])
def test_a_server_that_dies_or_a_cable_pulled_while_recording_loses_nothing_that_was_read(
    how: str, tmp_path: Path
) -> None:
    recording = code_recording(40_000)
    pace = ByHand()
    told = Told()
    with serve(recording, pace=pace) as server:
        setup = ni_setup(server.address)
        experiment = recorded(tmp_path, setup, NiSource(setup), seconds=3.0, told=told)

        def end() -> None:
            assert pace.waiting.wait(10.0)
            pace.waiting.clear()
            pace.advance(5000)
            assert pace.waiting.wait(10.0)
            server.kill() if how == "killed" else server.remove("Dev1")

        hand = threading.Thread(target=end)
        hand.start()
        with pytest.raises(DeviceError):
            record_run(experiment)
        hand.join()
    stored = read_run(only_run(experiment))
    assert np.array_equal(stored.raw, recording.raw[:, :5000])
    assert not run_is_complete(only_run(experiment))


def test_a_restart_after_an_overflow_is_a_gap_in_file_health_and_result(tmp_path: Path) -> None:
    recording = code_recording(100_000)
    told = Told()
    with serve(recording) as server:
        server.fail("ReadBinaryI16", -200279, after=25, times=1)
        setup = changed(ni_setup(server.address), recording={"restart_after_error": True})
        source = make_source("ni", setup)
        experiment = recorded(tmp_path, setup, source, seconds=2.0, told=told)
        run = record_run(experiment)
        assert server.tasks == []
    assert run.path is not None
    assert run_is_complete(run.path)
    stored = read_run(run.path)
    (gap,) = stored.gaps
    assert gap.first_index == 25 * BLOCK
    assert gap.count > 0
    assert stored.n_samples + gap.count >= 20_000
    assert np.array_equal(stored.raw[:, : 25 * BLOCK], recording.raw[:, : 25 * BLOCK])
    rest = stored.raw[:, 25 * BLOCK :]
    assert np.array_equal(rest, recording.raw[:, : rest.shape[1]])
    assert f"{gap.count} samples of each channel were lost by the source in 1 gap" in told.warnings
    assert f"{gap.count} lost" in told.last_line
    health = read_health(run.path)
    assert health is not None
    assert (health["gaps_in_run"], health["samples_lost_in_run"]) == (1, gap.count)
    assert run.result is not None
    assert any(f"{gap.count} samples of each channel were lost in 1 gap" in text for text in run.result.warnings)


class FullDisk(RunWriter):
    """The disk takes only so many blocks."""

    left = 40

    def write(self, block: Block) -> None:
        if self.left == 0:
            self.close(complete=False)
            raise FileError("writing failed: No space left on device.", remedy="Make room on the disk.")
        self.left -= 1
        super().write(block)


class OnFullDisk(Session):
    """A session on such a disk."""

    def new_run(self, digitisation: Digitisation, *_: Any, **header: Any) -> RunWriter:
        return super().new_run(digitisation, FullDisk, **header)


def test_a_disk_that_refuses_ends_the_run_and_what_was_written_stays(tmp_path: Path) -> None:
    source = ControlledSource()
    samples = codes(30_000)
    source.push_all(samples)
    told = Told()
    experiment = recorded(tmp_path, QUICK, source, seconds=9.0, told=told, sessions=OnFullDisk)
    with pytest.raises(FileError, match=r"No space left.*Make room.*What was recorded is kept in"):
        record_run(experiment)
    stored = read_run(only_run(experiment))
    # blocks are taken in slices of 10 ms, 100 samples
    assert np.array_equal(stored.raw, samples[:, : 40 * 100])
    assert source.calls[-1] == "close"


@pytest.fixture
def tiny_disk(tmp_path: Path) -> Iterator[Path]:
    """A real filesystem of 8 MB."""
    if sys.platform != "linux" or os.geteuid() != 0:
        pytest.skip("a filesystem can be made by root on Linux only")
    folder = tmp_path / "tiny"
    folder.mkdir()
    made = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=8m", "tmpfs", str(folder)], capture_output=True)
    if made.returncode:
        pytest.skip("no filesystem may be mounted here")
    yield folder
    subprocess.run(["umount", str(folder)], check=True)


def test_a_real_disk_that_fills_up_keeps_all_that_fitted(tiny_disk: Path) -> None:
    def open_run(how: object, *, started_at: str, trigger_index: int | None) -> RunWriter:
        return RunWriter(tiny_disk / "run-0001.h5", digitisation(), started_at=started_at, trigger_index=trigger_index)

    source = ControlledSource()
    samples = np.random.default_rng(1).integers(-30_000, 30_000, (6, 800_000)).astype(np.int16)
    source.push_all(samples, 5000)
    recorder = Recorder(open_run, QUICK.recording, folder=tiny_disk, seconds=80.0, minimum_free_bytes=1_000_000)
    acquisition = Acquisition(source, QUICK, recorder=recorder, live=False, patient=True)
    acquisition.start()
    assert acquisition.wait(60.0)
    assert isinstance(acquisition.error, FileError)
    stored = read_run(tiny_disk / "run-0001.h5")
    assert stored.n_samples > 200_000
    assert np.array_equal(stored.raw, samples[:, : stored.n_samples])
    # the writer holds back less than one chunk of half a second
    assert recorder.count - stored.n_samples < 5000


def test_an_almost_full_disk_is_told_before_anything_is_recorded_and_a_low_one_while_it_is(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # 200 MB stay free; 6 channels of int16 at 10 kS/s are 120 kB/s
    monkeypatch.setattr(shutil, "disk_usage", lambda _: SimpleNamespace(free=200_000_000 + 60_000_000))
    source = ControlledSource()
    told = Told()

    def listen(event: Event) -> None:
        told(event)
        if "minutes can still be recorded" in event.message:
            source.push_all(codes(6000))

    experiment = recorded(tmp_path, QUICK, source, seconds=0.5, told=listen)
    source.push_all(codes(1000))
    run = record_run(experiment)
    assert run.path is not None
    assert "The disk is filling up: about 8 minutes can still be recorded" in told.warnings
    assert "LOW DISK: disk for 8 min" in told.last_line
    monkeypatch.setattr(shutil, "disk_usage", lambda _: SimpleNamespace(free=1_000))
    with pytest.raises(FileError, match="MB left"):
        record_run(recorded(tmp_path, QUICK, ControlledSource(), seconds=0.5, told=told))


def test_a_folder_that_cannot_be_written_is_told_before_anything_is_recorded(tmp_path: Path) -> None:
    source = ControlledSource()
    experiment = recorded(tmp_path, QUICK, source, seconds=0.5, told=Told())
    folder = experiment.session.path
    for file in folder.iterdir():
        file.unlink()
    folder.rmdir()
    with pytest.raises(RadarGuiError, match=r"Nothing can be written to .* Choose another folder"):
        record_run(experiment)
    assert "start" not in source.calls


class StalledWriter(RunWriter):
    """A writer that stands still until it is told to go on."""

    go = threading.Event()
    stands = threading.Event()

    def write(self, block: Block) -> None:
        if block.first_index >= 2000:
            self.stands.set()
            assert self.go.wait(20.0)
        super().write(block)


class WithStalledWriter(Session):
    """A session whose writers do that."""

    def new_run(self, digitisation: Digitisation, *_: Any, **header: Any) -> RunWriter:
        return super().new_run(digitisation, StalledWriter, **header)


@pytest.mark.parametrize(("buffer_s", "lost"), [(10.0, False), (2.0, True)])
def test_a_writer_that_stands_still_for_5_s_delays_nobody_and_loses_nothing_that_fits_the_queue(
    buffer_s: float, lost: bool, tmp_path: Path
) -> None:
    StalledWriter.go.clear()
    StalledWriter.stands.clear()
    setup = simulated_setup(daq={"buffer_s": buffer_s})
    source = ControlledSource()
    samples = codes(60_000)
    told = Told()
    session = WithStalledWriter.create(tmp_path, setup, now=NOW)
    experiment = Experiment(setup, lambda _: source, session, seconds=6.0, listener=told, live=False, process=False)
    worker = threading.Thread(target=record_run, args=(experiment,))
    worker.start()
    source.push_all(samples[:, :2200])
    assert StalledWriter.stands.wait(20.0)
    source.push_all(samples[:, 2200:52_200])
    # the reader has taken five seconds of samples while the writer stood still
    source.wait_until_taken()
    acquisition = experiment.acquisition
    assert acquisition is not None
    assert acquisition.health.samples_read == 52_200
    StalledWriter.go.set()
    source.push_all(samples[:, 52_200:])
    source.end()
    worker.join(20.0)
    path = only_run(experiment)
    stored, health = read_run(path), read_health(path)
    assert health is not None
    assert run_is_complete(path)
    if not lost:
        assert stored.gaps == ()
        assert np.array_equal(stored.raw, samples)
        assert health["writer_queue_peak_samples"] > 49_000  # type: ignore[operator]
        return
    assert sum(gap.count for gap in stored.gaps) == 60_000 - stored.n_samples
    kept = np.ones(60_000, dtype=np.bool_)
    for gap in stored.gaps:
        assert gap.reason == TOO_SLOW
        kept[gap.first_index : gap.first_index + gap.count] = False
    assert np.array_equal(stored.raw, samples[:, kept])
    assert health["samples_not_written"] == health["samples_lost_in_run"] == 60_000 - stored.n_samples
    assert "could not be written in time and are lost" in told.warnings
    assert "not written" in told.last_line


def test_values_that_are_no_numbers_are_kept_as_they_are_and_told(tmp_path: Path) -> None:
    source = ControlledSource(digitisation(codes=False))
    samples = codes(20_000, moving=slice(8000, 12_000)) / 3276.8
    samples[1, 9000:9040] = np.nan
    samples[4, 100] = np.inf
    source.push_all(samples)
    told = Told()
    setup = changed(QUICK, recording={"quiet_s": 0.2})
    run = record_run(recorded(tmp_path, setup, source, seconds=2.0, told=told))
    assert run.path is not None
    assert np.array_equal(read_run(run.path).raw, samples, equal_nan=True)
    assert "Q1 gave no number in 40 samples" in told.warnings
    assert "I3 gave no number in 1 sample" in told.warnings
    health = read_health(run.path)
    assert health is not None
    assert [channel["not_a_number"] for channel in health["channels"]] == [0, 40, 0, 0, 1, 0]  # type: ignore[union-attr]
    assert run.error is None


def test_values_that_are_no_numbers_do_not_start_a_run(tmp_path: Path) -> None:
    source = ControlledSource(digitisation(codes=False))
    samples = codes(8000) / 3276.8
    samples[:, 5000:5003] = np.nan
    source.push_all(samples)
    source.end()
    run = record_run(recorded(tmp_path, QUICK, source, seconds=None, told=Told()))
    assert run.path is None
    assert run.ending is Ending.NO_MOTION


def test_values_at_the_rails_are_kept_as_they_are_and_told(tmp_path: Path) -> None:
    source = ControlledSource()
    samples = codes(20_000, moving=slice(8000, 12_000))
    samples[2, 9000:9100] = 32767
    samples[5, 9000:9003] = -32768
    source.push_all(samples)
    told = Told()
    run = record_run(recorded(tmp_path, QUICK, source, seconds=2.0, told=told))
    assert run.path is not None
    assert np.array_equal(read_run(run.path).raw, samples)
    assert "I2 sat at the end of its range in 100 samples: set a larger range" in told.warnings
    assert "Q3 sat at the end of its range in 3 samples" in told.warnings


def test_an_overflow_of_the_source_is_a_gap_everywhere(tmp_path: Path) -> None:
    source = ControlledSource()
    samples = codes(20_000, moving=slice(8000, 12_000))
    source.push_all(samples[:, :6000])
    source.push(samples[:, 6000:6200], lost=1000)
    source.push_all(samples[:, 6200:])
    told = Told()
    run = record_run(recorded(tmp_path, QUICK, source, seconds=2.0, told=told))
    assert run.path is not None
    assert read_run(run.path).gaps == (Gap(6000, 1000, "buffer overflow"),)
    assert "1000 samples of each channel were lost by the source in 1 gap" in told.warnings
    assert "1000 lost" in told.last_line
    health = read_health(run.path)
    assert health is not None
    assert (health["gaps_in_run"], health["samples_lost_in_run"]) == (1, 1000)
    assert run.result is not None
    assert any("1000 samples of each channel were lost" in text for text in run.result.warnings)
