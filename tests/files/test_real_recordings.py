"""The real recordings of other people open with the right channels, rate and units."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.file_samples import read_all_channels

from radargui.files.formats import list_channels
from radargui.files.reading import parse_channel_map, read_mapped, read_recording
from radargui.model.errors import FileError


@pytest.mark.parametrize(
    ("stem", "rate_hz", "count", "offset_v"),
    [("TB2_PRG_9", 500.0, 10_000, (0.085, -0.486)), ("TB2_ruido", 5000.0, 20_000, None)],
)
def test_the_plate_radar_is_one_receiver_of_two_files(
    test_data: Path, stem: str, rate_hz: float, count: int, offset_v: tuple[float, float] | None
) -> None:
    folder = test_data / "radar-9ghz"
    text = f"I1={folder / f'{stem}_I_C.mat'}:src1.Data,Q1={folder / f'{stem}_Q_C.mat'}:src1.Data"
    recording = read_mapped(parse_channel_map(text), name="plate")
    assert recording.name == "plate"
    assert recording.raw.shape == (2, count)
    assert recording.digitisation.sample_rate_hz == rate_hz
    assert recording.digitisation.unit == "V"
    assert recording.digitisation.channel_names == ("I1", "Q1")
    if offset_v is not None:
        middle = (recording.raw.max(axis=1) + recording.raw.min(axis=1)) / 2
        np.testing.assert_allclose(middle, offset_v, atol=0.05)


def test_one_file_of_the_pair_alone_is_refused_with_what_it_holds(test_data: Path) -> None:
    with pytest.raises(FileError, match=r"holds no channels named I1, Q1, ...; it holds src1\.Data"):
        read_recording(test_data / "radar-9ghz" / "TB2_PRG_9_I_C.mat")


def test_the_daq_file_keeps_its_codes_scaling_rate_and_names(test_data: Path) -> None:
    path = test_data / "tdms" / "raw1.tdms"
    recording = read_all_channels(path)
    assert recording.raw.dtype == np.int16
    assert recording.raw.shape == (7, 2000)
    assert recording.raw[:, 0].tolist() == [-603, 3376, 5686, 8186, 10575, 14210, 16525]
    assert recording.digitisation.channel_names[0] == "First  Channel"
    assert recording.digitisation.scaling is not None
    np.testing.assert_allclose(recording.digitisation.scaling, [[0.0, 0.0003051850947599719]] * 7)
    assert recording.digitisation.sample_rate_hz == 50_000.0
    assert recording.digitisation.unit == "V"
    assert recording.started_at.startswith("2016-12-15T22:35:21")


def test_the_daq_file_is_mapped_with_the_names_that_its_refusal_shows(test_data: Path) -> None:
    path = test_data / "tdms" / "raw1.tdms"
    with pytest.raises(FileError) as refused:
        read_recording(path)
    shown = str(refused.value).split('--channels "')[1].split('"')[0]
    recording = read_recording(path, channels=parse_channel_map(shown))
    assert recording.raw[:, 0].tolist() == [-603, 3376]


def test_the_big_endian_file_has_its_interval(test_data: Path) -> None:
    path = test_data / "tdms" / "big_endian.tdms"
    assert [(info.name, info.count, info.sample_rate_hz) for info in list_channels(path)] == [
        ("Amplitude sweep", 3500, 1000.0),
        ("Phase sweep", 3500, 1000.0),
    ]
    recording = read_recording(path, channels=parse_channel_map("I1=Phase sweep,Q1=Amplitude sweep"))
    assert recording.digitisation.sample_rate_hz == 1000.0
    np.testing.assert_allclose(recording.raw[0, :3], [0.0, 0.06341758, 0.12657988], atol=1e-8)


def test_the_logo_is_drawn_upright_so_the_channels_are_in_order(test_data: Path) -> None:
    recording = read_recording(test_data / "sigmf" / "sigmf_logo.sigmf-meta")
    assert recording.raw.dtype == np.int16
    assert recording.raw.shape == (2, 288_000)
    assert recording.digitisation.sample_rate_hz == 48_000.0
    assert recording.started_at == "2021-06-18T23:17:51.163959+00:00"
    x, y = recording.volts()[:, 6_000:48_000]
    dot_of_the_i = (np.abs(x) < 0.03) & (y > 0.3)
    mirrored = (np.abs(y) < 0.03) & (x > 0.3)
    below_the_f = (x > 0.2) & (y < -0.2)
    foot_of_the_m = (x < -0.2) & (y < -0.2)
    assert dot_of_the_i.sum() > 100
    assert mirrored.sum() == 0
    assert foot_of_the_m.sum() > 10 * below_the_f.sum()


def test_the_raw_dumps_are_not_read_without_their_layout(test_data: Path) -> None:
    with pytest.raises(FileError, match=r"files that end in \.bin are not read.*--raw"):
        read_recording(test_data / "radar-24ghz" / "fram_fort_1.bin")
