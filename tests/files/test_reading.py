"""Any file as a recording."""

from __future__ import annotations

from pathlib import Path

import pytest
from support.file_samples import volts, write_csv

from radargui.files.formats import list_channels
from radargui.files.reading import read_recording
from radargui.model.errors import FileError, UsageError


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


@pytest.mark.parametrize("rate_hz", [0.0, -1.0, float("nan"), float("inf")])
def test_a_rate_that_is_none_is_wrong_usage(tmp_path: Path, rate_hz: float) -> None:
    path = write_csv(tmp_path / "a.csv", volts(2, 5), rate_hz=None)
    with pytest.raises(UsageError, match="--rate-hz"):
        read_recording(path, rate_hz=rate_hz)
