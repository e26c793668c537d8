"""MATLAB files, v5 and 7.3."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path

import h5py
import numpy as np
import pytest
import scipy.io
from support.file_samples import volts, write_mat5, write_mat73

from radargui.files.formats import list_channels
from radargui.files.reading import parse_channel_map, read_recording
from radargui.model.errors import FileError

SAMPLES = volts(2, 400)


@pytest.fixture(params=["v5", "v5 plain", "v7.3"])
def mat(request: pytest.FixtureRequest, tmp_path: Path) -> Path:
    path = tmp_path / "a.mat"
    if request.param == "v7.3":
        return write_mat73(path, SAMPLES)
    return write_mat5(path, SAMPLES, compressed=request.param == "v5")


def test_vectors_named_i_and_q_are_read_with_their_rate(mat: Path) -> None:
    recording = read_recording(mat)
    np.testing.assert_array_equal(recording.raw, SAMPLES)
    assert recording.digitisation.sample_rate_hz == 2000.0


def test_fields_of_a_structure_are_read_with_the_rate_and_unit_beside_them(mat: Path) -> None:
    channels = parse_channel_map("I1=src1.Data,Q1=I1")
    with pytest.raises(FileError, match="different sample rates"):
        read_recording(mat, channels=channels)
    found = {info.name: info for info in list_channels(mat)}
    assert set(found) == {"src1.Data", "I1", "Q1"}
    assert (found["src1.Data"].count, found["src1.Data"].sample_rate_hz) == (400, 1000.0)
    assert found["src1.Data"].unit in ("V", "mV")
    assert found["I1"].sample_rate_hz == 2000.0


def test_what_is_no_vector_is_refused_by_name(mat: Path) -> None:
    for name, said in (("table", "table is no real vector"), ("Fs", "a single value"), ("nothing", "holds no nothing")):
        with pytest.raises(FileError, match=said):
            read_recording(mat, channels=parse_channel_map(f"I1={name},Q1=I1"))


def test_a_vector_of_times_is_the_files_own_time(tmp_path: Path) -> None:
    path = tmp_path / "a.mat"
    scipy.io.savemat(path, {"I1": SAMPLES[0], "Q1": SAMPLES[1], "time_s": np.arange(400) / 250.0})
    recording = read_recording(path)
    assert recording.digitisation.sample_rate_hz == 250.0
    assert recording.file_time_s is not None
    assert [info.name for info in list_channels(path)] == ["I1", "Q1"]


def test_variables_that_are_no_numbers_do_not_disturb(tmp_path: Path) -> None:
    path = tmp_path / "a.mat"
    scipy.io.savemat(
        path,
        {
            "I1": SAMPLES[0].astype(np.int16),
            "Q1": SAMPLES[1] > 0,
            "fs": 10,
            "z": SAMPLES[0] + 1j * SAMPLES[1],
            "cells": np.array([[1.0, "x"], ["y", 2.0]], dtype=object),
            "rows": np.array([{"a": 1}, {"a": 2}]),
            "sparse": scipy.sparse.csc_array(np.eye(3)),
            "text": "hello",
            "empty": np.array([]),
        },
    )
    recording = read_recording(path)
    np.testing.assert_array_equal(recording.raw[0], SAMPLES[0].astype(np.int16))
    assert recording.digitisation.sample_rate_hz == 10.0
    assert [info.name for info in list_channels(path)] == ["I1", "Q1"]
    with pytest.raises(FileError, match="z is no real vector"):
        read_recording(path, channels=parse_channel_map("I1=z,Q1=I1"))


def test_not_a_number_in_the_samples_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.mat"
    scipy.io.savemat(path, {"I1": [1.0, np.nan, 3.0], "Q1": [1.0, 2.0, 3.0], "Fs": 10.0})
    with pytest.raises(FileError, match="I1 holds 1 sample that are not numbers, the first is sample 2"):
        read_recording(path)


def _matrix(dimensions: tuple[int, ...], data: bytes, *, kind: int = 6, data_type: int = 9) -> bytes:
    def element(number: int, content: bytes) -> bytes:
        return struct.pack("<II", number, len(content)) + content + b"\0" * (-len(content) % 8)

    inside = element(6, struct.pack("<II", kind, 0)) + element(5, struct.pack(f"<{len(dimensions)}i", *dimensions))
    inside += element(1, b"I1") + element(data_type, data)
    return struct.pack("<II", 14, len(inside)) + inside


def _file(*elements: bytes) -> bytes:
    return b"MATLAB 5.0".ljust(124) + b"\x00\x01IM" + b"".join(elements)


def _packed(element: bytes) -> bytes:
    packed = zlib.compress(element)
    return struct.pack("<II", 15, len(packed)) + packed


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (_file(_matrix((1, 2**31 - 1), b"\0" * 16)), "claims 2.15e"),
        (_file(_matrix((2**31 - 1, 2**31 - 1), b"", kind=1)), "claims 4.61e"),
        (_file(_matrix((1, -5), b"")), "malformed"),
        (_file(_matrix((1, 2), b"\0" * 16, data_type=99)), "unknown type 99"),
        (_file(_matrix((1, 2), b"\0" * 16, kind=77)), "unknown class 77"),
        (_file(_matrix((1, 2), b"\0" * 16)[:-8]), "cut off"),
        (_file(_packed(struct.pack("<II", 14, 2**31))), "claims 2.15 GB"),
        (_file(_packed(_matrix((1, 2), b"\0" * 16))[:-6]), "cut off"),
        (_file(_packed(_packed(b""))), "something else than a variable"),
        (_file() [:100], "too short"),
        (b"MATLAB 4".ljust(200, b"\0"), "not of MATLAB version 5"),
    ],
)  # fmt: skip
def test_hostile_headers_are_refused_before_memory_is_asked_for(tmp_path: Path, content: bytes, said: str) -> None:
    path = tmp_path / "a.mat"
    path.write_bytes(content)
    with pytest.raises(FileError, match=said):
        read_recording(path)


def test_the_frame_of_those_hostile_files_is_right(tmp_path: Path) -> None:
    path = tmp_path / "a.mat"
    good = _matrix((1, 2), struct.pack("<2d", 1.5, 2.5))
    for content in (_file(good), _file(_packed(good))):
        path.write_bytes(content)
        assert [info.name for info in list_channels(path)] == ["I1"]


def test_a_new_file_that_claims_terabytes_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.mat"
    with h5py.File(path, "w", userblock_size=512) as file:
        for name in ("I1", "Q1"):
            data = file.create_dataset(name, shape=(1, 10**12), dtype="f8", chunks=(1, 1000), compression="gzip")
            data[0, :1000] = 1.0
        file["Fs"] = 1000.0
    with pytest.raises(FileError, match="I1 claims 8e"):
        read_recording(path)
    assert [info.count for info in list_channels(path)] == [10**12, 10**12]


def test_links_out_of_a_new_file_are_not_followed(tmp_path: Path) -> None:
    write_mat73(tmp_path / "other.mat", SAMPLES)
    path = tmp_path / "a.mat"
    with h5py.File(path, "w", userblock_size=512) as file:
        file["I1"] = h5py.ExternalLink("other.mat", "I1")
        file["loop"] = h5py.SoftLink("/")
        file["Q1"] = SAMPLES[0]
    assert [info.name for info in list_channels(path)] == ["Q1"]


@pytest.mark.parametrize(
    ("value", "told"),
    [
        (736973.4409360648, "2017-10-05T10:34:56.876"),
        ("05-Oct-2017 10:34:56", "2017-10-05T10:34:56"),
        ("2017-10-05T10:34:56+02:00", "2017-10-05T10:34:56+02:00"),
        (np.array([2017.0, 10, 5, 10, 34, 56.875]), "2017-10-05T10:34:56.875"),
        ("yesterday", ""),
        (3.0, ""),
        (1e300, ""),
        (np.array([2017.0, 13, 5, 10, 34, 56.875]), ""),
    ],
)
def test_a_date_beside_a_vector_is_when_the_recording_began(tmp_path: Path, value: object, told: str) -> None:
    path = tmp_path / "a.mat"
    scipy.io.savemat(path, {"src1": {"I": SAMPLES[0], "Q": SAMPLES[1], "SampleFrequency": 500.0, "DateTime": value}})
    recording = read_recording(path, channels=parse_channel_map("I1=src1.I,Q1=src1.Q"))
    assert recording.started_at == told
