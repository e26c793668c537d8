"""The recorder writes exactly the samples of the run, those before the trigger included."""

from __future__ import annotations

import shutil
from datetime import UTC, datetime
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from support.changed import changed
from support.controlled_source import MemoryRun, codes, digitisation
from support.simulated_recording import simulate_recording

from radargui.acquisition.recorder import Recorder
from radargui.acquisition.run_output import MINIMUM_FREE_BYTES, FinishedRun, free_bytes
from radargui.acquisition.run_plan import Ending, RecorderState
from radargui.model.arrays import RawArray
from radargui.model.daq import RecordingLimits
from radargui.model.errors import FileError
from radargui.model.recording import Block, Digitisation, Gap, Truth
from radargui.model.setup import read_setup
from radargui.system.resources import default_setup_path

LIMITS = RecordingLimits(pretrigger_s=0.2, quiet_s=0.15, maximum_s=2.0, wait_s=5.0)
START = datetime(2026, 11, 20, 12, 0, 0, tzinfo=UTC)


def blocks(samples: RawArray, size: int) -> list[Block]:
    return [Block(samples[:, first : first + size].copy(), first) for first in range(0, samples.shape[1], size)]


def armed(run: MemoryRun, limits: RecordingLimits = LIMITS, seconds: float | None = None) -> Recorder:
    recorder = Recorder(run, limits, seconds=seconds)
    recorder.prepare(digitisation(), START)
    return recorder


@pytest.mark.parametrize("size", [7, 37, 200, 20000])
def test_a_run_is_bit_exact_from_before_the_trigger_until_quiet(size: int) -> None:
    samples = codes(20000, moving=slice(8000, 12000))
    run = MemoryRun()
    recorder = armed(run)
    for block in blocks(samples, size):
        recorder.push(block)
    assert recorder.ending is Ending.QUIET
    assert run.trigger_index == 2000
    assert recorder.output.first_index + 2000 == pytest.approx(8000, abs=250)
    assert recorder.output.first_index + recorder.count == pytest.approx(12000 + 1500, abs=400)
    assert np.array_equal(run.raw, samples[:, recorder.output.first_index :][:, : recorder.count])
    assert run.raw.dtype == np.int16
    assert run.complete is True
    started = (datetime.fromisoformat(run.started_at) - START).total_seconds()
    assert started == pytest.approx(recorder.output.first_index / 10000.0, abs=2e-6)


def test_a_run_shorter_than_its_pretrigger_begins_with_the_first_sample() -> None:
    samples = codes(9000, moving=slice(3000, 5000))
    limits = RecordingLimits(pretrigger_s=2.0, quiet_s=0.15)
    run = MemoryRun()
    recorder = armed(run, limits)
    for block in blocks(samples, 200):
        recorder.push(block)
    assert run.trigger_index == pytest.approx(3000, abs=250)
    assert np.array_equal(run.raw, samples[:, : recorder.count])


def test_the_longest_run_counts_from_the_trigger_and_is_exact() -> None:
    samples = codes(40000, moving=slice(5000, 40000))
    run = MemoryRun()
    recorder = armed(run)
    for block in blocks(samples, 333):
        recorder.push(block)
    assert recorder.ending is Ending.MAXIMUM
    assert recorder.count == 2000 + 20000


def test_gaps_are_written_with_indices_from_the_first_sample_of_the_run() -> None:
    samples = codes(20000, moving=slice(8000, 12000))
    run = MemoryRun()
    recorder = armed(run)
    for block in blocks(samples, 200):
        if block.first_index == 7600:
            continue
        if block.first_index == 7800:
            block = Block(block.samples, 7800, Gap(7600, 200, "overflow"))
        if block.first_index == 9000:
            continue
        if block.first_index == 9200:
            block = Block(block.samples, 9200, Gap(9000, 200, "writer too slow"))
        recorder.push(block)
    base = recorder.output.first_index
    assert base > 0
    assert run.gaps == [Gap(7600 - base, 200, "overflow"), Gap(9000 - base, 200, "writer too slow")]
    assert recorder.output.lost == 400
    expected = [index for index in range(base, base + recorder.count + 400) if index // 200 not in (38, 45)]
    assert np.array_equal(run.raw, samples[:, expected])


def test_a_run_whose_first_history_sample_was_lost_begins_after_the_gap() -> None:
    samples = codes(20000, moving=slice(8000, 12000))
    run = MemoryRun()
    recorder = armed(run)
    for block in blocks(samples, 200):
        if 5000 <= block.first_index < 7000:
            continue
        if block.first_index == 7000:
            block = Block(block.samples, 7000, Gap(5000, 2000, "overflow"))
        recorder.push(block)
    assert run.gaps == []
    assert run.trigger_index == pytest.approx(1000, abs=250)
    assert np.array_equal(run.raw, samples[:, 7000 : 7000 + recorder.count])


def test_a_motion_that_was_lost_as_a_whole_is_no_run_and_the_next_one_is_recorded() -> None:
    samples = codes(60000, moving=slice(8000, 33000))
    samples[:, 50000:] = codes(20000, moving=slice(3000, 7000))[:, :10000]
    run = MemoryRun()
    recorder = armed(run, RecordingLimits(pretrigger_s=0.2, quiet_s=0.15, maximum_s=1.0))
    for block in blocks(samples, 20):
        # the writer falls behind as it begins, for longer than the longest run
        if 8020 <= block.first_index < 30000:
            continue
        gap = Gap(8020, 21980, "writer too slow") if block.first_index == 30000 else None
        recorder.push(Block(block.samples, block.first_index, gap))
    assert recorder.output.first_index + run.trigger_index == pytest.approx(53000, abs=250)
    assert recorder.count > 0
    assert recorder.ending is Ending.QUIET
    assert run.gaps == []


def test_the_truth_of_exactly_the_recorded_samples_is_kept_without_the_lost_ones() -> None:
    asked: list[tuple[int, int]] = []

    def truth(first: int, count: int) -> Truth:
        asked.append((first, count))
        ramp = np.arange(first, first + count, dtype=np.float64)
        return Truth(np.stack([ramp] * 3), np.stack([ramp] * 2), np.array([0.1]))

    run = MemoryRun()
    recorder = Recorder(run, LIMITS, seconds=0.1)
    recorder.prepare(digitisation(), START, truth)
    recorder.push(Block(codes(400), 0))
    recorder.push(Block(codes(700), 500, Gap(400, 100)))
    assert asked == [(0, 1000)]
    assert run.truth is not None
    assert run.truth.position_m.shape == (3, 900)
    assert run.truth.path_m[0, 399:401].tolist() == [399.0, 500.0]


@pytest.mark.parametrize("simulation", [{"mismatch": 0.2}, {"mismatch": 0.5}, {"snr_db": 3.0}], ids=str)
def test_a_fall_in_the_hum_of_a_strong_mismatch_or_in_noise_is_recorded(simulation: dict[str, float]) -> None:
    setup = changed(read_setup(default_setup_path()), simulation={"restitution": 0.5, **simulation})
    recording, truth = simulate_recording(setup)
    run = MemoryRun()
    recorder = Recorder(run, RecordingLimits(pretrigger_s=0.3))
    recorder.prepare(recording.digitisation, START)
    for block in blocks(recording.raw, 667):
        recorder.push(block)
        assert recorder.objection == ""
    fallen = int(np.argmax(truth.position_m[2] < truth.position_m[2, 0] - 1e-3))
    began = recorder.output.first_index + run.trigger_index
    assert began == pytest.approx(fallen, abs=0.06 * setup.daq.rate_hz)


@pytest.mark.parametrize("ending", [Ending.WAITED, Ending.END_OF_DATA])
def test_who_is_armed_in_vain_is_told_why_until_the_end(ending: Ending) -> None:
    setup = changed(
        read_setup(default_setup_path()), simulation={"scene": "rest", "mains": 0.4, "mains_frequency_hz": 180}
    )
    recording, _ = simulate_recording(setup)
    recorder = Recorder(MemoryRun(), RecordingLimits(wait_s=1.0 if ending is Ending.WAITED else 60.0))
    assert recorder.objection == ""
    recorder.prepare(recording.digitisation, START)
    for block in blocks(recording.raw, 667):
        recorder.push(block)
    assert "as a hum or a vibration does" in recorder.objection
    recorder.finish(ending)
    assert recorder.is_done
    assert "as a hum or a vibration does" in recorder.objection


def test_an_almost_full_disk_refuses_to_arm(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shutil, "disk_usage", lambda _: SimpleNamespace(free=1000))
    recorder = Recorder(MemoryRun(), LIMITS, folder=tmp_path)
    with pytest.raises(FileError, match="MB left"):
        recorder.prepare(digitisation(), START)


def test_a_disk_that_fills_up_stops_the_run_while_the_file_can_be_closed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    free = iter([MINIMUM_FREE_BYTES + 1, MINIMUM_FREE_BYTES - 1])
    monkeypatch.setattr(shutil, "disk_usage", lambda _: SimpleNamespace(free=next(free)))
    run = MemoryRun()
    recorder = Recorder(run, LIMITS, folder=tmp_path, seconds=10.0)
    recorder.prepare(digitisation(), START)
    recorder.push(Block(codes(4000), 0))
    with pytest.raises(FileError, match="MB left"):
        recorder.push(Block(codes(4000), 4000))
    recorder.fail()
    assert run.raw.shape[1] == 8000
    assert recorder.ending is Ending.DISK
    assert run.complete is True


def test_the_free_space_of_a_folder_that_is_not_there_is_unknown(tmp_path: Path) -> None:
    assert free_bytes(tmp_path / "nowhere") is None
    assert (free_bytes(tmp_path) or 0) > 0


class Runs:
    """Opens one file in memory after the other."""

    def __init__(self) -> None:
        self.files: list[MemoryRun] = []

    def __call__(self, how: Digitisation, *, started_at: str, trigger_index: int | None) -> MemoryRun:
        self.files.append(MemoryRun())
        return self.files[-1](how, started_at=started_at, trigger_index=trigger_index)


class Fussy:
    """A judge that wants runs of more than a length."""

    def __init__(self, _: Digitisation) -> None:
        self.count = 0

    def push(self, samples: RawArray) -> None:
        self.count += samples.shape[1]

    def refusal(self) -> str:
        return "" if self.count > 4500 else "too short"


@pytest.mark.parametrize("size", [37, 200, 5000])
def test_runs_follow_each_other_bit_exact_and_those_refused_do_not_count(size: int) -> None:
    samples = codes(60_000)
    for first, length in ((5000, 2000), (12_000, 300), (20_000, 2500), (40_000, 2000)):
        samples[:, first : first + length] = codes(length, seed=first, moving=slice(0, length))
    runs, told = Runs(), list[FinishedRun]()
    states: list[RecorderState] = []
    recorder = Recorder(runs, LIMITS, n_runs=2, make_judge=Fussy, on_run=told.append, on_change=states.append)
    recorder.prepare(digitisation(), START)
    armed: list[tuple[bool, int]] = []
    for block in blocks(samples, size):
        recorder.push(block)
        if recorder.armed_again_at is not None and len(armed) < len(told):
            armed.append((recorder.hung_up_at == recorder.armed_again_at, recorder.armed_again_at))
    assert [hung for hung, _ in armed][:2] == [False, True], "after a run that was set aside a hand has hung it up"
    assert [run.set_aside for run in told] == ["", "too short", ""]
    assert [run.is_last for run in told] == [False, False, True]
    assert [run.number for run in told] == [1, 2, 3]
    assert recorder.n_wanted == 2
    for run, file in zip(told, runs.files, strict=True):
        assert np.array_equal(file.raw, samples[:, run.first_index : run.end_index])
        assert file.health["samples_recorded"] == run.count
        assert file.complete
    assert [run.first_index + 2000 for run in told] == pytest.approx([5000, 12_000, 20_000], abs=250)
    assert states.count(RecorderState.ARMED) == 3
    assert states[-1] is RecorderState.DONE


def test_one_run_more_can_be_wanted_while_there_is_time() -> None:
    samples = codes(40_000)
    for first in (5000, 20_000):
        samples[:, first : first + 2000] = codes(2000, seed=first, moving=slice(0, 2000))
    runs = Runs()
    recorder = Recorder(runs, LIMITS)
    recorder.prepare(digitisation(), START)
    assert recorder.want_another()
    for block in blocks(samples, 200):
        recorder.push(block)
    assert len(runs.files) == 2
    assert not recorder.want_another()
