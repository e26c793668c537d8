"""`radargui wiring`: with a simulated operator, and on the stand-in device server with wires exchanged."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.command_line import Command
from support.miswired import Miswired
from support.ni_samples import ni_setup
from support.ni_server import serve

from radargui.model.recording import Recording
from radargui.model.setup import Setup, read_setup, write_setup
from radargui.sources.simulated.model import WiringScene


@pytest.fixture
def setup() -> Setup:
    return ni_setup(None, rate_hz=1000.0, read_interval_s=0.5)


def recorded(setup: Setup, **faults: object) -> Recording:
    scene = WiringScene(setup, realtime=False)
    source = Miswired(scene, **faults)  # type: ignore[arg-type]
    digitisation = source.open()
    source.start()
    blocks = []
    while (block := source.read()) is not None:
        blocks.append(block.samples)
    return Recording("check", np.concatenate(blocks, axis=1), digitisation)


def test_the_simulated_operator_finds_right_wires(command: Command, setup: Setup, tmp_path: Path) -> None:
    write_setup(setup, tmp_path / "lab.toml")
    done = command("wiring", "--source", "simulated", "--fast", "--setup", tmp_path / "lab.toml")
    assert done.status == 0, done.err
    lines = done.out.splitlines()
    assert lines[0] == "1 of 5: in 2 s, for 2 s: Keep everything still, the tracer hanging at its release."
    assert [line.startswith("ok") for line in lines[5:8]] == [True] * 3
    assert lines[-1] == "The wiring is right."


def test_exchanged_wires_at_the_device_are_told_and_the_proposed_setup_mends_them(
    command: Command, setup: Setup, tmp_path: Path
) -> None:
    wrong = recorded(setup, order=[2, 1, 0, 3, 5, 4], inverted=[1])
    with serve(wrong) as server:
        at_server = setup.model_copy(update={"daq": setup.daq.model_copy(update={"remote": server.address})})
        write_setup(at_server, tmp_path / "lab.toml")
        done = command("wiring", "--setup", tmp_path / "lab.toml", "--output", tmp_path / "corrected.toml")
        again = command("wiring", "--setup", tmp_path / "corrected.toml")
        assert server.tasks == []
    assert done.status == 1
    assert "BAD  I2 (ai2) belongs to receiver 1. Take the channels proposed." in done.out
    assert "the wiring is not right" in done.error
    assert 'proposed: daq.channels = ["' in done.out
    assert again.status == 0, again.out
    assert read_setup(tmp_path / "corrected.toml").daq.channels is not None


def test_a_device_that_fails_during_the_check_is_told(command: Command, setup: Setup, tmp_path: Path) -> None:
    with serve(recorded(setup)) as server:
        server.fail("ReadBinaryI16", -201003, after=3)
        at_server = setup.model_copy(update={"daq": setup.daq.model_copy(update={"remote": server.address})})
        write_setup(at_server, tmp_path / "lab.toml")
        done = command("wiring", "--setup", tmp_path / "lab.toml")
        assert server.tasks == []
    assert done.status == 1
    assert "cannot be reached any more" in done.error


def test_a_setup_that_cannot_be_written_is_told_before_the_guided_half_minute(command: Command, tmp_path: Path) -> None:
    ended = command("wiring", "--source", "simulated", "--fast", "--output", tmp_path)
    assert ended.status == 1
    assert ended.error == f"{tmp_path} is a folder, not a file."
    assert not ended.out


def test_fast_is_for_the_simulated_operator_only(command: Command) -> None:
    assert command("wiring", "--fast").status == 2
