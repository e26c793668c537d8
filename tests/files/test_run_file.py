"""The run file read back: results beside the samples, and what is refused."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest
from support.failing_disk import FailingDisk
from support.file_samples import codes, default_setup, int16_digitisation, result_of, write_run
from support.run_contents import read_markers, read_run_truth, read_summary

from radargui.files.run_card import summarise
from radargui.files.run_file import read_run, read_run_setup, run_is_complete
from radargui.files.run_results import write_results
from radargui.files.run_writer import RunWriter
from radargui.model.errors import FileError, SetupError
from radargui.model.recording import Block
from radargui.model.result import RunResult


def test_everything_a_run_file_holds_comes_back(tmp_path: Path) -> None:
    path = tmp_path / "run-0003.h5"
    samples = write_run(path)
    recording = read_run(path)
    np.testing.assert_array_equal(recording.raw, samples)
    assert recording.started_at == "2026-11-20T15:04:05+01:00"
    assert read_run_setup(path) == default_setup()
    assert read_markers(path)[0].text == "Größe 10 mm"
    truth = read_run_truth(path)
    assert truth is not None
    assert truth.impact_time_s.tolist() == [0.5, 0.9]


def test_results_are_kept_beside_the_samples_and_the_rest_stays(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    samples = write_run(path)
    recording = read_run(path)
    result = result_of(recording)
    write_results(path, result)
    assert read_summary(path) == summarise(result)
    np.testing.assert_array_equal(read_run(path).raw, samples)
    assert read_run(path).gaps == recording.gaps
    assert read_run(path).digitisation == recording.digitisation
    assert read_run_setup(path) == default_setup()
    assert read_run_truth(path) is not None
    assert run_is_complete(path)
    assert result.track is not None
    with h5py.File(path) as file:
        results = file["results"]
        assert results.attrs["correction"].decode() == "published"
        assert results.attrs["geometry"].decode() == "exact"
        assert json.loads(results.attrs["warnings"]) == ["A warning."]
        np.testing.assert_array_equal(results["track/position_m"][:], result.track.position_m)
        assert results["track/valid"].dtype == bool
        assert results["paths/change_m"].shape == (3, 1800)
        assert results["bounces"]["e"].tolist() == [0.8, 0.5]
        assert results["bounces"].attrs["g_m_s2"] == 9.81
    assert sorted(tmp_path.iterdir()) == [path]


def test_replaced_results_do_not_make_the_file_grow(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    write_run(path)
    result = result_of(read_run(path))
    write_results(path, result)
    size = path.stat().st_size
    for _ in range(3):
        write_results(path, result)
    assert path.stat().st_size == size
    write_results(path, RunResult(result.recording, result.setup, "no_motion"))
    summary = read_summary(path)
    assert summary is not None
    assert (summary["status"], summary["e"], summary["verdict"]) == ("no_motion", None, None)


def test_results_that_cannot_be_saved_leave_the_recording_as_it_was(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "run.h5"
    write_run(path)
    before, result = path.read_bytes(), result_of(read_run(path))
    FailingDisk(monkeypatch).left = 0
    with pytest.raises(FileError, match=r"cannot be saved: the disk is full\. The recording is as it was"):
        write_results(path, result)
    assert path.read_bytes() == before
    assert sorted(tmp_path.iterdir()) == [path]


def test_the_summary_tells_the_first_bounce_and_the_worst_verdict(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    write_run(path)
    summary = summarise(result_of(read_run(path)))
    assert summary == {
        "status": "ok",
        "reason": "",
        "drop_height_m": 0.26,
        "impact_speed_m_s": 2.0,
        "e": 0.8,
        "u_e": 0.01,
        "u_e_combined": None,
        "e_times": None,
        "u_e_times": None,
        "g_m_s2": 9.81,
        "u_g_m_s2": 0.02,
        "u_g_combined_m_s2": None,
        "correction": "published",
        "geometry": "exact",
        "version": summary["version"],
        "n_bounces": 2,
        "preliminary": False,
        "verdict": "usable",
        "from_rest": False,
        "warnings": ["A warning."],
    }
    json.dumps(summary, allow_nan=False)


def test_the_summary_tells_no_coefficient_where_the_first_bounce_supports_none(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    write_run(path)
    result = result_of(read_run(path))
    first, second = result.bounces.impacts
    spoiled = replace(result, bounces=replace(result.bounces, impacts=(replace(first, valid=False), second)))
    summary = summarise(spoiled)
    assert (summary["e"], summary["impact_speed_m_s"], summary["n_bounces"]) == (None, None, 2)


def test_a_file_that_is_no_run_is_refused_in_one_line(tmp_path: Path) -> None:
    foreign = tmp_path / "foreign.h5"
    with h5py.File(foreign, "w") as file:
        file["x"] = 1
    text = tmp_path / "text.h5"
    text.write_text("no HDF5 at all", encoding="utf-8")
    empty = tmp_path / "empty.h5"
    empty.touch()
    for path, said in (
        (foreign, "is HDF5, but not a run file"),
        (text, "cannot be read as a run file"),
        (empty, "is empty"),
        (tmp_path / "none.h5", "no such file"),
        (tmp_path, "is a folder"),
    ):
        for read in (read_run, read_run_setup, read_run_truth, read_summary, read_markers, run_is_complete):
            with pytest.raises(FileError, match=said) as refused:
                read(path)
            assert "\n" not in str(refused.value)


def test_a_run_cut_short_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    write_run(path)
    content = path.read_bytes()
    for share in (0.2, 0.7, 0.99):
        path.write_bytes(content[: int(share * len(content))])
        with pytest.raises(FileError, match=r"damaged|cannot be read"):
            read_run(path)


def test_a_header_that_claims_terabytes_is_refused_before_memory_is_asked_for(tmp_path: Path) -> None:
    path = tmp_path / "huge.h5"
    with h5py.File(path, "w") as file:
        raw = file.create_dataset("raw", shape=(6, 10**12), dtype="i2", chunks=(1, 1000), compression="gzip")
        raw[0, :1000] = 1
        raw.attrs["sample_rate_hz"] = 1000.0
        raw.attrs["channel_names"] = ["I1", "Q1", "I2", "Q2", "I3", "Q3"]
        raw.attrs["scaling"] = np.ones((6, 2))
    with pytest.raises(FileError, match=r"raw claims 1\.2e"):
        read_run(path)


def test_samples_changed_behind_the_back_are_noticed(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    write_run(path)
    with h5py.File(path, "r+") as file:
        file["raw"][3, 77] += 1
    with pytest.raises(FileError, match="its samples are damaged"):
        read_run(path)


@pytest.mark.parametrize(("place", "name", "value"), [("raw", "sample_rate_hz", 1001.0), ("/", "n_samples", 3)])
def test_a_header_changed_behind_the_back_is_noticed(tmp_path: Path, place: str, name: str, value: float) -> None:
    path = tmp_path / "run.h5"
    write_run(path)
    with h5py.File(path, "r+") as file:
        assert file[place].attrs[name] != value
        file[place].attrs.modify(name, value)
    with pytest.raises(FileError, match="its header is damaged"):
        read_run(path)


@pytest.mark.parametrize(
    ("key", "value", "said"),
    [
        ("sample_rate_hz", -1.0, "not a rate"),
        ("sample_rate_hz", np.nan, "not a rate"),
        ("sample_rate_hz", "fast", "not a rate"),
        ("channel_names", ["I1", "Q1"], "2 channel names for 6 channels"),
        ("channel_names", ["I1"] * 6, "channel names"),
        ("scaling", np.ones((5, 2)), "scaling"),
        ("scaling", np.full((6, 2), np.inf), "scaling"),
        ("scaling", None, "scaling"),
    ],
)
def test_a_run_of_another_program_with_a_bad_header_is_refused(
    tmp_path: Path, key: str, value: object, said: str
) -> None:
    attributes = {
        "sample_rate_hz": 1000.0,
        "channel_names": ["I1", "Q1", "I2", "Q2", "I3", "Q3"],
        "scaling": np.ones((6, 2)),
    }
    path = tmp_path / "run.h5"
    for change in ({}, {key: value}):
        with h5py.File(path, "w") as file:
            raw = file.create_dataset("raw", data=codes(6, 10))
            for name, given in {**attributes, **change}.items():
                if given is not None:
                    raw.attrs[name] = given
        if not change:
            assert read_run(path).digitisation.channel_names[5] == "Q3"
            continue
        with pytest.raises(FileError, match=said):
            read_run(path)


def test_samples_kept_in_another_file_are_not_read(tmp_path: Path) -> None:
    other = tmp_path / "other.h5"
    with h5py.File(other, "w") as file:
        file["raw"] = codes(6, 10)
    path = tmp_path / "run.h5"
    with h5py.File(path, "w") as file:
        file["raw"] = h5py.ExternalLink("other.h5", "raw")
    with pytest.raises(FileError, match="another file"):
        read_run(path)


def test_a_setup_of_another_version_is_a_setup_error(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    with RunWriter(path, int16_digitisation(), started_at="", setup_toml="schema = 7\n") as writer:
        writer.write(Block(codes(6, 10), 0))
    with pytest.raises(SetupError, match=r"setup in .*run\.h5"):
        read_run_setup(path)
