"""CSV files: what is read, and in which words the rest is refused."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from support.file_samples import volts, write_csv

from radargui.files.formats import list_channels
from radargui.files.reading import guess_channel_map, parse_channel_map, read_recording
from radargui.model.errors import FileError
from radargui.model.recording import Gap


def written(tmp_path: Path, text: str | bytes) -> Path:
    path = tmp_path / "input.csv"
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    return path


@pytest.mark.parametrize("n_receivers", [1, 2, 3, 4])
def test_samples_times_and_rate_come_back(tmp_path: Path, n_receivers: int) -> None:
    samples = volts(2 * n_receivers, 200)
    recording = read_recording(write_csv(tmp_path / "drop.csv", samples, rate_hz=33333.0))
    np.testing.assert_array_equal(recording.raw, samples)
    assert recording.file_time_s is not None
    np.testing.assert_array_equal(recording.file_time_s, np.arange(200) / 33333.0)
    assert recording.digitisation.sample_rate_hz == 33333.0
    assert recording.n_receivers == n_receivers
    assert recording.name == "drop"
    assert recording.gaps == ()


def test_columns_in_any_order_and_others_between_are_understood(tmp_path: Path) -> None:
    path = written(tmp_path, "Q1,note,I1,time_s\n1,warm,2,0\n3,cold,4,0.5\n5,,6,1.0\n")
    recording = read_recording(path)
    assert recording.raw.tolist() == [[2, 4, 6], [1, 3, 5]]
    assert recording.digitisation.sample_rate_hz == 2.0
    assert [info.name for info in list_channels(path)] == ["Q1", "note", "I1"]


@pytest.mark.parametrize(
    "text",
    [
        "\ufefftime_s,I1,Q1\r\n0,1,2\r\n0.5,3,4\r\n",
        '"time_s" , "I1","Q1"\n0, 1 ,2\n\n0.5,3,4\n\n',
        "# made by hand\ntime_s,I1,Q1\n# twice a second\n0,1e0,2\n5e-1,+3,4.",
        "time_s,I1,Q1\r0,1,2\r0.5,3,4\r",
    ],
    ids=["mark and Windows lines", "quotes and blank lines", "comments", "old Mac lines"],
)
def test_files_of_other_programs_are_understood(tmp_path: Path, text: str) -> None:
    recording = read_recording(written(tmp_path, text))
    assert recording.raw.tolist() == [[1, 3], [2, 4]]
    assert recording.digitisation.sample_rate_hz == 2.0


def test_without_times_the_rate_is_asked_for(tmp_path: Path) -> None:
    path = write_csv(tmp_path / "a.csv", volts(2, 10), rate_hz=None)
    with pytest.raises(FileError, match="--rate-hz"):
        read_recording(path)
    recording = read_recording(path, rate_hz=500.0)
    assert recording.digitisation.sample_rate_hz == 500.0
    assert recording.file_time_s is None


def test_a_rate_that_contradicts_the_times_is_refused(tmp_path: Path) -> None:
    path = write_csv(tmp_path / "a.csv", volts(2, 10), rate_hz=100.0)
    with pytest.raises(FileError, match="its times make 100 Hz, --rate-hz says 200 Hz"):
        read_recording(path, rate_hz=200.0)
    assert read_recording(path, rate_hz=100.01).digitisation.sample_rate_hz == 100.0


def test_missing_rows_are_gaps(tmp_path: Path) -> None:
    rows = "".join(f"{k / 100:.2f},{k},0\n" for k in range(50) if k not in (10, 11, 12, 30))
    recording = read_recording(written(tmp_path, "time_s,I1,Q1\n" + rows))
    assert recording.gaps == (Gap(10, 3, "times jump"), Gap(30, 1, "times jump"))
    np.testing.assert_array_equal(recording.index(), recording.raw[0])
    assert recording.digitisation.sample_rate_hz == 100.0


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("time_s;I1;Q1\n0;1;2\n1;2\n", "a row has 2 columns, the header 3: '1;2'; columns are parted by semicolons"),
        ("t\tI1\tQ1\n0\t1\t2\n1\t2,x\t3\n", r"line 3: '2,x' in column I1 is not a number"),
        ("t;I1;Q1\n0,001;1;2\n0,002;1.234,5;3\n", "decimal points and decimal commas: '0,002;1.234,5;3'"),
        ("t;I1;Q1\n0.001;1;2\n0.002;1,234;3\n", "decimal points and decimal commas: '0.002;1,234;3'"),
        ("# two columns\n0,1,2\n1,3,4\n", "its first line holds numbers, not the names of the columns: '0,1,2'"),
        ("Time (s),Channel 1 (V)\n0,1\n1,2\n", "holds no channels named I1, Q1, ...; it holds Channel 1"),
        ("time_s,I1,Q1\n0,0,1,5,2,5\n", "a row has 6 columns, the header 3"),
        ("time_s,I1,Q1\n0,1,2\n1,2\n", "a row has 2 columns"),
        ("time_s,I1,Q1\n0,1,2\n1,2,x\n", r"line 3: 'x' in column Q1 is not a number"),
        ("time_s,I1,Q1\n0,1,2\n1,,4\n", r"line 3: '' in column I1 is not a number"),
        ("time_s,I1,Q1\n0,1,2\n1,nan,4\n", r"I1 holds 1 sample that are not numbers, the first is sample 2"),
        ("time_s,I1,Q1\n0,1,2\n1,3,1e999\n", r"Q1 holds 1 sample that are not numbers"),
        ("0,1,2\n1,3,4\n", "its first line holds numbers"),
        ("time_s,I1,I1\n0,1,2\n", "two columns are named I1"),
        ("time_s,I1,Q1\n", "holds no samples"),
        ("time_s,I1\n0,1\n1,2\n", "not complete pairs"),
        ("time_s,I1,Q2\n0,1,1\n1,2,1\n", "not complete pairs"),
        ("time_s,I1,Q1,I999999,Q5\n0,1,1,1,1\n", "not complete pairs"),
        ("time_s,a,b\n0,1,2\n", r"holds no channels named I1, Q1, ...; it holds a, b. .*--channels I1=a,Q1=b"),
        ("time_s,I1,Q1\n0,1,2\n0,1,2\n", "times do not increase at sample 2"),
        ("time_s,I1,Q1\n0,1,2\n1,1,2\n0.5,1,2\n", "times do not increase at sample 3"),
        ("time_s,I1,Q1\n0,1,2\n1,1,2\nnan,1,2\n", "the time of sample 3 is not a number"),
        ("time_s,I1,Q1\n" + "".join(f"{k * k},1,2\n" for k in range(1, 40)), "times are not uniform"),
        ("time_s,I1,Q1\n0,1,2\n", "one time is not enough"),
        ("\n\n", "holds no header"),
        (",,\n1,2,3\n", "holds no header"),
        ("time_s,I1,Q1\n0,1,2\n1,2,3".encode("utf-16"), "is not UTF-8 text"),
        ("time_s,I1,Q1,Größe\n0,1,2,3\n".encode("latin-1"), "is not UTF-8 text"),
        (b"time_s,I1,Q1\n0,1,2\n\xff\xfe,1,2\n", "is not UTF-8 text"),
        (b"\0\0\0\0\0", "is not text"),
        (b"x" * 200_000, "far too long for a header"),
        (b"", "is empty"),
    ],
)
def test_what_cannot_be_read_is_refused_in_clear_words(tmp_path: Path, text: str | bytes, said: str) -> None:
    path = written(tmp_path, text)
    with pytest.raises(FileError, match=said) as refused:
        read_recording(path)
    assert str(path) in str(refused.value)
    assert "\n" not in str(refused.value)


OF_OTHER_PROGRAMS = {
    "oscilloscope": "Time (s),Channel 1 (V),Channel 2 (V)\n0.0,1,2\n0.5,3,4\n",
    "commented header": "# Time (s), Channel 1 (V), Channel 2 (V)\n0,1,2\n0.5,3,4\n",
    "second comment is the header": "# by hand\n#\n#t [s];Channel 1 [V];Channel 2 [V]\n0;1;2\n0,5;3,0;4\n",
    "semicolons and decimal commas": "Zeit [ms];Channel 1 [V];Channel 2 [V]\r\n0;1,0;2\r\n500,0;3;4,0\r\n",
    "semicolons and decimal points": "time_s;Channel 1;Channel 2\n0;1.0;2\n0.5;3.0;4\n",
    "tabs": "Time (ms)\tChannel 1 (mV)\tChannel 2 (mV)\n0\t1000\t2000\n500\t3000\t4000\n",
    "units in a line of their own": "Time,Channel 1,Channel 2\n(ms),(mV),(V)\n\n0,1000,2\n500,3000,4\n",
    "micro": "Time (µs),Channel 1 (µV),Channel 2 (V)\n0,1e6,2\n5e5,3e6,4\n",
    "slashes": "t / ms;Channel 1 / V;Channel 2 / V\n0;1;2\n500;3;4\n",
    "blanks": "# t Channel_1 Channel_2\n 0.0  1 2\n 0.5  3 4\n",
    "titles by commas, numbers by blanks": "# t,Channel 1,Channel 2\n0.0 1 2\n0.5 3 4\n",
    "a comma in a title": 'Time (s);"Channel 1";Channel 2 (V);"warm, dry"\n0;1;2;a, b\n0,5;3;4;c\n',
    "LabVIEW": "X_Value\tChannel 1\tChannel 2\tComment\n0,0\t1\t2\t\n0,5\t3\t4\tend.\n",
}


@pytest.mark.parametrize("text", OF_OTHER_PROGRAMS.values(), ids=OF_OTHER_PROGRAMS.keys())
def test_header_separator_decimals_and_units_are_found(tmp_path: Path, text: str) -> None:
    path = written(tmp_path, text)
    first, second = (info.name for info in list_channels(path)[:2])
    assert (first.replace("_", " "), second.replace("_", " ")) == ("Channel 1", "Channel 2")
    recording = read_recording(path, channels=parse_channel_map(f"I1={first},Q1={second}"))
    np.testing.assert_allclose(recording.raw, [[1, 3], [2, 4]], rtol=1e-12)
    assert recording.digitisation.sample_rate_hz == 2.0
    assert recording.digitisation.unit == "V"


def test_a_column_is_found_by_its_whole_title_too(tmp_path: Path) -> None:
    path = written(tmp_path, "Time (s),I1 (mV),Q1 (mV)\n0,1,2\n1,3,4\n")
    np.testing.assert_allclose(read_recording(path).raw, [[0.001, 0.003], [0.002, 0.004]])
    mapped = read_recording(path, channels=parse_channel_map("I1=Q1 (mV),Q1=I1"))
    np.testing.assert_allclose(mapped.raw, [[0.002, 0.004], [0.001, 0.003]])


def test_two_columns_of_one_name_keep_their_units_in_it(tmp_path: Path) -> None:
    path = written(tmp_path, "t,A (V),A (mV),B (left)\n0,1,2,3\n1,1,2,3\n")
    assert [info.name for info in list_channels(path)] == ["A (V)", "A (mV)", "B (left)"]


@pytest.mark.parametrize(
    "title", ["Time (s)", "time", "t", "T [ms]", "Zeit in s", "Relative Time (s)", "X_Value", "Timestamp", "X [us]"]
)
def test_times_are_never_taken_for_a_channel(tmp_path: Path, title: str) -> None:
    path = written(tmp_path, f"{title},a,b\n0,1,2\n1,3,4\n")
    assert [info.name for info in list_channels(path)] == ["a", "b"]
    assert guess_channel_map(list_channels(path)).channel_map == parse_channel_map("I1=a,Q1=b")


def test_times_as_text_are_no_times_and_the_rate_is_asked_for(tmp_path: Path) -> None:
    path = written(tmp_path, "Time,I1,Q1\n12:00:00.0,1,2\n12:00:00.5,3,4\n")
    with pytest.raises(FileError, match="does not tell its sample rate"):
        read_recording(path)
    assert read_recording(path, rate_hz=2.0).raw.tolist() == [[1, 3], [2, 4]]


@settings(max_examples=60, deadline=None)
@given(
    st.sampled_from([",", ";", "\t", " "]),
    st.booleans(),
    st.sampled_from(["time_s", "t", "Time (ms)", "Zeit [us]"]),
    st.lists(st.tuples(st.floats(-1e3, 1e3), st.floats(-1e3, 1e3)), min_size=2, max_size=9),
    st.booleans(),
)
def test_numbers_come_back_whatever_parts_them(
    tmp_path_factory: pytest.TempPathFactory,
    separator: str,
    comma: bool,
    time: str,
    rows: list[tuple[float, float]],
    commented: bool,
) -> None:
    per_s = {"Time (ms)": 1e3, "Zeit [us]": 1e6}.get(time, 1.0)
    lines = [separator.join(repr(value) for value in (k * 0.5 * per_s, *row)) for k, row in enumerate(rows)]
    if comma and separator != ",":
        lines = [line.replace(".", ",") for line in lines]
    header = ("# " if commented else "") + separator.join([time, "I1", "Q1"])
    path = tmp_path_factory.mktemp("csv") / "a.csv"
    path.write_text("\n".join([header, *lines]) + "\n", encoding="utf-8")
    recording = read_recording(path)
    assert recording.raw.T.tolist() == [list(row) for row in rows]
    assert recording.digitisation.sample_rate_hz == pytest.approx(2.0, rel=1e-9)


_NUMBER = st.floats(allow_nan=False, allow_infinity=False)


@settings(max_examples=60, deadline=None)
@given(
    st.lists(st.tuples(_NUMBER, _NUMBER), min_size=2, max_size=20),
    st.sampled_from(["\n", "\r\n"]),
    st.booleans(),
    st.sampled_from([1.0, 500.0, 33333.0, 200000.0, 0.25]),
)
def test_every_number_python_writes_comes_back(
    tmp_path_factory: pytest.TempPathFactory,
    rows: list[tuple[float, float]],
    line_end: str,
    mark: bool,
    rate_hz: float,
) -> None:
    lines = ["time_s,I1,Q1", *(f"{k / rate_hz!r},{i!r},{q!r}" for k, (i, q) in enumerate(rows))]
    path = tmp_path_factory.mktemp("csv") / "a.csv"
    path.write_bytes(line_end.join(lines).encode("utf-8-sig" if mark else "utf-8"))
    recording = read_recording(path)
    assert recording.raw.T.tolist() == [list(row) for row in rows]
    assert math.isclose(recording.digitisation.sample_rate_hz, rate_hz, rel_tol=1e-9)


@settings(max_examples=60, deadline=None)
@given(st.text(alphabet="time_s,IQ12;.\n\r-+e0 \t#\"'x\0ä", max_size=80))
def test_any_text_is_read_or_refused(tmp_path_factory: pytest.TempPathFactory, text: str) -> None:
    path = tmp_path_factory.mktemp("csv") / "a.csv"
    path.write_text("time_s,I1,Q1\n0,1,2\n" + text, encoding="utf-8", newline="")
    try:
        recording = read_recording(path, rate_hz=1.0)
    except FileError as error:
        assert "\n" not in str(error)  # noqa: PT017
    else:
        assert recording.raw.shape[0] == 2
        assert np.isfinite(recording.raw).all()
