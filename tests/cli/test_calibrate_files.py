"""The command calibrate around the fit: what is read, written, refused; and the check by one drop."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from support.calibrations import calibration_of
from support.command_line import Command

from radargui.calibration.rough_fit import KnownRecording
from radargui.model.calibration_file import read_calibration
from radargui.model.setup import Setup, read_setup


@pytest.fixture
def fitted(monkeypatch: pytest.MonkeyPatch) -> list[KnownRecording]:
    """Stand for the fit, and keep what it is given."""
    given: list[KnownRecording] = []

    def calibrate(recordings: Any, setup: Setup, groups: Any, **_: Any) -> Any:
        given.extend(recordings)
        assert groups == ("tilt",)
        return SimpleNamespace(calibration=calibration_of(setup, shift_u=1.0))

    monkeypatch.setattr("radargui.calibration.calibrate.calibrate", calibrate)
    return given


@pytest.fixture
def session(command: Command, setup_file: Path) -> Path:
    """A drop from a place of its own."""
    folder = setup_file.parent / "sessions"
    place = ("--release", "0.02,0.01,0.1")
    assert command("record", "--fast", "--setup", setup_file, "--output", folder, *place).status == 0
    (made,) = folder.iterdir()
    return made


def test_a_session_of_drops_becomes_a_setup_that_refers_to_its_calibration(
    command: Command, session: Path, setup_file: Path, fitted: list[KnownRecording], tmp_path: Path
) -> None:
    output = tmp_path / "new" / "lab.toml"
    arguments = ("calibrate", session, "--known", "fall", "--free", "tilt", "--setup", setup_file, "--output", output)
    ended = command(*arguments)
    assert ended.status == 0, ended
    assert "receiver.1.tilt_deg" in ended.out
    (one,) = fitted
    # a run knows where its sphere hung
    assert one.release_m == (0.02, 0.01, 0.1)
    assert one.trajectory is None
    assert len(one.checksum) == 64
    before, setup = read_setup(setup_file), read_setup(output)
    assert setup.receiver[0].tilt_deg == pytest.approx(before.receiver[0].tilt_deg + 0.3)
    text = output.read_text(encoding="utf-8")
    assert 'file = "lab.calibration.json"' in text
    # comments of the setup that was there
    assert text.splitlines()[0] == setup_file.read_text(encoding="utf-8").splitlines()[0]
    assert text.startswith("#")
    assert setup.calibration.content is not None
    assert setup.calibration.content.names == read_calibration(output.with_suffix(".calibration.json")).names
    again = command(*arguments)
    assert again.status == 2
    assert "is there already; --force writes over it" in again.err
    assert command(*arguments, "--force").status == 0


def test_recordings_of_other_receivers_are_refused_before_the_fit(
    command: Command, session: Path, fitted: list[KnownRecording], tmp_path: Path
) -> None:
    other = Path(__file__).parents[2] / "resources" / "setups" / "one-receiver.toml"
    output = tmp_path / "new.toml"
    ended = command("calibrate", session, "--known", "fall", "--free", "tilt", "--setup", other, "--output", output)
    assert ended.status == 1
    assert "has 3 IQ pairs, the setup 1 receivers" in ended.err
    assert fitted == []
    assert not output.exists()


def test_an_output_that_cannot_be_written_is_told_before_the_fit(
    command: Command, session: Path, setup_file: Path, fitted: list[KnownRecording]
) -> None:
    output = setup_file / "lab.toml"
    ended = command("calibrate", session, "--known", "fall", "--free", "tilt", "--output", output)
    assert ended.status == 1
    assert ended.error.startswith(f"{setup_file} cannot be made: ")
    assert fitted == []


def test_one_drop_says_whether_the_setup_holds(command: Command, session: Path, setup_file: Path) -> None:
    ended = command("calibrate", "--check", session, "--setup", setup_file)
    assert ended.status == 0, ended
    assert ended.out.startswith("The setup still holds: g 9.8")
    exact = setup_file.read_text(encoding="utf-8").replace("tilt_deg = 40.0", "tilt_deg = 46.0\nu_tilt_deg = 0.1", 1)
    setup_file.write_text(exact, encoding="utf-8")
    ended = command("calibrate", "--check", session, "--setup", setup_file)
    assert ended.status == 1
    assert ended.out.startswith("The setup does not hold: g ")
