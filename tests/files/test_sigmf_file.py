"""SigMF recordings."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

import numpy as np
import pytest
import sigmf
from support.file_samples import volts, write_sigmf

from radargui.files.formats import list_channels
from radargui.files.reading import parse_channel_map, read_recording
from radargui.model.errors import FileError
from radargui.model.recording import Gap

_RNG = np.random.default_rng(3)
CODES = _RNG.integers(-32768, 32767, (120, 4), dtype=np.int16, endpoint=True)


def test_complex_channels_are_pairs_and_codes_stay_codes(tmp_path: Path) -> None:
    meta = write_sigmf(tmp_path / "a", CODES.astype("<i2"), "ci16_le", 2)
    recording = read_recording(meta)
    assert recording.raw.dtype == np.int16
    np.testing.assert_array_equal(recording.raw, CODES.T)
    assert recording.digitisation.channel_names == ("I1", "Q1", "I2", "Q2")
    assert recording.digitisation.scaling == ((0.0, 2.0**-15),) * 4
    assert recording.digitisation.sample_rate_hz == 1000.0
    assert recording.digitisation.unit == "full scale"


@pytest.mark.parametrize(
    ("datatype", "stored", "values"),
    [
        ("cf64_le", volts(2, 50).T.astype("<f8"), volts(2, 50).T),
        ("cf32_be", volts(2, 50).T.astype(">f4"), volts(2, 50).T.astype(np.float32)),
        ("rf32_le", volts(2, 50).T.astype("<f4"), volts(2, 50).T.astype(np.float32)),
        ("ri16_be", CODES[:, :2].astype(">i2"), CODES[:, :2] / 2.0**15),
        ("ci8", CODES[:, :2].astype(np.int8), CODES[:, :2].astype(np.int8) / 128.0),
        ("cu8", CODES[:, :2].astype(np.uint8), CODES[:, :2].astype(np.uint8) / 128.0 - 1.0),
        ("ru16_le", CODES[:, :2].astype("<u2"), CODES[:, :2].astype(np.uint16) / 32768.0 - 1.0),
        ("ci32_le", CODES[:, :2].astype("<i4") * 65536 + 1, (CODES[:, :2] * 65536.0 + 1.0) / 2.0**31),
    ],
)
def test_every_kind_of_sample_is_read_exactly(
    tmp_path: Path, datatype: str, stored: np.ndarray, values: np.ndarray
) -> None:
    meta = write_sigmf(tmp_path / "a", stored, datatype, 1 if datatype.startswith("c") else 2)
    for path in (meta, meta.with_suffix(".sigmf-data")):
        np.testing.assert_array_equal(read_recording(path).volts(), values.T)


def test_an_odd_number_of_real_channels_needs_a_map(tmp_path: Path) -> None:
    meta = write_sigmf(tmp_path / "a", CODES[:, :3].astype("<i2"), "ri16_le", 3)
    assert [info.name for info in list_channels(meta)] == ["ch1", "ch2", "ch3"]
    with pytest.raises(FileError, match="I1=ch1,Q1=ch2"):
        read_recording(meta)
    recording = read_recording(meta, channels=parse_channel_map("I1=ch3,Q1=ch1"))
    np.testing.assert_array_equal(recording.raw, CODES[:, [2, 0]].T)


def test_an_archive_is_read_as_its_pair(tmp_path: Path) -> None:
    meta = write_sigmf(tmp_path / "a", CODES.astype("<i2"), "ci16_le", 2)
    archive = tmp_path / "b.sigmf"
    sigmf.fromfile(str(meta), autoscale=False).archive(str(archive))
    np.testing.assert_array_equal(read_recording(archive).raw, CODES.T)


def test_date_and_lost_samples_are_taken_from_the_captures(tmp_path: Path) -> None:
    captures = [
        {"core:sample_start": 0, "core:global_index": 500, "core:datetime": "2026-11-20T14:00:00Z"},
        {"core:sample_start": 40, "core:global_index": 565},
        {"core:sample_start": 100, "core:global_index": 625},
    ]
    meta = write_sigmf(tmp_path / "a", CODES.astype("<i2"), "ci16_le", 2, captures=captures)
    recording = read_recording(meta)
    assert recording.started_at == "2026-11-20T14:00:00+00:00"
    assert recording.gaps == (Gap(40, 25, "told by the SigMF captures"),)
    assert recording.index()[[39, 40]].tolist() == [39, 65]


def test_a_rate_is_asked_for_where_there_is_none(tmp_path: Path) -> None:
    meta = write_sigmf(tmp_path / "a", CODES.astype("<i2"), "ci16_le", 2)
    content = json.loads(meta.read_text(encoding="utf-8"))
    del content["global"]["core:sample_rate"]
    meta.write_text(json.dumps(content), encoding="utf-8")
    with pytest.raises(FileError, match="--rate-hz"):
        read_recording(meta)
    assert read_recording(meta, rate_hz=123.0).digitisation.sample_rate_hz == 123.0


def test_the_checksum_in_the_metadata_is_checked(tmp_path: Path) -> None:
    data = CODES.astype("<i2")
    right = hashlib.sha512(data.tobytes()).hexdigest()
    read_recording(write_sigmf(tmp_path / "a", data, "ci16_le", 2, **{"core:sha512": right}))
    meta = write_sigmf(tmp_path / "b", data, "ci16_le", 2, **{"core:sha512": right[::-1]})
    with pytest.raises(FileError, match="hash does not match"):
        read_recording(meta)


@pytest.mark.parametrize(
    ("facts", "said"),
    [
        ({"core:num_channels": 10**12}, "allowed 1 to 64"),
        ({"core:num_channels": 0}, "allowed 1 to 64"),
        ({"core:datatype": "ci99"}, "cannot be read as a SigMF"),
        ({"core:datatype": None}, "cannot be read as a SigMF"),
        ({"core:sample_rate": -5}, "is not a rate"),
        ({"core:sample_rate": "fast"}, "is not a rate"),
        ({"annotations": [{"core:sample_start": 100, "core:sample_count": 1000}]}, "not what its metadata say"),
        ({"core:dataset": "../../secret"}, "are missing"),
    ],
)
def test_metadata_that_cannot_be_true_are_refused(tmp_path: Path, facts: dict[str, object], said: str) -> None:
    meta = write_sigmf(tmp_path / "a", CODES.astype("<i2"), "ci16_le", 2, **facts)
    with pytest.raises(FileError, match=said):
        read_recording(meta)


def test_a_pair_that_is_not_whole_is_refused(tmp_path: Path) -> None:
    meta = write_sigmf(tmp_path / "a", CODES.astype("<i2"), "ci16_le", 2)
    data = meta.with_suffix(".sigmf-data")
    content = data.read_bytes()
    data.write_bytes(content[:-3])
    with pytest.raises(FileError, match="not what its metadata say"):
        read_recording(meta)
    data.unlink()
    with pytest.raises(FileError, match=r"samples a\.sigmf-data are missing"):
        read_recording(meta)
    data.write_bytes(content)
    meta.unlink()
    with pytest.raises(FileError, match=r"metadata a\.sigmf-meta are missing"):
        read_recording(data)
