"""The channel map: what --channels may say."""

from __future__ import annotations

import string
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, strategies as st
from support.file_samples import codes, volts, write_csv, write_mat5, write_run, write_tdms

from radargui.files.reading import ChannelMap, ImportInput, parse_channel_map, read_mapped, read_recording
from radargui.model.errors import FileError, UsageError
from radargui.model.recording import iq_names


def parts(found: ChannelMap) -> list[tuple[str, str | None, str]]:
    return [(entry.target, None if entry.path is None else str(entry.path), entry.variable) for entry in found.entries]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("I1=x,Q1=y", [("I1", None, "x"), ("Q1", None, "y")]),
        (" q1 = y , i1 = x ", [("I1", None, "x"), ("Q1", None, "y")]),
        ("I1=a.mat:src1.Data,Q1=b.mat:src1.Data", [("I1", "a.mat", "src1.Data"), ("Q1", "b.mat", "src1.Data")]),
        (r"I1=C:\d\a.mat:s.D,Q1=C:\d\b.mat:s.D", [("I1", r"C:\d\a.mat", "s.D"), ("Q1", r"C:\d\b.mat", "s.D")]),
        ("I1=D:/a.TDMS:g/V: 0,Q1=D:/a.TDMS:g/V: 1", [("I1", "D:/a.TDMS", "g/V: 0"), ("Q1", "D:/a.TDMS", "g/V: 1")]),
        ("I1=a,b.csv:x,Q1=a,b.csv:y", [("I1", "a,b.csv", "x"), ("Q1", "a,b.csv", "y")]),
        ("I1=Volt: 0,Q1=Volt: 1", [("I1", None, "Volt: 0"), ("Q1", None, "Volt: 1")]),
        ("I1=First  Channel,Q1=Second Chan", [("I1", None, "First  Channel"), ("Q1", None, "Second Chan")]),
    ],
)
def test_a_map_is_understood(text: str, expected: list[tuple[str, str | None, str]]) -> None:
    wanted = [(target, None if path is None else str(Path(path)), name) for target, path, name in expected]
    assert parts(parse_channel_map(text)) == wanted


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "is not a channel map"),
        ("x", "is not a channel map"),
        ("x=I1", "is not a channel map"),
        ("I1=x", "lacks Q1"),
        ("I1=x,Q1=y,I2=z", "lacks Q2"),
        ("I2=x,Q2=y", "lacks I1, Q1"),
        ("I0=x,Q0=y", "lacks"),
        ("I1=x,Q1=y,I0=z,Q0=u", "lacks"),
        ("I1=x,Q1=y,I1=z", "names I1 twice"),
        ("I1=x,Q1=x", "same column"),
        ("I1=,Q1=y", "names no column"),
        ("I1=a.mat:x,Q1=y", "a path for some channels"),
        ("I1=a.mat,Q1=b.mat", "names a file, but nothing in it"),
        ("I1=a.mat:,Q1=b.mat:", "names no column"),
        ("I5=x,Q5=y", "names receiver 5; there can be 1 to 4"),
        ("I99999999999999999999=x,Q1=y", "there can be 1 to 4"),
    ],
)
def test_a_map_that_means_nothing_is_wrong_usage(text: str, said: str) -> None:
    with pytest.raises(UsageError, match=said):
        parse_channel_map(text)


_LETTERS = string.ascii_letters + string.digits + " ._-/"
_SUFFIXED = (".csv", ".mat", ".tdms", ".h5", ".hdf5", ".sigmf", ".sigmf-meta", ".sigmf-data")
_WORD = (
    st.text(alphabet=_LETTERS, min_size=1, max_size=12)
    .map(str.strip)
    .filter(lambda word: word and not word.lower().endswith(_SUFFIXED))
)


@given(
    st.integers(1, 4).flatmap(
        lambda n: st.tuples(
            st.lists(_WORD, min_size=2 * n, max_size=2 * n, unique=True),
            st.permutations(range(2 * n)),
            st.sampled_from(["", "C:\\data\\a.mat", "/home/a, b/x.csv", "rel/y.tdms"]),
        )
    )
)
def test_what_is_written_down_is_parsed_back(case: tuple[list[str], list[int], str]) -> None:
    words, order, path = case
    targets = iq_names(len(words) // 2)
    text = ",".join(f"{targets[k]}={path + ':' if path else ''}{words[k]}" for k in order)
    found = parse_channel_map(text)
    assert [entry.variable for entry in found.entries] == words
    assert {entry.path for entry in found.entries} == {Path(path) if path else None}


@given(st.text(alphabet="IQ12=:,.\\/ mat", max_size=40))
def test_any_text_is_a_map_or_wrong_usage(text: str) -> None:
    try:
        found = parse_channel_map(text)
    except UsageError:
        return
    assert [entry.target for entry in found.entries] == list(iq_names(len(found.entries) // 2))


def test_two_files_form_one_recording_in_the_order_of_the_map(tmp_path: Path) -> None:
    first, second = volts(2, 300, seed=1), volts(2, 300, seed=2)
    write_mat5(tmp_path / "i.mat", first)
    write_mat5(tmp_path / "q.mat", second)
    text = f"I1={tmp_path}/i.mat:I1,Q1={tmp_path}/q.mat:I1,I2={tmp_path}/i.mat:Q1,Q2={tmp_path}/q.mat:Q1"
    recording = read_mapped(parse_channel_map(text), name="both")
    np.testing.assert_array_equal(recording.raw, [first[0], second[0], first[1], second[1]])
    assert recording.digitisation.channel_names == ("I1", "Q1", "I2", "Q2")
    assert (recording.name, recording.digitisation.sample_rate_hz) == ("both", 2000.0)


def test_a_map_that_names_files_takes_no_other_and_its_recording_the_stem_of_the_first(tmp_path: Path) -> None:
    write_mat5(tmp_path / "a.mat", volts(2, 10))
    write_mat5(tmp_path / "b.mat", volts(2, 10))
    one = parse_channel_map(f"I1={tmp_path}/a.mat:I1,Q1={tmp_path}/b.mat:Q1")
    assert ImportInput(one.paths, one).read().name == "a"
    with pytest.raises(UsageError, match="names files of its own"):
        read_recording(tmp_path / "b.mat", channels=one)


def test_files_that_do_not_fit_together_are_refused(tmp_path: Path) -> None:
    write_csv(tmp_path / "a.csv", volts(2, 10), rate_hz=100.0)
    write_csv(tmp_path / "b.csv", volts(2, 11), rate_hz=100.0)
    write_csv(tmp_path / "c.csv", volts(2, 10), rate_hz=100.5)
    write_mat5(tmp_path / "d.mat", volts(2, 10))

    def joined(other: str) -> None:
        text = f"I1={tmp_path}/a.csv:I1,Q1={tmp_path}/{other}:Q1"
        read_mapped(parse_channel_map(text), name="x")

    with pytest.raises(FileError, match=r"differ in length \(I1: 10, Q1: 11 samples\)"):
        joined("b.csv")
    joined("c.csv")
    with pytest.raises(FileError, match="its times make 100 Hz, the header says 2000 Hz"):
        joined("d.mat")


def test_columns_of_a_file_are_mapped_by_name(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("time_s,a: 1,b\n0,1,2\n1,3,4\n", encoding="utf-8")
    recording = read_recording(path, channels=parse_channel_map("I1=b,Q1=a: 1"))
    assert recording.raw.tolist() == [[2, 4], [1, 3]]
    with pytest.raises(FileError, match="holds no c; it holds a: 1, b"):
        read_recording(path, channels=parse_channel_map("I1=b,Q1=c"))


def test_runs_of_blanks_in_a_name_count_as_one(tmp_path: Path) -> None:
    path = write_tdms(tmp_path / "a.tdms", volts(2, 9), ["First  Channel", "Second"], {"wf_increment": 0.01})
    recording = read_recording(path, channels=parse_channel_map("I1=First Channel,Q1=Second"))
    np.testing.assert_array_equal(recording.raw, volts(2, 9))


def test_channels_of_a_run_are_mapped_with_their_skew_and_scaling(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    samples = write_run(path)
    recording = read_recording(path, channels=parse_channel_map("I1=I2,Q1=Q2"))
    np.testing.assert_array_equal(recording.raw, samples[2:4])
    assert recording.digitisation.channel_skew_s == 5e-6
    assert recording.digitisation.scaling == ((0.002, 1.5e-4), (0.003, 1.5e-4))
    assert recording.gaps[0].count == 10
    every_second = read_recording(path, channels=parse_channel_map("I1=I1,Q1=I2"))
    assert every_second.digitisation.channel_skew_s == pytest.approx(1e-5)
    with pytest.raises(FileError, match="sampled one after another"):
        read_recording(path, channels=parse_channel_map("I1=Q1,Q1=I1"))


def test_codes_and_volts_together_become_volts(tmp_path: Path) -> None:
    scaled = {"wf_increment": 0.01, "NI_Number_Of_Scales": 1, "NI_Scale[0]_Scale_Type": "Linear"}
    scaled |= {"NI_Scale[0]_Linear_Slope": 0.5, "NI_Scale[0]_Linear_Y_Intercept": 1.0}
    write_tdms(tmp_path / "a.tdms", codes(1, 50), ["x"], scaled)
    write_tdms(tmp_path / "b.tdms", volts(1, 50), ["y"], {"wf_increment": 0.01})
    text = f"I1={tmp_path}/a.tdms:x,Q1={tmp_path}/b.tdms:y"
    recording = read_mapped(parse_channel_map(text), name="x")
    assert recording.digitisation.scaling is None
    np.testing.assert_allclose(recording.raw[0], 1.0 + 0.5 * codes(1, 50)[0])
