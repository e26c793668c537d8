"""Recordings of other programs become a session whose samples are as they were."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path

import h5py
import numpy as np
import pytest
from support.file_samples import codes, default_setup, volts, write_csv, write_mat5, write_run, write_sigmf, write_tdms
from support.small_setups import PLATE

from radargui.files.formats import EXPORT_FORMATS, export_run, own_setup_of
from radargui.files.raw_file import parse_raw_layout
from radargui.files.reading import ImportInput, parse_channel_map, read_recording
from radargui.files.run_card import read_origin
from radargui.files.run_file import read_run, read_run_setup
from radargui.model.errors import FileError, SessionError
from radargui.model.setup import parse_setup
from radargui.session.session import Session
from radargui.session.transfer import SessionImport

NOW = datetime(2026, 11, 20, 15, 4, 5, tzinfo=UTC)
SCALED = {
    "wf_increment": 1e-3,
    "NI_Number_Of_Scales": 1,
    "NI_Scale[0]_Scale_Type": "Linear",
    "NI_Scale[0]_Linear_Slope": 1e-4,
    "NI_Scale[0]_Linear_Y_Intercept": 0.0,
}


@pytest.fixture
def work(tmp_path: Path) -> SessionImport:
    """An import with the setup of one receiver."""
    return SessionImport(tmp_path / "sessions", parse_setup(PLATE), now=NOW, operator="Eve", notes="from the scope")


def test_files_of_every_kind_become_runs_of_one_session_with_their_origin(work: SessionImport, tmp_path: Path) -> None:
    pair = parse_channel_map("I1=b,Q1=a")
    inputs = [
        ImportInput((write_csv(tmp_path / "a.csv", volts(2, 50)),)),
        ImportInput((write_tdms(tmp_path / "b.tdms", codes(2, 60), ["a", "b"], SCALED),), pair),
        ImportInput((write_mat5(tmp_path / "c.mat", volts(2, 40)),), rate_hz=500.0),
        ImportInput((write_sigmf(tmp_path / "d", codes(2, 70).T, "ci16_le", 1),)),
    ]
    shares: list[float] = []
    runs = list(work.carry_out(inputs, shares.append))
    assert [run.error for run in runs] == [None] * 4
    assert work.session is not None
    session = Session.open(work.session.path)
    assert session.run_paths() == tuple(run.path for run in runs)
    assert (session.info.operator, session.info.notes) == ("Eve", "from the scope")
    for run in runs:
        assert run.path is not None
        np.testing.assert_array_equal(read_run(run.path).raw, run.source.read().raw)
        assert read_run_setup(run.path) == parse_setup(PLATE)
    assert read_run(session.run_paths()[1]).raw.dtype == np.int16
    assert read_run(session.run_paths()[2]).digitisation.sample_rate_hz == 500.0
    with h5py.File(session.run_paths()[1]) as file:
        assert file.attrs["source"].decode() == "import"
        assert file.attrs["imported_from"].decode() == "b.tdms"
        assert file.attrs["imported_format"].decode() == "TDMS"
        assert file.attrs["imported_channels"].decode() == "I1=b,Q1=a"
    assert shares == [0.25, 0.5, 0.75, 1.0]


@pytest.mark.parametrize("name", list(EXPORT_FORMATS))
def test_an_exported_run_that_is_imported_is_the_run_again(tmp_path: Path, name: str) -> None:
    write_run(tmp_path / "run-0001.h5")
    path = export_run(tmp_path / "run-0001.h5", EXPORT_FORMATS[name], tmp_path / "out")[0]
    setup = own_setup_of(path)
    assert setup == default_setup()
    work = SessionImport(tmp_path / "sessions", setup, now=NOW)
    (run,) = work.carry_out([ImportInput((path,))])
    assert run.path is not None
    before, after = read_run(tmp_path / "run-0001.h5"), read_run(run.path)
    assert (after.gaps, after.started_at) == (before.gaps, before.started_at)
    np.testing.assert_allclose(after.volts(), before.volts(), rtol=0, atol=1e-7)
    np.testing.assert_array_equal(after.index(), before.index())


def test_channels_of_several_files_form_one_run(work: SessionImport, tmp_path: Path) -> None:
    first, second = write_csv(tmp_path / "a.csv", volts(2, 50)), write_csv(tmp_path / "b.csv", volts(2, 50, seed=1))
    pair = parse_channel_map(f"I1={first}:I1,Q1={second}:Q1")
    (run,) = work.carry_out([ImportInput(pair.paths, pair)])
    assert run.path is not None
    np.testing.assert_array_equal(read_run(run.path).raw, [volts(2, 50)[0], volts(2, 50, seed=1)[1]])


def test_one_bad_file_is_told_and_the_others_are_imported(work: SessionImport, tmp_path: Path) -> None:
    (tmp_path / "bad.csv").write_text("I1,Q1\n1,x\n", encoding="utf-8")
    good = write_csv(tmp_path / "good.csv", volts(2, 20))
    three = tmp_path / "three.h5"
    write_run(three)
    runs = list(work.carry_out([ImportInput((tmp_path / "bad.csv",)), ImportInput((three,)), ImportInput((good,))]))
    assert [run.path is None for run in runs] == [True, True, False]
    assert "column Q1 is not a number" in str(runs[0].error)
    assert "gives 3 IQ pairs, the setup has 1 receivers" in str(runs[1].error)


def test_no_session_appears_where_nothing_can_be_read(work: SessionImport, tmp_path: Path) -> None:
    (run,) = work.carry_out([ImportInput((tmp_path / "absent.csv",))])
    assert isinstance(run.error, FileError)
    assert work.session is None
    assert not (tmp_path / "sessions").exists()


def test_a_place_that_cannot_be_written_is_told(work: SessionImport, tmp_path: Path) -> None:
    (tmp_path / "sessions").write_text("a file", encoding="utf-8")
    with pytest.raises(SessionError):
        list(work.carry_out([ImportInput((write_csv(tmp_path / "a.csv", volts(2, 20)),))]))


def test_times_of_a_file_become_rate_and_gaps(work: SessionImport, tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    index = [*range(40), *range(50, 90)]
    rows = "".join(f"{place / 250:.4f},{place},{-place}\n" for place in index)
    path.write_text("time_s,I1,Q1\n" + rows, encoding="utf-8")
    (run,) = work.carry_out([ImportInput((path,))])
    assert run.path is not None
    after = read_run(run.path)
    assert after.digitisation.sample_rate_hz == 250.0
    np.testing.assert_array_equal(after.index(), index)
    np.testing.assert_array_equal(after.raw, read_recording(path).raw)


def test_an_imported_run_knows_its_file_its_program_and_its_layout(work: SessionImport, tmp_path: Path) -> None:
    mat, raw = write_mat5(tmp_path / "scope.mat", volts(2, 40)), tmp_path / "car.bin"
    content = bytearray(mat.read_bytes())
    content[:116] = b"MATLAB 5.0 MAT-file, Platform: PCWIN, Created on 2017-10-05 10:36:35 by Scope 3".ljust(116)
    mat.write_bytes(content)
    raw.write_bytes(codes(2, 60).T.tobytes())
    sigmf = write_sigmf(tmp_path / "d", codes(2, 70).T, "ci16_le", 1, **{"core:recorder": "GNU Radio"})
    layout = parse_raw_layout("dtype=i2le,channels=2,rate=100,scale=1e-4")
    inputs = [
        ImportInput((mat,), rate_hz=500.0),
        ImportInput((raw,), parse_channel_map("I1=0,Q1=1"), raw=layout),
        ImportInput((sigmf,)),
        ImportInput((write_csv(tmp_path / "a.csv", volts(2, 50)),)),
    ]
    runs = [run.path for run in work.carry_out(inputs)]
    assert [read_origin(path) for path in runs if path] == [
        "scope.mat (MATLAB), written by Scope 3",
        "car.bin (plain binary: dtype=i2le,channels=2,rate=100.0,scale=0.0001)",
        "d.sigmf-meta (SigMF), written by GNU Radio",
        "a.csv (CSV)",
    ]
    assert [read_run(path).digitisation.channel_skew_s for path in runs if path] == [None] * 4
    np.testing.assert_array_equal(read_run(runs[1]).raw if runs[1] else None, codes(2, 60))
