"""The command calibrate around the fit: what is read, written, refused; and the check by one drop."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from support.calibrations import calibration_of
from support.command_line import Called, Command

from radargui.calibration.rough_fit import KnownRecording
from radargui.cli.app import Calibrate
from radargui.cli.calibrate import calibrate_antennas
from radargui.experiment.calibrating import calibrate_files
from radargui.model.calibration import read_calibration
from radargui.model.setup import Setup, read_setup


class Fitted:
    """Stands for the fit, and keeps what it is given."""

    def __init__(self) -> None:
        self.given: list[KnownRecording] = []

    def __call__(self, recordings: Any, setup: Setup, groups: Any, **_: Any) -> Any:
        self.given.extend(recordings)
        assert groups == ("tilt",)
        return SimpleNamespace(calibration=calibration_of(setup, shift_u=1.0))

    def by(self, session: Path, output: Path, setup: Path | None = None, *, force: bool = False) -> Callable[[], int]:
        """Return the command that calibrates by a session of drops."""
        options = Calibrate(files=[session], known=["fall"], free="tilt", setup=setup, output=output, force=force)
        return lambda: calibrate_antennas(options, partial(calibrate_files, fit=self))


@pytest.fixture
def session(command: Command, setup_file: Path) -> Path:
    """A drop from a place of its own."""
    folder = setup_file.parent / "sessions"
    place = ("--release", "0.02,0.01,0.1")
    assert command("record", "--fast", "--setup", setup_file, "--output", folder, *place).status == 0
    (made,) = folder.iterdir()
    return made


def test_a_session_of_drops_becomes_a_setup_that_refers_to_its_calibration(
    called: Called, session: Path, setup_file: Path, tmp_path: Path
) -> None:
    output, fitted = tmp_path / "new" / "lab.toml", Fitted()
    ended = called(fitted.by(session, output, setup_file))
    assert ended.status == 0, ended
    assert "receiver.1.tilt_deg" in ended.out
    (one,) = fitted.given
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
    again = called(fitted.by(session, output, setup_file))
    assert again.status == 2
    assert "is there already; --force writes over it" in again.err
    assert called(fitted.by(session, output, setup_file, force=True)).status == 0


def test_recordings_of_other_receivers_are_refused_before_the_fit(
    called: Called, session: Path, tmp_path: Path
) -> None:
    other = Path(__file__).parents[2] / "resources" / "setups" / "one-receiver.toml"
    output, fitted = tmp_path / "new.toml", Fitted()
    ended = called(fitted.by(session, output, other))
    assert ended.status == 1
    assert "has 3 IQ pairs, the setup 1 receivers" in ended.err
    assert fitted.given == []
    assert not output.exists()


def test_an_output_that_cannot_be_written_is_told_before_the_fit(
    called: Called, session: Path, setup_file: Path
) -> None:
    output, fitted = setup_file / "lab.toml", Fitted()
    ended = called(fitted.by(session, output))
    assert ended.status == 1
    assert ended.error.startswith(f"{setup_file} cannot be made: ")
    assert fitted.given == []


def test_one_drop_says_whether_the_setup_holds(command: Command, session: Path, setup_file: Path) -> None:
    ended = command("calibrate", "--check", session, "--setup", setup_file)
    assert ended.status == 0, ended
    assert ended.out.startswith("The setup still holds: g 9.8")
    exact = setup_file.read_text(encoding="utf-8").replace("tilt_deg = 40.0", "tilt_deg = 46.0\nu_tilt_deg = 0.1", 1)
    setup_file.write_text(exact, encoding="utf-8")
    ended = command("calibrate", "--check", session, "--setup", setup_file)
    assert ended.status == 1
    assert ended.out.startswith("The setup does not hold: g ")
