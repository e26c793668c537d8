"""Files with bytes changed at random: a FileError or a right answer, nothing else (more: benchmark hostile)."""

from __future__ import annotations

import random
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from support.file_samples import (
    codes,
    read_all_channels,
    volts,
    write_csv,
    write_mat5,
    write_mat73,
    write_run,
    write_sigmf,
    write_tdms,
)
from support.run_contents import read_markers, read_run_truth, read_summary

from radargui.files.formats import list_channels
from radargui.files.reading import read_recording
from radargui.files.run_file import read_run, read_run_setup
from radargui.model.errors import FileError, SetupError
from radargui.model.recording import Recording

N_TRIES = 60


def _run(folder: Path) -> Path:
    write_run(folder / "a.h5")
    return folder / "a.h5"


def _csv(folder: Path) -> Path:
    return write_csv(folder / "a.csv", volts(2, 30))


def _mat5(folder: Path) -> Path:
    return write_mat5(folder / "a.mat", volts(2, 40), compressed=False)


def _mat5_compressed(folder: Path) -> Path:
    return write_mat5(folder / "a.mat", volts(2, 40))


def _mat73(folder: Path) -> Path:
    return write_mat73(folder / "a.mat", volts(2, 400))


def _tdms(folder: Path) -> Path:
    scaled = {"NI_Number_Of_Scales": 1, "NI_Scale[0]_Scale_Type": "Linear", "wf_increment": 1e-3}
    scaled |= {"NI_Scale[0]_Linear_Slope": 0.5, "NI_Scale[0]_Linear_Y_Intercept": 1.0}
    return write_tdms(folder / "a.tdms", codes(2, 60), ["I1", "Q1"], scaled)


def _sigmf(folder: Path) -> Path:
    captures = [{"core:sample_start": 0, "core:global_index": 0}, {"core:sample_start": 9, "core:global_index": 12}]
    return write_sigmf(folder / "a", codes(4, 50).T.astype("<i2"), "ci16_le", 2, captures=captures)


def damaged(content: bytes, chance: random.Random) -> bytes:
    data = bytearray(content)
    if chance.random() < 0.1:
        return bytes(data[: chance.randrange(len(data))])
    reach = min(len(data), chance.choice([64, 512, 4096, len(data)]))
    for _ in range(chance.choice([1, 1, 2, 8])):
        data[chance.randrange(reach)] = chance.choice([0, 1, 127, 128, 255, chance.randrange(256)])
    if chance.random() < 0.15:
        place = chance.randrange(reach)
        data[place : place + 4] = chance.choice([b"\xff\xff\xff\x7f", b"\xff\xff\xff\xff", b"\0\0\0\x80"])
    return bytes(data)


def _sane(recording: Recording) -> None:
    assert recording.raw.ndim == 2
    assert recording.raw.shape[0] == recording.digitisation.n_channels
    assert recording.n_samples > 0
    assert np.isfinite(recording.volts()).all()
    assert recording.digitisation.sample_rate_hz > 0
    assert recording.time_s().shape == (recording.n_samples,)


@pytest.mark.filterwarnings("default")
@pytest.mark.parametrize("make", [_csv, _mat5, _mat5_compressed, _mat73, _tdms, _sigmf])
def test_a_damaged_file_is_refused_or_read(tmp_path: Path, make: Callable[[Path], Path]) -> None:
    path = make(tmp_path)
    _sane(read_recording(path))
    content = path.read_bytes()
    refused = 0
    for seed in range(N_TRIES):
        path.write_bytes(damaged(content, random.Random(seed)))
        try:
            names = [info.name for info in list_channels(path)]
            _sane(read_all_channels(path) if len(names) < 3 else read_recording(path))
        except FileError as error:
            refused += 1
            assert "\n" not in str(error)  # noqa: PT017
    assert refused > N_TRIES // 10


@pytest.mark.filterwarnings("default")
def test_a_damaged_run_is_refused_or_read_as_it_was(tmp_path: Path) -> None:
    path = _run(tmp_path)
    whole = read_run(path)
    content = path.read_bytes()
    refused = 0
    for seed in range(2 * N_TRIES):
        path.write_bytes(damaged(content, random.Random(seed)))
        for read in (read_run_setup, read_run_truth, read_markers, read_summary):
            try:
                read(path)
            except (FileError, SetupError):
                continue
        try:
            found = read_run(path)
        except FileError as error:
            refused += 1
            assert "\n" not in str(error)  # noqa: PT017
            continue
        n_samples = found.n_samples
        np.testing.assert_array_equal(found.raw, whole.raw[:, :n_samples])
        assert n_samples in (1500, 1800)
        assert found.digitisation.channel_names == whole.digitisation.channel_names
        assert found.digitisation.sample_rate_hz == whole.digitisation.sample_rate_hz
    assert refused > N_TRIES // 6
