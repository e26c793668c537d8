"""Runs exported to other formats come back with the same samples, settings and units."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import h5py
import numpy as np
import pytest
import scipy.io
import sigmf
from nptdms import TdmsFile
from support.file_samples import codes, default_setup, int16_digitisation, volts, write_run

from radargui.files import mat_file
from radargui.files.csv_file import csv_facts
from radargui.files.formats import EXPORT_FORMATS, export_run, list_channels, own_setup_of
from radargui.files.mat_file import mat_facts
from radargui.files.reading import parse_channel_map, read_recording
from radargui.files.run_file import read_run, run_stream
from radargui.files.run_layout import PIECE
from radargui.files.run_writer import RunWriter
from radargui.files.sigmf_file import sigmf_facts
from radargui.files.tdms_file import tdms_facts
from radargui.model.errors import FileError
from radargui.model.recording import Block, Digitisation, Gap, Recording, iq_names
from radargui.model.setup import parse_setup

NAMES = tuple(EXPORT_FORMATS)
FACTS = {"csv": csv_facts, "mat": mat_facts, "tdms": tdms_facts, "sigmf": sigmf_facts}
SESSION = {"name": "2026-11-20T15-04-05", "operator": "Ödön", "notes": 'glass "bead"\nsecond line'}


@pytest.fixture
def run(tmp_path: Path) -> Path:
    """A run of codes with a gap, a marker and a setup."""
    write_run(tmp_path / "run-0001.h5")
    return tmp_path / "run-0001.h5"


def write_volts(path: Path, count: int = 700) -> Path:
    known = Digitisation(iq_names(1), 12345.678, unit="mV", channel_skew_s=3e-6, device="scope")
    with RunWriter(path, known, started_at="", trigger_index=33) as writer:
        writer.write(Block(volts(2, count) * 1e-3, 0))
    return path


def exported(run: Path, name: str, **options: object) -> tuple[Path, Recording]:
    """Export and read back."""
    paths = export_run(run, EXPORT_FORMATS[name], run.parent / "out", **options)
    return paths[0], read_recording(paths[0])


def step_v(recording: Recording) -> float:
    assert recording.digitisation.scaling is not None
    return min(abs(row[1]) for row in recording.digitisation.scaling)


@pytest.mark.parametrize("name", NAMES)
def test_samples_come_back_within_a_step_and_codes_as_codes_where_the_format_can(run: Path, name: str) -> None:
    before = read_run(run)
    _, after = exported(run, name)
    assert np.abs(after.volts() - before.volts()).max() < 1e-3 * step_v(before)
    if name != "csv":
        np.testing.assert_array_equal(after.raw, before.raw)
        assert after.raw.dtype == np.int16
        assert after.digitisation == before.digitisation


@pytest.mark.parametrize("name", NAMES)
def test_rate_skew_unit_start_names_and_lost_samples_come_back(run: Path, name: str) -> None:
    before, after = read_run(run), exported(run, name)[1]
    for key in ("channel_names", "sample_rate_hz", "channel_skew_s", "unit", "device"):
        assert getattr(after.digitisation, key) == getattr(before.digitisation, key)
    assert (after.gaps, after.started_at, after.trigger_index) == (before.gaps, before.started_at, None)
    np.testing.assert_array_equal(after.index(), before.index())


@pytest.mark.parametrize("name", NAMES)
def test_volts_come_back_to_the_last_bit_with_their_unit_and_trigger(tmp_path: Path, name: str) -> None:
    run = write_volts(tmp_path / "run-0007.h5")
    before, after = read_run(run), exported(run, name)[1]
    np.testing.assert_array_equal(after.raw, before.raw)
    assert after.digitisation == before.digitisation
    assert after.trigger_index == 33


@pytest.mark.parametrize("name", NAMES)
def test_samples_that_the_device_gave_as_no_number_come_back_so_in_their_channel(tmp_path: Path, name: str) -> None:
    samples = volts(2, 700)
    samples[0, 100:140] = np.nan
    samples[1, 300] = np.inf
    path = tmp_path / "run-0002.h5"
    with RunWriter(path, Digitisation(iq_names(1), 1000.0), started_at="") as writer:
        writer.write(Block(samples, 0))
    file, after = exported(path, name)
    np.testing.assert_array_equal(after.raw, samples)
    assert after.gaps == (), "the other channel holds numbers there"
    for one in (file, path):
        swapped = read_recording(one, channels=parse_channel_map("I1=Q1,Q1=I1"))
        np.testing.assert_array_equal(swapped.raw, samples[::-1])


def test_what_is_no_number_in_a_table_of_codes_was_damaged(run: Path) -> None:
    file, _ = exported(run, "csv")
    *rows, last = file.read_text(encoding="utf-8").splitlines(keepends=True)
    file.write_text("".join((*rows, last.replace(last.split(",")[1], "nan", 1))), encoding="utf-8")
    with pytest.raises(FileError, match="I1 holds 1 sample that are not numbers"):
        read_recording(file)


def test_a_table_that_lost_its_comments_is_taken_for_one_of_another_program(tmp_path: Path) -> None:
    samples = volts(2, 700)
    samples[0, 100] = np.nan
    path = tmp_path / "run-0002.h5"
    with RunWriter(path, Digitisation(iq_names(1), 1000.0), started_at="") as writer:
        writer.write(Block(samples, 0))
    file, _ = exported(path, "csv")
    lines = file.read_text(encoding="utf-8").splitlines(keepends=True)
    file.write_text("".join(line for line in lines if not line.startswith("#")), encoding="utf-8")
    with pytest.raises(FileError, match="I1 holds 1 sample that are not numbers, the first is sample 101"):
        read_recording(file)


@pytest.mark.parametrize("name", NAMES)
def test_settings_markers_and_session_travel_along(run: Path, name: str) -> None:
    path, _ = exported(run, name, session=SESSION)
    facts = FACTS[name](path)
    assert facts is not None
    assert parse_setup(facts.setup_toml) == default_setup()
    assert own_setup_of(path) == parse_setup(facts.setup_toml)
    assert [(marker.index, marker.text) for marker in facts.markers] == [(5, "Größe 10 mm")]
    assert facts.session == SESSION


@pytest.mark.parametrize("name", NAMES)
def test_the_channels_are_listed_with_rate_and_count(run: Path, name: str) -> None:
    path, _ = exported(run, name)
    infos = list_channels(path)
    assert [info.name for info in infos] == list(iq_names(3))
    assert {info.count for info in infos} == {1800}
    assert {info.sample_rate_hz for info in infos} == {1000.0}


@pytest.mark.parametrize("name", NAMES)
def test_what_is_there_is_left_alone_without_force(run: Path, name: str) -> None:
    path, _ = exported(run, name)
    path.write_bytes(b"mine")
    with pytest.raises(FileError, match="there already"):
        exported(run, name)
    assert path.read_bytes() == b"mine"
    assert exported(run, name, force=True)[1].n_samples == 1800


@pytest.mark.parametrize("name", NAMES)
def test_a_run_whose_samples_are_damaged_leaves_no_file_behind(run: Path, name: str) -> None:
    with h5py.File(run, "r+") as file:
        file["raw"][2, 100] = file["raw"][2, 100] ^ 1
    with pytest.raises(FileError, match="damaged"):
        exported(run, name)
    assert list((run.parent / "out").iterdir()) == []


@pytest.mark.parametrize("name", NAMES)
def test_a_folder_that_cannot_be_made_is_told(run: Path, name: str) -> None:
    (run.parent / "out").write_text("a file", encoding="utf-8")
    with pytest.raises(FileError, match="cannot be made"):
        exported(run, name)


@pytest.mark.parametrize("name", NAMES)
def test_a_run_of_several_pieces_and_a_higher_scaling_comes_back(tmp_path: Path, name: str) -> None:
    scaling = ((0.01, 1.5e-4, 1e-11, -1e-16),) * 2
    with RunWriter(tmp_path / "run-0001.h5", Digitisation(iq_names(1), 1e4, scaling), started_at="") as writer:
        writer.write(Block(codes(2, PIECE + 1000), 0))
    shares: list[float] = []
    _, after = exported(tmp_path / "run-0001.h5", name, report=shares.append)
    before = read_run(tmp_path / "run-0001.h5")
    assert np.abs(after.volts() - before.volts()).max() < 1e-7
    assert shares == sorted(shares)
    assert shares[-1] == 1.0


def test_a_long_run_becomes_a_7_3_file_with_the_same_variables(run: Path, tmp_path: Path) -> None:
    short, path = scipy.io.loadmat(exported(run, "mat")[0]), tmp_path / "long.mat"
    with run_stream(run) as stream:
        mat_file.write_mat(stream, path, lambda _: None, largest_v5_bytes=1000)
    before, after = read_run(run), read_recording(path)
    np.testing.assert_array_equal(after.raw, before.raw)
    assert after.digitisation == before.digitisation
    assert path.read_bytes()[:19] == b"MATLAB 7.3 MAT-file"
    with h5py.File(path) as file:
        assert set(file) == {name for name in short if not name.startswith("__")}
        np.testing.assert_array_equal(file["I2"][...].T, short["I2"])
        np.testing.assert_array_equal(file["codes"][...].T, short["codes"])
        np.testing.assert_array_equal(file["scaling"][...].T, short["scaling"])
        assert "".join(map(chr, file["unit"][:, 0])) == "V"
        assert file["Fs"].attrs["MATLAB_class"] == b"double"


def test_values_that_were_changed_in_matlab_count_more_than_the_codes_beside_them(run: Path) -> None:
    path, before = exported(run, "mat")
    content = {key: value for key, value in scipy.io.loadmat(path).items() if not key.startswith("__")}
    content["Q2"] = content["Q2"] * 1.5
    scipy.io.savemat(path, content)
    after = read_recording(path)
    np.testing.assert_allclose(after.volts()[3], before.volts()[3] * 1.5)
    assert after.raw.dtype == np.float64


def test_a_csv_file_that_was_cut_is_taken_for_what_it_says(run: Path) -> None:
    path, _ = exported(run, "csv")
    lines = path.read_text(encoding="utf-8").splitlines(keepends=True)
    path.write_text("".join(lines[:-200]), encoding="utf-8")
    after = read_recording(path)
    assert after.n_samples == 1600
    assert [(gap.first_index, gap.count) for gap in after.gaps] == [(900, 10)]
    assert after.digitisation.sample_rate_hz == pytest.approx(1000.0)


def test_a_stranger_reads_the_csv_with_the_standard_library(run: Path) -> None:
    path, _ = exported(run, "csv")
    text = [line for line in path.read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
    rows = list(csv.DictReader(text))
    before = read_run(run)
    assert float(rows[7]["Q3"]) == pytest.approx(before.volts()[5, 7], abs=1e-9)
    assert [float(row["time_s"]) for row in rows] == pytest.approx(before.time_s(), abs=1e-9)
    assert rows[0]["time_s"] == "0.000000000"


def test_labview_sees_volts_and_times_in_the_tdms(run: Path) -> None:
    path, _ = exported(run, "tdms", session=SESSION)
    with TdmsFile.open(path) as file:
        channel = file["run-0001"]["I2"]
        np.testing.assert_allclose(channel[:], read_run(run).volts()[2], atol=1e-12)
        assert channel.properties["unit_string"] == "V"
        assert channel.properties["wf_increment"] == 1e-3
        assert channel.properties["wf_start_time"] == np.datetime64("2026-11-20T14:04:05")
        assert file["run-0001"].properties["operator"] == "Ödön"


@pytest.mark.parametrize("make", [lambda path: write_run(path), write_volts], ids=["codes", "volts"])
def test_the_sigmf_recording_is_valid_for_the_package_of_the_standard(tmp_path: Path, make: object) -> None:
    make(tmp_path / "run-0001.h5")  # type: ignore[operator]
    meta, data = export_run(tmp_path / "run-0001.h5", EXPORT_FORMATS["sigmf"], tmp_path)
    handle = sigmf.fromfile(str(meta), skip_checksum=False)
    handle.validate()
    before = read_run(tmp_path / "run-0001.h5")
    assert handle.sample_count == before.n_samples
    assert handle.get_global_field("core:num_channels") == before.n_receivers
    assert data.stat().st_size == before.raw.nbytes
    assert json.loads(meta.read_text(encoding="utf-8"))["global"]["core:extensions"][0]["optional"] is True


def test_a_mark_among_lost_samples_stands_at_the_first_sample_after_them_in_sigmf(tmp_path: Path) -> None:
    known = Digitisation(iq_names(1), 1000.0, device="scope")
    with RunWriter(tmp_path / "run-0001.h5", known, started_at="", trigger_index=50) as writer:
        writer.write(Block(volts(2, 40), 0))
        writer.write(Block(volts(2, 60), 65, Gap(40, 25, "late")))
        for index in (39, 65, 70):
            writer.add_marker(index, str(index))
    meta, _ = export_run(tmp_path / "run-0001.h5", EXPORT_FORMATS["sigmf"], tmp_path)
    marks = json.loads(meta.read_text(encoding="utf-8"))["annotations"]
    stored = {one["core:comment"]: one["core:sample_start"] for one in marks}
    assert stored == {"39": 39, "trigger": 40, "65": 40, "70": 45}


def test_a_sigmf_archive_of_the_pair_keeps_the_facts(run: Path, tmp_path: Path) -> None:
    meta, _ = export_run(run, EXPORT_FORMATS["sigmf"], tmp_path / "out")
    sigmf.fromfile(str(meta), autoscale=False).archive(str(tmp_path / "b.sigmf"))
    after = read_recording(tmp_path / "b.sigmf")
    np.testing.assert_array_equal(after.volts(), read_run(run).volts())
    assert own_setup_of(tmp_path / "b.sigmf") == own_setup_of(run)


def test_a_recording_that_a_crash_cut_short_is_exported_as_far_as_it_goes(tmp_path: Path) -> None:
    writer = RunWriter(tmp_path / "run-0001.h5", int16_digitisation(), started_at="")
    writer.write(Block(codes(6, 1000), 0))
    copy = tmp_path / "run-0002.h5"
    copy.write_bytes((tmp_path / "run-0001.h5").read_bytes())
    writer.close()
    _, after = exported(copy, "tdms")
    np.testing.assert_array_equal(after.raw, codes(6, 1000))


def test_gaps_at_both_ends_come_back(tmp_path: Path) -> None:
    with RunWriter(tmp_path / "run-0001.h5", int16_digitisation(), started_at="") as writer:
        writer.write(Block(codes(6, 1), 0))
        writer.write(Block(codes(6, 500), 5, Gap(1, 4, "late")))
        writer.write(Block(codes(6, 1), 600, Gap(505, 95, "again")))
    before = read_run(tmp_path / "run-0001.h5")
    for name in NAMES:
        after = exported(tmp_path / "run-0001.h5", name)[1]
        assert after.gaps == before.gaps
        np.testing.assert_array_equal(after.time_s(), before.time_s())
