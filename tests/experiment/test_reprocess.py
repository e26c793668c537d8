"""A stored run is processed again, with its own or another setup."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.run_contents import read_summary
from support.simulated_recording import simulate_recording
from support.simulated_setup import simulated_setup

from radargui.experiment.reprocess import process_run
from radargui.files.run_file import read_run
from radargui.files.run_writer import RunWriter
from radargui.model.errors import FileError, UsageError
from radargui.model.recording import Block
from radargui.model.setup import Setup, dump_setup

SETUP = simulated_setup(mismatch=0.0, snr_db=50.0, restitution=0.5, settle_s=0.2)


def stored(folder: Path, setup_toml: str) -> Path:
    recording, _ = simulate_recording(SETUP)
    path = folder / "run-0001.h5"
    with RunWriter(path, recording.digitisation, started_at="", trigger_index=None, setup_toml=setup_toml) as writer:
        writer.write(Block(recording.raw, 0))
    return path


def test_a_run_is_processed_with_its_own_setup_and_the_results_are_kept(tmp_path: Path) -> None:
    path = stored(tmp_path, dump_setup(SETUP))
    before = read_run(path).raw
    result = process_run(path)
    assert result.status == "ok"
    summary = read_summary(path)
    assert summary is not None
    assert summary["e"] == pytest.approx(0.5, rel=0.05)
    assert np.array_equal(read_run(path).raw, before)


def test_another_setup_replaces_the_results(tmp_path: Path) -> None:
    path = stored(tmp_path, dump_setup(SETUP))
    process_run(path)
    plane = Setup.model_validate(
        {**SETUP.model_dump(by_alias=True), "processing": {"correction": "none", "geometry": "plane"}}
    )
    shares: list[float] = []
    process_run(path, plane, progress=shares.append)
    summary = read_summary(path)
    assert summary is not None
    assert (summary["correction"], summary["geometry"]) == ("none", "plane")
    assert shares == sorted(shares)


def test_a_run_without_setup_needs_one(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="holds no setup"):
        process_run(stored(tmp_path, ""))


def test_a_file_that_is_no_run_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "run-0001.h5"
    path.write_bytes(b"nothing")
    with pytest.raises(FileError):
        process_run(path)
