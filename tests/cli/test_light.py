"""What a command loads: nothing of Qt without the window, little for the light ones; the log on disk."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

from typer.main import get_command

from radargui.cli.app import app

SCRIPT = """
import json, sys
from pathlib import Path
from radargui.cli.app import app
from radargui.cli.console import guarded
unwanted, sessions, commands = json.loads(sys.argv[1])
if ["figures", "SESSION"] in [command[:2] for command in commands]:
    from radargui.report import series_figures
    series_figures.FORMATS = ("svg",)  # the report has loaded what the others need
statuses = []
for command in commands:
    newest = str(next(Path(sessions).glob("*"), ""))
    statuses.append(guarded(app, [argument.replace("SESSION", newest) for argument in command]))
loaded = {name.partition(".")[0] for name in sys.modules}
print(json.dumps([statuses, sorted(loaded & set(unwanted))]))
"""
QT = ("PySide6", "shiboken6", "pyqtgraph", "OpenGL")
HEAVY = (*QT, "numpy", "scipy", "h5py", "matplotlib", "rich", "nidaqmx", "jinja2", "typst")


def load(unwanted: tuple[str, ...], *commands: list[str], folder: Path) -> tuple[list[int], list[str], str]:
    """Run commands one after the other in a process of their own, `folder` standing for the user's folders.

    SESSION in an argument stands for the session below `folder`/sessions. Returns the statuses, which of the unwanted
    modules were loaded in the end, and stderr.
    """
    own = {
        name: str(folder)
        for name in ("XDG_STATE_HOME", "XDG_CACHE_HOME", "XDG_CONFIG_HOME", "LOCALAPPDATA", "HOME", "USERPROFILE")
    }
    ended = subprocess.run(
        [sys.executable, "-c", SCRIPT, json.dumps([unwanted, str(folder / "sessions"), commands])],
        capture_output=True,
        encoding="utf-8",
        env={**os.environ, **own, "PYTHONIOENCODING": "utf-8"},
        check=True,
        timeout=100,
    )
    statuses, loaded = json.loads(ended.stdout.splitlines()[-1])
    return statuses, loaded, ended.stderr


def test_no_headless_command_loads_qt(setup_file: Path, tmp_path: Path) -> None:
    commands = (
        ["--version"],
        ["record", "--fast", "--setup", str(setup_file), "--output", str(tmp_path / "sessions")],
        ["process", str(Path("SESSION", "run-0001.h5"))],
        ["report", "SESSION"],
        ["calibrate", "--check", "SESSION"],
        ["figures", "SESSION", "--width", "86mm"],
        ["export", "SESSION", "--format", "mat"],
        ["import", str(Path("SESSION", "export", "run-0001.mat")), "--output", str(tmp_path / "imported")],
        ["batch", "SESSION", "--workers", "1"],
        ["sessions", str(tmp_path / "sessions")],
        ["compare", "SESSION"],
        ["recover", str(tmp_path / "sessions")],
        ["wiring", "--source", "simulated", "--fast", "--setup", str(setup_file)],
        ["info"],
        # nothing to do, but by then it has loaded all that it needs
        ["calibrate"],
        # nobody answers there, but by then it has loaded all that it needs
        ["devices", "--remote", "localhost:1"],
    )
    statuses, loaded, err = load(QT, *commands, folder=tmp_path)
    assert loaded == []
    assert statuses == [0] * (len(commands) - 2) + [2, 1], err
    assert {command[0] for command in commands[1:]} == set(get_command(app).commands)  # type: ignore[attr-defined]


def test_version_and_help_load_nothing_heavy(tmp_path: Path) -> None:
    assert load(HEAVY, ["--version"], ["--help"], ["record", "--help"], folder=tmp_path)[:2] == ([0, 0, 0], [])


def test_an_error_stands_in_the_log_with_its_place_in_the_program(tmp_path: Path) -> None:
    statuses, _, err = load(QT, ["record", "--release", "1,2"], folder=tmp_path)
    assert statuses == [2]
    assert err.startswith("error: --release")
    assert "Traceback" not in err
    (log,) = tmp_path.rglob("radargui.log")
    assert "Traceback" in log.read_text(encoding="utf-8")


def test_the_window_starts_without_what_only_an_estimate_needs() -> None:
    script = "import json, sys, radargui.gui.main_window; print(json.dumps(sorted(sys.modules)))"
    ended = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, encoding="utf-8", check=True, timeout=100
    )
    loaded = json.loads(ended.stdout)
    assert not [name for name in loaded if name.startswith(("scipy", "radargui.estimation.solve", "matplotlib"))]
