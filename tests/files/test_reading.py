"""Any file as a recording."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.file_samples import volts, write_csv, write_run

from radargui.files.formats import list_channels
from radargui.files.reading import read_recording
from radargui.model.errors import FileError, UsageError


def test_a_run_is_read_as_it_was_recorded(tmp_path: Path) -> None:
    path = tmp_path / "run-0001.h5"
    samples = write_run(path)
    recording = read_recording(path, rate_hz=1000.0)
    np.testing.assert_array_equal(recording.raw, samples)
    assert recording.gaps[0].count == 10
    assert [info.name for info in list_channels(path)] == ["I1", "Q1", "I2", "Q2", "I3", "Q3"]
    with pytest.raises(FileError, match="was recorded at 1000 Hz, --rate-hz says 500 Hz"):
        read_recording(path, rate_hz=500.0)


def test_the_suffix_decides_in_any_case(tmp_path: Path) -> None:
    path = write_csv(tmp_path / "A.CSV", volts(2, 5))
    assert read_recording(path).name == "A"


@pytest.mark.parametrize("name", ["a.wav", "a", "a.bin"])
def test_other_kinds_are_refused_with_the_list_of_those_read(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    path.write_bytes(b"abc")
    for read in (read_recording, list_channels):
        with pytest.raises(FileError, match=r"\.csv, \.mat, \.tdms, \.sigmf-meta"):
            read(path)


def test_what_is_not_there_is_refused(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="no such file"):
        read_recording(tmp_path / "a.csv")
    with pytest.raises(FileError, match="is a folder"):
        read_recording(tmp_path)


@pytest.mark.parametrize("rate_hz", [0.0, -1.0, float("nan"), float("inf")])
def test_a_rate_that_is_none_is_wrong_usage(tmp_path: Path, rate_hz: float) -> None:
    path = write_csv(tmp_path / "a.csv", volts(2, 5), rate_hz=None)
    with pytest.raises(UsageError, match="--rate-hz"):
        read_recording(path, rate_hz=rate_hz)
