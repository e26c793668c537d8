"""The factory makes the source that was asked for and loads NI's client only for NI."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from support.simulated_recording import simulate_recording
from support.simulated_setup import simulated_setup

from radargui.files import run_writer
from radargui.model.errors import FileError, SourceError
from radargui.model.recording import Block
from radargui.sources.contract import ReplaySource
from radargui.sources.factory import make_source
from radargui.sources.simulated.model import SimulatedSource


def test_simulated_gives_the_simulated_source_of_that_run() -> None:
    setup = simulated_setup(scene="rest", rest_s=0.1, settle_s=0.0)
    source = make_source("simulated", setup, run=4, realtime=False)
    assert isinstance(source, SimulatedSource)
    source.open()
    source.start()
    block = source.read()
    assert block is not None
    np.testing.assert_array_equal(block.samples, simulate_recording(setup, run=4)[0].raw[:, : block.count])


def test_replay_gives_the_samples_of_the_file(tmp_path: Path) -> None:
    setup = simulated_setup(scene="rest", rest_s=0.1, settle_s=0.0)
    recording, _ = simulate_recording(setup)
    path = tmp_path / "run-0001.h5"
    with run_writer.RunWriter(
        path, recording.digitisation, started_at="2026-01-01T00:00:00+00:00", trigger_index=None, setup_toml=""
    ) as writer:
        writer.write(Block(recording.raw, 0))
    source = make_source("replay", setup, realtime=False, file=path)
    assert isinstance(source, ReplaySource)
    source.open()
    source.start()
    block = source.read()
    assert block is not None
    np.testing.assert_array_equal(block.samples, recording.raw[:, : block.count])
    with pytest.raises(SourceError, match="3 IQ pairs, the setup has 1 receiver"):
        make_source("replay", simulated_setup(n_receivers=1), file=path)


def test_replay_needs_a_file_that_is_there(tmp_path: Path) -> None:
    with pytest.raises(SourceError, match="No file"):
        make_source("replay", simulated_setup())
    with pytest.raises(FileError):
        make_source("replay", simulated_setup(), file=tmp_path / "missing.h5")


def test_an_unknown_kind_is_refused() -> None:
    with pytest.raises(SourceError, match="no source"):
        make_source("sonar", simulated_setup())  # type: ignore[arg-type]


def test_simulation_and_replay_load_neither_ni_nor_qt() -> None:
    code = (
        "import sys; import radargui.sources.factory, radargui.sources.simulated, radargui.sources.contract; "
        "sys.exit(any(name in sys.modules for name in ('nidaqmx', 'grpc', 'PySide6', 'h5py')))"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
