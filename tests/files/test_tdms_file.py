"""TDMS files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from nptdms import ChannelObject, TdmsFile, TdmsWriter
from support.file_samples import codes, volts, write_tdms

from radargui.files.formats import list_channels
from radargui.files.reading import parse_channel_map, read_recording
from radargui.files.tdms_file import code_polynomial
from radargui.model.errors import FileError

LINEAR = {
    "NI_Scaling_Status": "unscaled",
    "NI_Number_Of_Scales": 2,
    "NI_Scale[1]_Scale_Type": "Linear",
    "NI_Scale[1]_Linear_Slope": 3e-4,
    "NI_Scale[1]_Linear_Y_Intercept": 0.01,
}
POLYNOMIAL = {
    "NI_Number_Of_Scales": 2,
    "NI_Scale[0]_Scale_Type": "Linear",
    "NI_Scale[0]_Linear_Slope": 2.0,
    "NI_Scale[0]_Linear_Y_Intercept": 1.0,
    "NI_Scale[1]_Scale_Type": "Polynomial",
    "NI_Scale[1]_Polynomial_Coefficients_Size": 3,
    "NI_Scale[1]_Polynomial_Coefficients[0]": 0.5,
    "NI_Scale[1]_Polynomial_Coefficients[1]": 1e-4,
    "NI_Scale[1]_Polynomial_Coefficients[2]": 1e-9,
    "NI_Scale[1]_Polynomial_Input_Source": 0,
}
TIMED = {"wf_increment": 1 / 2500, "unit_string": "Volts", "wf_start_time": np.datetime64("2026-11-20T14:00:00")}


def test_values_rate_unit_and_date_come_back(tmp_path: Path) -> None:
    path = write_tdms(tmp_path / "a.tdms", volts(2, 100), ["I1", "Q1"], TIMED)
    recording = read_recording(path)
    np.testing.assert_array_equal(recording.raw, volts(2, 100))
    assert recording.digitisation.sample_rate_hz == 2500.0
    assert recording.digitisation.unit == "V"
    assert recording.started_at == "2026-11-20T14:00:00.000000+00:00"


@pytest.mark.parametrize(
    ("properties", "coefficients"),
    [
        (LINEAR, (0.01, 3e-4)),
        (POLYNOMIAL, (0.5 + 1e-4 + 1e-9, 2e-4 + 4e-9, 4e-9)),
        ({}, (0.0, 1.0)),
    ],
    ids=["linear", "polynomial of linear", "none"],
)
def test_codes_stay_codes_and_give_the_volts_of_the_library(
    tmp_path: Path, properties: dict[str, object], coefficients: tuple[float, ...]
) -> None:
    path = write_tdms(tmp_path / "a.tdms", codes(2, 5000), ["I1", "Q1"], {**TIMED, **properties})
    recording = read_recording(path)
    assert recording.raw.dtype == np.int16
    np.testing.assert_array_equal(recording.raw, codes(2, 5000))
    assert recording.digitisation.scaling is not None
    np.testing.assert_allclose(recording.digitisation.scaling[1], coefficients, rtol=1e-12)
    with TdmsFile.open(path) as file:
        np.testing.assert_allclose(recording.volts()[1], file["group"]["Q1"][:], rtol=1e-12, atol=1e-12)


def test_a_scaling_that_is_no_polynomial_gives_values(tmp_path: Path) -> None:
    table = {
        "NI_Number_Of_Scales": 1,
        "NI_Scale[0]_Scale_Type": "Table",
        "NI_Scale[0]_Table_Scaled_Values_Size": 2,
        "NI_Scale[0]_Table_Scaled_Values[0]": -40000.0,
        "NI_Scale[0]_Table_Scaled_Values[1]": 40000.0,
        "NI_Scale[0]_Table_Pre_Scaled_Values_Size": 2,
        "NI_Scale[0]_Table_Pre_Scaled_Values[0]": -10.0,
        "NI_Scale[0]_Table_Pre_Scaled_Values[1]": 10.0,
    }
    path = write_tdms(tmp_path / "a.tdms", codes(2, 50), ["I1", "Q1"], {**TIMED, **table})
    recording = read_recording(path)
    assert recording.digitisation.scaling is None
    with TdmsFile.open(path) as file:
        np.testing.assert_allclose(recording.raw[0], file["group"]["I1"][:])


@pytest.mark.parametrize(
    "change",
    [
        {"NI_Number_Of_Scales": 10**9},
        {"NI_Number_Of_Scales": "two"},
        {"NI_Scale[1]_Linear_Input_Source": 7},
        {"NI_Scale[1]_Scale_Type": "Liear"},
        {"NI_Scale[1]_Linear_Slope": np.inf},
        {"NI_Scale[1]_Scale_Type": "Thermocouple"},
    ],
)
def test_a_damaged_scaling_is_no_polynomial(change: dict[str, object]) -> None:
    assert code_polynomial({**LINEAR, **change}) is None
    assert code_polynomial(LINEAR) == (0.01, 3e-4)


def test_a_scale_of_an_unknown_kind_is_refused_for_codes_are_no_volts(tmp_path: Path) -> None:
    path = write_tdms(tmp_path / "a.tdms", codes(2, 50), ["I1", "Q1"], {**LINEAR, "NI_Scale[1]_Scale_Type": "Liear"})
    with pytest.raises(FileError, match="the scaling of its channel I1 is damaged"):
        read_recording(path, rate_hz=1.0)


def test_channels_of_one_name_in_two_groups_are_told_apart(tmp_path: Path) -> None:
    path = tmp_path / "a.tdms"
    rows = volts(3, 20)
    with TdmsWriter(path) as writer:
        writer.write_segment(
            [
                ChannelObject("one", "x", rows[0], TIMED),
                ChannelObject("two", "x", rows[1], TIMED),
                ChannelObject("two", "y", rows[2], TIMED),
                ChannelObject("two", "words", ["a", "b"]),
            ]
        )
    assert [info.name for info in list_channels(path)] == ["one/x", "two/x", "y"]
    recording = read_recording(path, channels=parse_channel_map("I1=two/x,Q1=two/y"))
    np.testing.assert_array_equal(recording.raw, rows[1:])


def test_without_an_interval_the_rate_is_asked_for_and_one_given_goes_first(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    path = write_tdms(tmp_path / "a.tdms", volts(2, 20), ["I1", "Q1"], {})
    with pytest.raises(FileError, match=r"does not tell its sample rate\. Give it with --rate-hz"):
        read_recording(path)
    assert read_recording(path, rate_hz=5e4).digitisation.sample_rate_hz == 5e4
    assert not caplog.records
    timed = write_tdms(tmp_path / "b.tdms", volts(2, 20), ["I1", "Q1"], {"wf_increment": 1.0})
    assert read_recording(timed, rate_hz=5e4).digitisation.sample_rate_hz == 5e4
    assert "says 1 Hz; 50000 Hz is used" in caplog.text


def test_a_file_cut_off_is_refused_and_an_index_beside_it_not_believed(tmp_path: Path) -> None:
    path = tmp_path / "a.tdms"
    with TdmsWriter(str(path), index_file=True) as writer:
        writer.write_segment([ChannelObject("g", name, volts(1, 1000)[0], TIMED) for name in ("I1", "Q1")])
    assert read_recording(path).n_samples == 1000
    content = path.read_bytes()
    path.write_bytes(content[:-4000])
    with pytest.raises(FileError, match="is cut off"):
        read_recording(path)
    path.write_bytes(b"something else" + content)
    with pytest.raises(FileError, match="is no TDMS file"):
        read_recording(path)


def test_the_start_is_taken_from_the_channel_that_tells_it(tmp_path: Path) -> None:
    exported = {
        "wf_start_time": np.datetime64("1904-01-01"),
        "NI_ExpStartTimeStamp": np.datetime64("2018-11-13T23:04:49"),
    }
    path = write_tdms(tmp_path / "a.tdms", volts(2, 9), ["I1", "Q1"], {"wf_increment": 0.1, **exported})
    assert read_recording(path).started_at == "2018-11-13T23:04:49.000000+00:00"
