"""The command line called in this process, with folders of its own, and one small session to work on."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import typer
from support.command_line import Command, Ended
from support.small_setups import small_setup_text

from radargui.cli.app import app
from radargui.cli.console import guarded


@pytest.fixture(scope="session")
def no_log() -> Iterator[None]:
    """Keep no log of what commands say: one that has a place for it already makes none."""
    kept, root = logging.NullHandler(), logging.getLogger()
    root.addHandler(kept)
    yield
    root.removeHandler(kept)


@pytest.fixture
def own_folders(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Let the user's own folders be those of the test."""
    monkeypatch.setattr("platformdirs.user_log_path", lambda *_, **__: tmp_path / "log")
    monkeypatch.setattr("platformdirs.user_cache_path", lambda *_, **__: tmp_path / "cache")
    monkeypatch.setattr("platformdirs.user_config_path", lambda *_, **__: tmp_path / "config")
    monkeypatch.setattr("platformdirs.user_documents_dir", lambda *_, **__: str(tmp_path / "documents"))


@pytest.fixture
def called(capsys: pytest.CaptureFixture[str], no_log: None, own_folders: None) -> Callable[[Callable[[], int]], Ended]:
    """Do the work of a command, with other collaborators, as the command line does it."""

    def call(work: Callable[[], int]) -> Ended:
        one = typer.Typer()
        one.command()(work)
        capsys.readouterr()
        status = guarded(one, [])
        return Ended(status, *capsys.readouterr())

    return call


@pytest.fixture
def command(capsys: pytest.CaptureFixture[str], no_log: None, own_folders: None) -> Command:
    """Call `radargui` with arguments; the user's own folders are not touched."""

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
def recorded(tmp_path_factory: pytest.TempPathFactory, no_log: None) -> Path:
    """A session with two simulated runs, made by the command; not to be changed."""
    folder = tmp_path_factory.mktemp("recorded")
    setup = folder / "small.toml"
    setup.write_text(small_setup_text(), encoding="utf-8")
    arguments = ["record", "--runs", "2", "--fast", "--setup", str(setup), "--output", str(folder / "sessions")]
    assert guarded(app, arguments) == 0
    (session,) = (folder / "sessions").iterdir()
    return session
