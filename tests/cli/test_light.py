"""What a command loads: nothing of Qt without the window, little for the light ones; the log on disk."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

SCRIPT = """
import sys
from radargui.cli.app import app
from radargui.cli.guard import guarded
status = guarded(app, sys.argv[2:])
loaded = {name.partition(".")[0] for name in sys.modules}
found = sorted(loaded & set(sys.argv[1].split(",")))
print("LOADED", *found)
print("STATUS", status)
"""
QT = "PySide6,shiboken6,pyqtgraph,OpenGL"


def load(unwanted: str, *arguments: object, folder: Path) -> tuple[str, str, int]:
    """Run a command in a process of its own; return its output, what it loaded of `unwanted`, and its status."""
    own = {name: str(folder) for name in ("XDG_STATE_HOME", "XDG_CACHE_HOME", "LOCALAPPDATA", "HOME", "USERPROFILE")}
    ended = subprocess.run(
        [sys.executable, "-c", SCRIPT, unwanted, *map(str, arguments)],
        capture_output=True,
        encoding="utf-8",
        env={**os.environ, **own, "PYTHONIOENCODING": "utf-8"},
        check=True,
        timeout=100,
    )
    *out, loaded, status = ended.stdout.splitlines()
    return "\n".join(out) + ended.stderr, loaded.removeprefix("LOADED").strip(), int(status.removeprefix("STATUS "))


def test_no_headless_command_loads_qt(recorded: Path, tmp_path: Path) -> None:
    setup = recorded.parents[1] / "small.toml"
    for arguments in (
        ["record", "--fast", "--seconds", 0.2, "--setup", setup, "--output", tmp_path / "out"],
        ["process", recorded / "run-0001.h5", "--output", tmp_path / "tables"],
        ["report", recorded, "--output", tmp_path / "report"],
        ["info"],
    ):
        output, loaded, status = load(QT, *arguments, folder=tmp_path)
        assert (loaded, status) == ("", 0), output
    # without driver this command fails, but it has loaded all that it needs by then
    _, loaded, _ = load(QT, "devices", "--remote", "localhost:1", folder=tmp_path)
    assert loaded == ""


def test_version_and_help_load_nothing_heavy(tmp_path: Path) -> None:
    heavy = f"{QT},numpy,scipy,h5py,matplotlib,pydantic,rich,nidaqmx,jinja2"
    for option in ("--version", "--help"):
        assert load(heavy, option, folder=tmp_path)[1:] == ("", 0)


def test_an_error_stands_in_the_log_with_its_place_in_the_program(tmp_path: Path) -> None:
    output, _, status = load(QT, "record", "--release", "1,2", folder=tmp_path)
    assert status == 2
    assert output.startswith("error: --release")
    (log,) = tmp_path.rglob("radargui.log")
    assert "Traceback" in log.read_text(encoding="utf-8")
    assert "Traceback" not in output
