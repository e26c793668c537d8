"""The run writer: what it stores is what came, and nothing that goes wrong spoils what is stored."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import threading
from collections import namedtuple
from pathlib import Path

import h5py
import numpy as np
import pytest
from support.failing_disk import FailingDisk
from support.file_samples import codes, int16_digitisation, volts, write_run
from support.run_contents import read_markers, read_run_truth, read_summary

from radargui.files.run_file import read_run, read_run_setup, run_is_complete
from radargui.files.run_writer import RESERVE_BYTES, RunExistsError, RunWriter
from radargui.model.errors import FileError
from radargui.model.recording import Block, Digitisation, Gap, Marker, Truth, iq_names


def test_codes_come_back_untouched_whatever_the_block_sizes(tmp_path: Path) -> None:
    samples = codes(6, 3210)
    path = tmp_path / "run-0001.h5"
    with RunWriter(path, int16_digitisation(), started_at="now", trigger_index=7) as writer:
        first = 0
        for count in (1, 499, 500, 501, 1, 1708):
            writer.write(Block(samples[:, first : first + count], 5000 + first))
            first += count
        assert writer.count == 3210
    recording = read_run(path)
    assert recording.raw.dtype == np.int16
    np.testing.assert_array_equal(recording.raw, samples)
    assert recording.digitisation == int16_digitisation()
    assert (recording.name, recording.gaps, recording.trigger_index) == ("run-0001", (), 7)
    assert recording.started_at == "now"
    assert run_is_complete(path)


def test_volts_come_back_to_the_last_bit(tmp_path: Path) -> None:
    samples = volts(2, 777)
    path = tmp_path / "run.h5"
    with RunWriter(path, Digitisation(("I1", "Q1"), 100.0), started_at="") as writer:
        writer.write(Block(samples, 0))
    recording = read_run(path)
    np.testing.assert_array_equal(recording.raw, samples)
    assert recording.digitisation.scaling is None
    assert recording.trigger_index is None


def test_plain_hdf5_shows_the_layout_of_the_contract(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    samples = write_run(path)
    with h5py.File(path) as file:
        raw = file["raw"]
        assert raw.shape == samples.shape
        assert raw.chunks == (1, 500)
        assert (raw.compression, raw.compression_opts, raw.shuffle) == ("gzip", 1, True)
        for place in (file, raw):
            assert place.attrs["sample_rate_hz"] == 1000.0
            assert place.attrs["unit"].decode() == "V"
            assert [name.decode() for name in place.attrs["channel_names"]] == list(iq_names(3))
            assert place.attrs["channel_skew_s"] == 5e-6
            assert place.attrs["trigger_index"] == -1
            assert np.isnan(place.attrs["trigger_time_s"])
            np.testing.assert_allclose(place.attrs["scaling"][:, 1], 1.5e-4)
        assert file["gaps"][0]["first_index"] == 900
        assert file["gaps"][0]["count"] == 10
        assert file["truth/position_m"].shape == (3, 1800)
        assert set(file) == {"raw", "gaps", "markers", "truth", "overview"}


def test_a_gap_is_recorded_from_the_first_sample_written(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    samples = codes(6, 300)
    with RunWriter(path, int16_digitisation(), started_at="") as writer:
        writer.write(Block(samples[:, :100], 7000, Gap(6000, 1000, "before the recording")))
        writer.write(Block(samples[:, 100:200], 7125, Gap(7100, 25, "overflow")))
        writer.write(Block(samples[:, 200:], 7230))
    recording = read_run(path)
    assert recording.gaps == (Gap(100, 25, "overflow"), Gap(225, 5, ""))
    assert recording.index()[[0, 99, 100, 199, 200]].tolist() == [0, 99, 125, 224, 230]


def test_blocks_that_do_not_fit_are_refused(tmp_path: Path) -> None:
    with RunWriter(tmp_path / "run.h5", int16_digitisation(), started_at="") as writer:
        writer.write(Block(codes(6, 10), 0))
        with pytest.raises(FileError, match="written already"):
            writer.write(Block(codes(6, 10), 9))
        with pytest.raises(FileError, match="does not fit"):
            writer.write(Block(volts(6, 10), 10))
        with pytest.raises(FileError, match="does not fit"):
            writer.write(Block(codes(4, 10), 10))
        writer.write(Block(codes(6, 10), 10))
    assert read_run(tmp_path / "run.h5").n_samples == 20


def test_a_file_that_is_there_is_never_overwritten(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    path.write_text("precious", encoding="utf-8")
    with pytest.raises(RunExistsError, match="not overwritten"):
        RunWriter(path, int16_digitisation(), started_at="")
    assert path.read_text(encoding="utf-8") == "precious"


def test_a_folder_that_is_not_there_is_refused_in_one_line(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="cannot be made") as refused:
        RunWriter(tmp_path / "none" / "run.h5", int16_digitisation(), started_at="")
    assert "\n" not in str(refused.value)


def test_marker_trigger_truth_and_setup_come_back(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    truth = Truth(volts(3, 40), volts(3, 40), np.array([]))
    attributes = {"seed": 3, "source": "simulated"}
    with RunWriter(path, int16_digitisation(), started_at="", trigger_index=11, attributes=attributes) as writer:
        writer.write(Block(codes(6, 40), 0))
        writer.add_marker(3, "Kugel\0 liegt schräg" + "x" * 2000)
        writer.write_truth(Truth(volts(3, 4), volts(3, 4), np.array([1.0])))
        writer.write_truth(truth)
    assert read_run(path).trigger_index == 11
    (marker,) = read_markers(path)
    assert marker.index == 3
    assert marker.text.startswith("Kugel  liegt schräg")
    back = read_run_truth(path)
    assert back is not None
    np.testing.assert_array_equal(back.position_m, truth.position_m)
    assert back.impact_time_s.shape == (0,)
    assert read_run_setup(path) is None
    assert read_summary(path) is None
    with h5py.File(path) as file:
        assert file.attrs["seed"] == 3


def test_a_run_that_was_never_closed_opens_and_says_so(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    samples = codes(6, 1300)
    writer = RunWriter(path, int16_digitisation(), started_at="", trigger_index=4)
    assert read_run(path).raw.shape == (6, 0)
    writer.write(Block(samples, 0))
    recording = read_run(path)
    np.testing.assert_array_equal(recording.raw, samples[:, :1000])
    assert recording.trigger_index == 4
    assert not run_is_complete(path)
    writer.close()
    assert read_run(path).n_samples == 1300
    assert run_is_complete(path)


def test_a_run_that_ended_by_a_failure_keeps_all_samples_and_says_so(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"

    def fail() -> None:
        with RunWriter(path, int16_digitisation(), started_at="") as writer:
            writer.write(Block(codes(6, 1300), 0))
            raise KeyError("the source failed")

    with pytest.raises(KeyError):
        fail()
    assert read_run(path).n_samples == 1300
    assert not run_is_complete(path)


def test_closing_twice_is_harmless_and_nothing_is_written_after(tmp_path: Path) -> None:
    writer = RunWriter(tmp_path / "run.h5", int16_digitisation(), started_at="")
    writer.close()
    writer.close()
    assert writer.closed
    before = writer.path.read_bytes()
    for late in (
        lambda: writer.write(Block(codes(6, 1), 0)),
        lambda: writer.add_marker(0, ""),
        lambda: writer.mark(""),
    ):
        with pytest.raises(FileError, match=r"run\.h5 is closed: nothing more can be written to it"):
            late()
    assert writer.path.read_bytes() == before


def test_a_mark_stands_at_the_newest_sample_counted_from_the_first_one_written(tmp_path: Path) -> None:
    with RunWriter(tmp_path / "run.h5", int16_digitisation(), started_at="") as writer:
        assert writer.mark("before the first") == 0
        writer.write(Block(codes(6, 120), 5000))
        assert writer.mark("here") == 120
    assert read_markers(writer.path) == (Marker(0, "before the first"), Marker(120, "here"))


def test_what_is_left_of_a_disk_that_is_nearly_full_is_not_spent_on_the_overview(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    usage = namedtuple("usage", "total used free")
    left = int(1.5 * RESERVE_BYTES)
    monkeypatch.setattr(shutil, "disk_usage", lambda _: usage(1, 1, left))
    with RunWriter(tmp_path / "run.h5", int16_digitisation(), started_at="") as writer:
        writer.write(Block(codes(6, 600), 0))
    assert run_is_complete(writer.path)
    with h5py.File(writer.path) as file:
        assert "overview" not in file


def test_a_run_is_on_the_disk_itself_once_it_is_closed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    synced: list[int] = []
    writer = RunWriter(tmp_path / "run.h5", int16_digitisation(), started_at="")
    monkeypatch.setattr(os, "fsync", lambda _: synced.append(len(writer.path.read_bytes())))
    writer.write(Block(codes(6, 600), 0))
    assert synced == []
    writer.close()
    assert synced == [writer.path.stat().st_size]


def test_two_runs_are_written_at_the_same_time_with_markers_from_another_thread(tmp_path: Path) -> None:
    samples = codes(6, 2000)
    writers = [RunWriter(tmp_path / f"{k}.h5", int16_digitisation(), started_at="") for k in range(2)]

    def mark() -> None:
        for k in range(20):
            writers[0].add_marker(k, f"note {k}")

    thread = threading.Thread(target=mark)
    thread.start()
    for first in range(0, 2000, 40):
        for writer in writers:
            writer.write(Block(samples[:, first : first + 40], first))
    thread.join()
    for writer in writers:
        writer.close()
        np.testing.assert_array_equal(read_run(writer.path).raw, samples)
    assert read_markers(writers[0].path) == tuple(Marker(k, f"note {k}") for k in range(20))


def test_a_disk_that_fills_up_ends_the_recording_with_every_sample_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    usage = namedtuple("usage", "total used free")
    path = tmp_path / "run.h5"
    writer = RunWriter(path, int16_digitisation(), started_at="")
    writer.write(Block(codes(6, 600), 0))
    monkeypatch.setattr(shutil, "disk_usage", lambda _: usage(1, 1, 1000))
    with pytest.raises(FileError, match=r"the disk is full; the first 1 s of the recording are kept"):
        writer.write(Block(codes(6, 400), 600))
    writer.close()
    assert read_run(path).n_samples == 1000
    assert not run_is_complete(path)
    with pytest.raises(FileError, match="the disk is full"):
        RunWriter(tmp_path / "second.h5", int16_digitisation(), started_at="")
    assert not (tmp_path / "second.h5").exists()


@pytest.mark.parametrize("number", [0, 1, 2, 7, 12, 23])
def test_a_write_that_fails_leaves_what_was_written_before(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, number: int
) -> None:
    disk = FailingDisk(monkeypatch)
    samples = codes(6, 5000)
    path = tmp_path / "run.h5"
    writer = RunWriter(path, int16_digitisation(), started_at="")
    writer.write(Block(samples[:, :1000], 0))
    disk.left = number
    with pytest.raises(FileError, match="the disk is full"):  # noqa: PT012
        for first in range(1000, 5000, 100):
            writer.write(Block(samples[:, first : first + 100], first))
    writer.close()
    recording = read_run(path)
    assert recording.n_samples >= 1000
    assert recording.n_samples % 500 == 0
    np.testing.assert_array_equal(recording.raw, samples[:, : recording.n_samples])
    assert not run_is_complete(path)


_CHILD = """
import sys
from pathlib import Path
import numpy as np
from radargui.files.run_writer import RunWriter
from radargui.model.recording import Block
from radargui.model.recording import Digitisation, iq_names
digitisation = Digitisation(iq_names(3), 2000.0, ((0.0, 1e-4),) * 6)
writer = RunWriter(Path(sys.argv[1]), digitisation, started_at="")
for first in range(0, 10**9, 100):
    row = np.arange(first, first + 100) % 30000
    writer.write(Block(np.repeat(row[None], 6, axis=0).astype(np.int16), first))
    if writer.count % 1000 == 0:
        print(writer.count, flush=True)
"""


@pytest.mark.parametrize("n_lines", [1, 7, 23])
def test_a_killed_recording_loses_nothing_that_was_flushed(tmp_path: Path, n_lines: int) -> None:
    path = tmp_path / "run.h5"
    with subprocess.Popen([sys.executable, "-c", _CHILD, str(path)], stdout=subprocess.PIPE, text=True) as child:
        assert child.stdout is not None
        flushed = [int(child.stdout.readline()) for _ in range(n_lines)][-1]
        child.kill()
        child.stdout.read()
    recording = read_run(path)
    assert recording.n_samples >= flushed
    np.testing.assert_array_equal(recording.raw[5], np.arange(recording.n_samples) % 30000)
    assert not run_is_complete(path)
