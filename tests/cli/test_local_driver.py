"""`radargui devices` and `record --source ni` through the real nidaqmx client and a local driver library in C."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from support.changed import changed
from support.killing import ROOT
from support.ni_driver import build, environment
from support.simulated_recording import simulate_recording
from support.small_setups import quick_setup

from radargui.files.run_file import read_run
from radargui.model.recording import Recording
from radargui.model.setup import Setup, write_setup

Ran = subprocess.CompletedProcess[str]


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return build(tmp_path_factory.mktemp("driver"))


@pytest.fixture(scope="module")
def setup() -> Setup:
    return changed(quick_setup(), daq={"rate_hz": 10_000.0, "channel_skew_s": 15e-6})


@pytest.fixture(scope="module")
def served(setup: Setup) -> Recording:
    return simulate_recording(setup)[0]


@pytest.fixture
def radargui(library: Path, served: Recording, tmp_path: Path) -> Callable[..., Ran]:
    """Run the command line in a process that finds the library."""

    def run(
        *arguments: object, realtime: bool = True, overflow_at: int | None = None, replugged: Path | None = None
    ) -> Ran:
        found = environment(library, served.raw, realtime=realtime, overflow_at=overflow_at, replugged=replugged)
        found |= {f"XDG_{kind}_HOME": str(tmp_path / kind) for kind in ("DATA", "STATE", "CONFIG", "CACHE")}
        found["PYTHONPATH"] = os.pathsep.join([str(ROOT / "tests"), str(ROOT)])
        done = subprocess.run(
            [sys.executable, "-m", "support.command_here", *map(str, arguments)],
            env=found,
            capture_output=True,
            encoding="utf-8",
            timeout=60,
            check=False,
        )
        assert "Traceback" not in done.stdout + done.stderr
        return done

    return run


def record(radargui: Callable[..., Ran], setup: Setup, folder: Path, seconds: float, **how: object) -> tuple[Ran, Path]:
    write_setup(setup, folder / "lab.toml")
    done = radargui(
        "record", "--source", "ni", "--setup", folder / "lab.toml", "--seconds", seconds, "--output", folder, **how
    )
    (path,) = folder.glob("*/run-0001.h5")
    return done, path


def test_the_devices_of_the_local_driver_are_listed_and_a_setup_is_tried_on_one(
    radargui: Callable[..., Ran], setup: Setup, tmp_path: Path
) -> None:
    write_setup(setup, tmp_path / "lab.toml")
    done = radargui("devices", "--setup", tmp_path / "lab.toml")
    assert done.returncode == 0, done.stderr
    for fact in ("DAQPad-6015", "0123ABCD", "USB-6356", "6 channels x 10 kS/s = 60 kS/s of 200 kS/s", "15 us"):
        assert fact in done.stdout


def test_a_device_that_is_not_there_is_told_with_those_that_are(
    radargui: Callable[..., Ran], setup: Setup, tmp_path: Path
) -> None:
    write_setup(changed(setup, daq={"device": "Dev7"}), tmp_path / "lab.toml")
    done = radargui("record", "--source", "ni", "--setup", tmp_path / "lab.toml", "--output", tmp_path)
    assert done.returncode == 1
    assert "no NI device named Dev7 on this computer" in done.stderr
    assert "its driver NI-DAQmx 23.5.0 knows Dev1 (DAQPad-6015), Dev2 (USB-6356)." in done.stderr


def test_six_channels_are_recorded_bit_for_bit(
    radargui: Callable[..., Ran], setup: Setup, served: Recording, tmp_path: Path
) -> None:
    done, path = record(radargui, setup, tmp_path, 0.5)
    assert done.returncode == 0, done.stderr
    run = read_run(path)
    assert run.raw.dtype == np.int16
    np.testing.assert_array_equal(run.raw, served.raw[:, :5000])
    assert run.digitisation.scaling is not None
    assert run.digitisation.scaling[3][:2] == pytest.approx((3e-3, 1.5e-4 + 3e-7))
    assert run.digitisation.channel_skew_s == pytest.approx(15e-6)


def test_an_overflow_keeps_every_sample_that_was_read_and_ends_the_run_readable(
    radargui: Callable[..., Ran], setup: Setup, served: Recording, tmp_path: Path
) -> None:
    done, path = record(radargui, setup, tmp_path, 1.0, overflow_at=1234)
    assert done.returncode == 1
    assert "the buffer was overwritten before it could be read (NI-DAQmx error -200279)" in done.stderr
    assert str(path) in done.stderr
    np.testing.assert_array_equal(read_run(path).raw, served.raw[:, :1234])


def test_an_overflow_with_restart_allowed_is_a_gap_in_the_file_and_a_warning(
    radargui: Callable[..., Ran], setup: Setup, served: Recording, tmp_path: Path
) -> None:
    allowed = changed(setup, recording={"restart_after_error": True})
    done, path = record(radargui, allowed, tmp_path, 0.8, overflow_at=1234)
    assert done.returncode == 0, done.stderr
    assert "samples of each channel were lost" in done.stderr
    run = read_run(path)
    (gap,) = run.gaps
    assert gap.first_index == 1234
    assert gap.count >= 1
    assert gap.reason == "restarted after error -200279, count by the clock"
    np.testing.assert_array_equal(run.raw[:, :1234], served.raw[:, :1234])
    np.testing.assert_array_equal(run.raw[:, 1234:], served.raw[:, : run.n_samples - 1234])
    assert run.n_samples + gap.count == 8000


def test_a_device_that_was_plugged_in_again_goes_on_in_the_same_run(
    radargui: Callable[..., Ran], setup: Setup, served: Recording, tmp_path: Path
) -> None:
    # that it samples simultaneously is what its driver has forgotten
    allowed = changed(setup, recording={"restart_after_error": True}, daq={"device": "Dev2"})
    again = tmp_path / "plugged in again"
    done, path = record(radargui, allowed, tmp_path, 0.8, overflow_at=1234, replugged=again)
    assert done.returncode == 0, done.stderr
    assert again.exists()
    run = read_run(path)
    assert [gap.first_index for gap in run.gaps] == [1234]
    assert run.digitisation.channel_skew_s == 0.0
    np.testing.assert_array_equal(run.raw[:, 1234:], served.raw[:, : run.n_samples - 1234])


def test_what_the_driver_has_forgotten_after_a_replug_a_new_process_is_told(
    library: Path, served: Recording, setup: Setup, tmp_path: Path
) -> None:
    write_setup(setup, tmp_path / "lab.toml")
    again = tmp_path / "plugged in again"
    found = environment(library, served.raw, replugged=again)
    found["PYTHONPATH"] = os.pathsep.join([str(ROOT / "tests"), str(ROOT)])
    done = subprocess.run(
        [sys.executable, "-m", "support.replugged", str(tmp_path / "lab.toml"), str(again)],
        env=found,
        capture_output=True,
        encoding="utf-8",
        timeout=60,
        check=True,
    )
    before, after, listed = done.stdout.splitlines()
    assert before == after == "200000.0 0.0119 1.5e-05"
    assert listed == "[200000.0, 1250000.0]"
