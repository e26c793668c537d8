"""`radargui record --source ni` and `devices` against a stand-in device server, through the real nidaqmx client."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
import pytest
from support.changed import changed
from support.command_line import Command
from support.ni_server import RealTime, serve

from radargui.files.run_file import read_run, read_summary
from radargui.model.resources import default_setup_path
from radargui.model.setup import Setup
from radargui.model.setup_file import read_setup, write_setup
from radargui.sources.simulated.recording import simulate_recording


@pytest.fixture
def drop() -> Setup:
    """A short drop at the rate that fills the DAQPad-6015: its server divides 20 MHz, 33333.33 Hz is exact."""
    return changed(
        read_setup(default_setup_path()),
        daq={"rate_hz": 20e6 / 600},
        simulation={"restitution": 0.5, "rest_s": 0.4, "settle_s": 0.5},
        recording={"pretrigger_s": 0.2},
    )


def test_six_channels_of_the_device_are_recorded_and_processed(command: Command, drop: Setup, tmp_path: Path) -> None:
    recording, _ = simulate_recording(drop)
    with serve(recording, pace=RealTime(now=time.monotonic)) as server:
        setup = changed(drop, daq={"remote": server.address, "channel_skew_s": 0.0})
        write_setup(setup, tmp_path / "lab.toml")
        done = command("record", "--source", "ni", "--setup", str(tmp_path / "lab.toml"), "--output", str(tmp_path))
        assert done.status == 0, done.err
        assert not server.tasks
    (path,) = tmp_path.glob("*/run-0001.h5")
    run = read_run(path)
    assert run.raw.dtype == np.int16
    assert run.digitisation.channel_skew_s == pytest.approx(5e-6)
    start = int(np.flatnonzero((recording.raw[:, : -run.n_samples] == run.raw[:, :1]).all(axis=0))[0])
    end = min(recording.n_samples, start + run.n_samples)
    assert np.array_equal(run.raw[:, : end - start], recording.raw[:, start:end])
    summary = read_summary(path)
    assert summary is not None
    assert summary["status"] == "ok"
    assert summary["e"] == pytest.approx(0.5, rel=0.01)


def test_devices_lists_what_the_server_has(command: Command, drop: Setup) -> None:
    recording, _ = simulate_recording(changed(drop, simulation={"scene": "rest", "rest_s": 0.1, "settle_s": 0.0}))
    with serve(recording) as server:
        done = command("devices", "--remote", server.address)
    assert done.status == 0, done.err
    assert "Dev1" in done.out
    assert "DAQPad-6015" in done.out
