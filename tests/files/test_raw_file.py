"""Plain binary: what `--raw` may say, and samples of every type come back as volts."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from support.file_samples import read_all_channels, volts, write_csv

from radargui.files.raw_file import RawLayout, first_seconds, list_raw, parse_raw_layout
from radargui.files.reading import parse_channel_map, read_mapped, read_recording
from radargui.model.errors import FileError, UsageError

TOY_CAR = "dtype=u2le,channels=5,header=8,rate=31250,scale=8.06e-4,offset=0,skip=300"
PAIR = parse_channel_map("I1=0,Q1=1")


def test_the_layout_of_the_manual_is_understood() -> None:
    layout = parse_raw_layout(TOY_CAR)
    assert layout == RawLayout(dtype="u2le", channels=5, header=8, rate=31250.0, scale=8.06e-4, offset=0.0, skip=300)
    assert parse_raw_layout(layout.text) == layout
    assert parse_raw_layout(" dtype = F8 , channels = 2 ") == RawLayout(dtype="f8le", channels=2)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("dtype=u3,channels=2", r'dtype = "u3", allowed: i1, u1, .*, f8, with le or be'),
        ("dtype=u2xe,channels=2", 'dtype = "u2xe", allowed'),
        ("dtype=u2,channels=0", 'channels = "0", allowed: a whole number from 1 to 64'),
        ("dtype=u2,channels=2.5", 'channels = "2.5", allowed: a whole number'),
        ("dtype=u2,channels=2,header=-1", 'header = "-1", allowed: a whole number from 0'),
        ("dtype=u2,channels=2,skip=many", 'skip = "many", allowed: a whole number from 0'),
        ("dtype=u2,channels=2,rate=0", 'rate = "0", allowed: samples per second'),
        ("dtype=u2,channels=2,rate=inf", 'rate = "inf", allowed: samples per second'),
        ("dtype=u2,channels=2,scale=0", 'scale = "0", allowed: volts of one step, a number other than 0'),
        ("dtype=u2,channels=2,offset=x", 'offset = "x", allowed: volts of the number 0'),
        ("dtype=u2", "channels is missing, allowed: a whole number from 1 to 64"),
        ("", "'', allowed: key=value"),
        ("dtype=u2,channels=2,gain=3", "gain = .*: unknown key, allowed here: dtype, channels, header"),
        ("dtype=u2,dtype=u2,channels=2", "dtype stands there twice"),
    ],
)
def test_what_a_layout_cannot_be_is_refused_by_name(text: str, said: str) -> None:
    with pytest.raises(UsageError, match=said) as refused:
        parse_raw_layout(text)
    assert "\n" not in str(refused.value)


@given(st.text(alphabet="dtypeu2lchanskrofg=,.-+0123456789 ", max_size=60))
def test_any_layout_is_understood_or_refused(text: str) -> None:
    try:
        layout = parse_raw_layout(text)
    except UsageError as error:
        assert "\n" not in str(error)  # noqa: PT017
    else:
        assert parse_raw_layout(layout.text) == layout


@settings(max_examples=60, deadline=None)
@given(
    st.sampled_from(["i1", "u1", "i2", "u2", "i4", "u4", "f4", "f8"]),
    st.sampled_from("<>"),
    st.integers(1, 6),
    st.integers(0, 9),
    st.integers(0, 3),
    st.sampled_from([1.0, -8.06e-4, 3.3]),
    st.sampled_from([0.0, -1.65]),
    st.integers(0, 2**32),
)
def test_numbers_of_every_type_come_back_as_volts(
    tmp_path_factory: pytest.TempPathFactory,
    kind: str,
    order: str,
    channels: int,
    header: int,
    skip: int,
    scale: float,
    offset: float,
    seed: int,
) -> None:
    dtype = np.dtype(order + kind)
    rng = np.random.default_rng(seed)
    if dtype.kind == "f":
        numbers = rng.normal(size=(20, channels)).astype(dtype)
    else:
        ends = np.iinfo(dtype)
        numbers = rng.integers(ends.min, ends.max, (20, channels), endpoint=True).astype(dtype)
        numbers[-2:] = np.array([[ends.min], [ends.max]])
    path = tmp_path_factory.mktemp("raw") / "a.bin"
    path.write_bytes(b"\xff" * header + numbers.tobytes())
    ending = "le" if order == "<" else "be"
    layout = parse_raw_layout(
        f"dtype={kind}{ending},channels={channels},header={header},skip={skip},scale={scale},offset={offset},rate=100"
    )
    names = [str(place) for place in range(channels)]
    recording = read_all_channels(path, layout)
    wanted = (offset + scale * numbers[skip:].astype(np.float64)).T
    np.testing.assert_allclose(recording.volts(), wanted, rtol=1e-12, atol=1e-12 * np.abs(scale) * 2.0**16)
    np.testing.assert_allclose(first_seconds(path, layout, 10.0, 5), wanted[:, :5], rtol=1e-12, atol=1e-9)
    assert list(recording.digitisation.channel_names) == names
    assert recording.raw.dtype == (np.int16 if kind in ("i1", "u1", "i2", "u2") else np.float64)
    assert recording.digitisation.unit == "V"


def test_codes_without_a_scale_are_not_called_volts(tmp_path: Path) -> None:
    path = tmp_path / "a.bin"
    path.write_bytes(np.arange(20, dtype="<u2").tobytes())
    recording = read_recording(path, channels=PAIR, raw=parse_raw_layout("dtype=u2,channels=2"), rate_hz=10.0)
    assert recording.digitisation.unit == "code"
    assert recording.volts().tolist() == [list(range(0, 20, 2)), list(range(1, 20, 2))]
    assert recording.digitisation.channel_skew_s is None


def test_a_file_too_short_for_its_layout_is_refused_and_a_rest_is_told(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    path = tmp_path / "a.bin"
    path.write_bytes(bytes(43))
    with pytest.raises(
        FileError, match="holds 43 bytes: behind a header of 8 and 9 skipped samples of 4 bytes nothing"
    ):
        list_raw(path, RawLayout(dtype="u2le", channels=2, header=8, skip=9))
    assert [info.count for info in list_raw(path, RawLayout(dtype="u2le", channels=2, header=8))] == [8, 8]
    assert "3 bytes at its end are no whole sample of 4 bytes" in caplog.text


def test_a_file_of_unknown_kind_is_told_what_raw_would_do(tmp_path: Path) -> None:
    path = tmp_path / "a.dat"
    path.write_bytes(bytes(40))
    with pytest.raises(FileError, match=r"files that end in \.dat are not read\. .*--raw dtype=u2le,channels=5"):
        read_recording(path)
    with pytest.raises(UsageError, match="is read as CSV and tells its own layout"):
        read_recording(write_csv(tmp_path / "a.csv", volts(2, 9)), raw=RawLayout(dtype="u2le", channels=2))


def test_columns_of_several_binary_files_form_one_input(tmp_path: Path) -> None:
    for name, first in (("i.bin", 0), ("q.bin", 100)):
        (tmp_path / name).write_bytes(np.arange(first, first + 8, dtype="<i2").tobytes())
    text = f"I1={tmp_path / 'i.bin'}:0,Q1={tmp_path / 'q.bin'}:1"
    layout = parse_raw_layout("dtype=i2,channels=2,rate=10")
    recording = read_mapped(parse_channel_map(text, numbered=True), name="both", raw=layout)
    assert recording.volts().tolist() == [[0, 2, 4, 6], [101, 103, 105, 107]]


@pytest.mark.skipif("RADARGUI_TEST_DATA" not in os.environ, reason="RADARGUI_TEST_DATA is unset")
@pytest.mark.parametrize(("name", "pair"), [("radarSample.dat", "I1=0,Q1=1"), ("fram_fort_1.bin", "I1=0,Q1=4")])
def test_recordings_of_a_24_ghz_radar_are_smooth_and_within_the_range_of_their_converter(name: str, pair: str) -> None:
    path = Path(os.environ["RADARGUI_TEST_DATA"], "radar-24ghz", name)
    recording = read_recording(path, channels=parse_channel_map(pair), raw=parse_raw_layout(TOY_CAR))
    assert recording.digitisation.sample_rate_hz == 31250.0
    assert recording.n_samples == (path.stat().st_size - 8) // 10 - 300
    assert 0.0 <= recording.volts().min() < recording.volts().max() <= 3.3
    # a wrong header or order of bytes makes jumps of volts between neighbours
    assert np.abs(np.diff(recording.volts())).max() < 0.3
