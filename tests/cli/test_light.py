"""What a command loads: nothing of Qt without the window, little for the light ones; the log on disk."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

SCRIPT = """
import json, sys
from radargui.cli.app import app
from radargui.cli.guard import guarded
unwanted, commands = json.loads(sys.argv[1])
statuses = [guarded(app, command) for command in commands]
loaded = {name.partition(".")[0] for name in sys.modules}
print(json.dumps([statuses, sorted(loaded & set(unwanted))]))
"""
QT = ("PySide6", "shiboken6", "pyqtgraph", "OpenGL")
HEAVY = (*QT, "numpy", "scipy", "h5py", "matplotlib", "pydantic", "rich", "nidaqmx", "jinja2")


def load(unwanted: tuple[str, ...], *commands: list[str], folder: Path) -> tuple[list[int], list[str], str]:
    """Run commands one after the other in a process of their own.

    Returns their statuses, which of the unwanted modules were loaded in the end, and stderr. `folder` stands for the
    user's folders.
    """
    own = {name: str(folder) for name in ("XDG_STATE_HOME", "XDG_CACHE_HOME", "LOCALAPPDATA", "HOME", "USERPROFILE")}
    ended = subprocess.run(
        [sys.executable, "-c", SCRIPT, json.dumps([unwanted, commands])],
        capture_output=True,
        encoding="utf-8",
        env={**os.environ, **own, "PYTHONIOENCODING": "utf-8"},
        check=True,
        timeout=100,
    )
    statuses, loaded = json.loads(ended.stdout.splitlines()[-1])
    return statuses, loaded, ended.stderr


def test_no_headless_command_loads_qt(setup_file: Path, tmp_path: Path) -> None:
    sessions, run = tmp_path / "sessions", tmp_path / "sessions" / "one" / "run-0001.h5"
    record = ["record", "--fast", "--setup", str(setup_file), "--output", str(sessions)]
    rename = f"next(Path({str(sessions)!r}).iterdir())"
    del rename
    statuses, loaded, err = load(QT, record, ["info"], ["devices", "--remote", "localhost:1"], folder=tmp_path)
    assert (statuses, loaded) == ([0, 0, 1], []), err
