"""The command line called in this process, with folders of its own, and one small session to work on."""

from __future__ import annotations

from pathlib import Path

import pytest
from support.command_line import Command, Ended
from support.processing_here import ProcessingHere
from support.small_setups import small_setup_text

from radargui.cli.app import app
from radargui.cli.console import guarded


@pytest.fixture
def command(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Command:
    """Call `radargui` with arguments; the user's own folders are not touched."""
    monkeypatch.setattr("radargui.cli.console.start_log", lambda: None)
    monkeypatch.setattr("platformdirs.user_log_path", lambda *_, **__: tmp_path / "log")
    monkeypatch.setattr("radargui.cli.record.default_data_folder", lambda: tmp_path / "data")
    monkeypatch.setattr("radargui.experiment.series.ProcessingApart", ProcessingHere)

    def call(*arguments: object) -> Ended:
        capsys.readouterr()
        status = guarded(app, [str(argument) for argument in arguments])
        out, err = capsys.readouterr()
        assert "Traceback" not in out + err
        return Ended(status, out, err)

    return call


@pytest.fixture
def setup_file(tmp_path: Path) -> Path:
    """A setup at a low rate, with short runs."""
    path = tmp_path / "small.toml"
    path.write_text(small_setup_text(), encoding="utf-8")
    return path


@pytest.fixture(scope="session")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A session with two simulated runs, made by the command; not to be changed."""
    folder = tmp_path_factory.mktemp("recorded")
    setup = folder / "small.toml"
    setup.write_text(small_setup_text(), encoding="utf-8")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("radargui.cli.console.start_log", lambda: None)
        arguments = ["record", "--runs", "2", "--fast", "--setup", str(setup), "--output", str(folder / "sessions")]
        assert guarded(app, arguments) == 0
    (session,) = (folder / "sessions").iterdir()
    return session
