"""Any error ends in one clear line on stderr and an exit status of 1 or 2."""

from __future__ import annotations

import io
import sys
from pathlib import Path

import pytest
from support.command_line import Called, Command
from typer.main import get_command

from radargui import __version__
from radargui.cli.app import app
from radargui.cli.console import make_output_safe
from radargui.cli.window import open_window
from radargui.system.qt_libraries import advice, missing


def test_the_version_is_told(command: Command) -> None:
    assert command("--version").out == f"radargui {__version__}\n"


def test_help_offers_commands_that_explain_themselves(command: Command) -> None:
    ended = command("--help")
    assert ended.status == 0
    listed = ended.out.partition("Commands:\n")[2].partition("\n\n")[0].splitlines()
    offered = [line.split()[0] for line in listed]
    assert set(offered) == set(get_command(app).commands)  # type: ignore[attr-defined]
    assert {"record", "process", "report", "devices", "wiring", "info"} <= set(offered)
    assert all(command(name, "--help").status == 0 for name in offered)


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        (["frobnicate"], "No such command 'frobnicate'"),
        (["record", "--frobnicate"], "No such option"),
        (["record", "--source", "radio"], "'radio' is not one of simulated, ni, replay"),
        (["export", "x", "--format", "xls"], "Invalid value for '--format': 'xls' is not one of 'csv', 'mat', "),
        (["record", "--runs", "0"], "--runs"),
        (["record", "--runs", "many"], "--runs"),
        (["report"], "Missing argument 'SESSION...'"),
    ],
)
def test_wrong_usage_is_one_line_and_status_2(command: Command, arguments: list[str], text: str) -> None:
    ended = command(*arguments)
    assert ended.status == 2
    assert text in ended.error
    assert ended.error.endswith("--help.")
    assert len(ended.err.splitlines()) == 1
    assert not ended.out


def test_an_unexpected_error_is_one_line_that_names_the_log(called: Called, tmp_path: Path) -> None:
    def fail() -> int:
        raise ZeroDivisionError("division\nby zero")

    ended = called(fail)
    assert ended.status == 1
    log = tmp_path / "log" / "radargui.log"
    assert ended.error.startswith("The program failed unexpectedly: ZeroDivisionError: division by zero (")
    assert ended.error.endswith(f"The details are in {log}")


def test_an_interrupt_is_status_1(called: Called) -> None:
    def interrupt() -> int:
        raise KeyboardInterrupt

    ended = called(interrupt)
    assert ended.status == 1
    assert ended.error == "interrupted"


def test_without_a_display_the_window_says_so(command: Command, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "platform", "linux")
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "QT_QPA_PLATFORM"):
        monkeypatch.delenv(name, raising=False)
    ended = command()
    assert ended.status == 1
    assert "There is no display" in ended.error


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="system libraries come with Qt elsewhere")
def test_a_missing_system_library_is_named_with_the_command_that_installs_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("shutil.which", lambda name: f"/usr/bin/{name}")
    lost = missing({"libnowhere.so.9": "libnowhere9", "libc.so.6": "libc6"})
    said, remedy = advice(lost)
    assert said == "Qt needs system libraries that are missing: libnowhere.so.9."
    assert "sudo apt-get update && sudo apt-get install -y libnowhere9" in remedy


def test_a_console_that_lacks_a_sign_shows_a_replacement(monkeypatch: pytest.MonkeyPatch) -> None:
    stream = io.TextIOWrapper(io.BytesIO(), encoding="cp437")
    monkeypatch.setattr(sys, "stdout", stream)
    make_output_safe()
    stream.write("0.80 ± 0.01 m/s² – ✓")
    stream.flush()
    assert stream.buffer.getvalue().decode("cp437") == "0.80 ± 0.01 m/s² ? ?"  # type: ignore[attr-defined]


def test_the_window_begins_with_the_setup_session_or_run_that_is_named(tmp_path: Path) -> None:
    begun: list[tuple[Path | None, Path | None]] = []

    def window(setup_path: Path | None = None, *, session: Path | None = None) -> int:
        begun.append((setup_path, session))
        return 3

    for name in ("lab.toml", "session.json", "run-0001.h5"):
        (tmp_path / name).touch()
        assert open_window(tmp_path / name, window) == 3
    assert open_window(tmp_path, window) == open_window(None, window) == 3
    assert begun == [(tmp_path / "lab.toml", None), *[(None, tmp_path)] * 3, (None, None)]
