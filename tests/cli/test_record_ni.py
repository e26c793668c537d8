"""`radargui record --source ni` and `devices` against a stand-in device server, through the real nidaqmx client."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
import pytest
from support.changed import changed
from support.command_line import Command
from support.ni_server import RealTime, serve, usb_6356
from support.ni_server.server import CERTIFICATES
from support.run_contents import read_summary
from support.simulated_recording import simulate_recording
from support.small_setups import quick_setup

from radargui.files.run_file import read_run
from radargui.model.setup import Setup, write_setup


@pytest.fixture
def drop() -> Setup:
    """A short drop at the rate that fills the DAQPad-6015: its server divides 20 MHz, 33333.33 Hz is exact."""
    return changed(
        quick_setup(),
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


def test_devices_lists_those_of_a_server_with_encryption_and_what_one_does_with_a_setup(
    command: Command, drop: Setup, tmp_path: Path
) -> None:
    recording, _ = simulate_recording(changed(drop, simulation={"scene": "rest", "rest_s": 0.1, "settle_s": 0.0}))
    certificate = str(CERTIFICATES / "authority.pem")
    with serve(recording, [usb_6356("Dev1")], certificate="server") as server:
        setup = changed(
            drop,
            daq={"remote": server.address, "remote_certificate": certificate, "start": "digital"}
            | {"start_source": "PFI3", "start_pretrigger": True},
        )
        write_setup(setup, tmp_path / "lab.toml")
        done = command("devices", "--remote", server.address, "--certificate", certificate)
        tried = command("devices", "--setup", tmp_path / "lab.toml")
        assert not server.tasks
    assert done.status == tried.status == 0, done.err + tried.err
    for fact in ("USB-6356", "PFI0..15", "analog", "pre-trigger", "±1 2 5 10 V"):
        assert fact in done.out
    for fact in (
        "6 channels at 33.3 kS/s of 1.25 MS/s each",
        "at a rising edge at /Dev1/PFI3",
        "0.2 s before the edge",
    ):
        assert fact in tried.out


def test_a_certificate_without_server_is_wrong_usage(command: Command) -> None:
    done = command("devices", "--certificate", "server.pem")
    assert done.status == 2
    assert "allowed: with --remote HOST:PORT" in done.error


def test_each_run_about_an_edge_has_its_trigger_there(command: Command, drop: Setup, tmp_path: Path) -> None:
    recording, _ = simulate_recording(drop)
    with serve(recording, [usb_6356("Dev1")], pace=RealTime(now=time.monotonic)) as server:
        level_v = float(recording.volts()[0, :1000].mean()) + 0.3
        setup = changed(
            drop,
            daq={"remote": server.address, "channel_skew_s": 0.0, "start": "analog", "start_source": "I1"}
            | {"start_level_v": level_v, "start_pretrigger": True},
            recording={"maximum_s": 0.8},
        )
        write_setup(setup, tmp_path / "lab.toml")
        done = command("record", "--source", "ni", "--runs", 2, "--setup", tmp_path / "lab.toml", "--output", tmp_path)
        assert done.status == 0, done.err
        assert not server.tasks
        assert server.calls["CfgAnlgEdgeRefTrig"] == 2
    path, second = sorted(tmp_path.glob("*/run-000*.h5"))
    assert np.array_equal(read_run(path).raw, read_run(second).raw)
    run = read_run(path)
    assert run.trigger_index == round(0.2 * 20e6 / 600)
    volts = run.volts()[0]
    assert volts[run.trigger_index - 1] < level_v <= volts[run.trigger_index]
    start = int(np.flatnonzero((recording.raw[:, : -run.n_samples] == run.raw[:, :1]).all(axis=0))[0])
    assert np.array_equal(run.raw, recording.raw[:, start : start + run.n_samples])


def test_a_removed_device_ends_the_run_and_keeps_what_was_read(command: Command, drop: Setup, tmp_path: Path) -> None:
    recording, _ = simulate_recording(drop)
    with serve(recording, pace=RealTime(now=time.monotonic)) as server:
        server.fail("ReadBinaryI16", -201003, after=20)
        setup = changed(drop, daq={"remote": server.address, "channel_skew_s": 0.0})
        write_setup(setup, tmp_path / "lab.toml")
        done = command(
            "record", "--source", "ni", "--seconds", "2", "--setup", tmp_path / "lab.toml", "--output", tmp_path
        )
        assert not server.tasks
    assert done.status == 1
    assert "Dev1 (DAQPad-6015) cannot be reached any more (NI-DAQmx error -201003)." in done.error
    (path,) = tmp_path.glob("*/run-0001.h5")
    assert np.array_equal(read_run(path).raw, recording.raw[:, : 20 * 667])
