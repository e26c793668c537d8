"""Write dependencies.md: what each dependency is used for, who imports it, and what it weighs when it is installed.

python docs/make_dependencies.py
"""

from __future__ import annotations

import ast
import re
import tomllib
from importlib.metadata import distribution
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
USES = {
    "filelock": "one program writes to a session, one to the index",
    "h5py": "run files, MATLAB 7.3",
    "jinja2": "the report as HTML",
    "matplotlib": "figures",
    "nidaqmx": "NI devices, here and behind NI's gRPC server",
    "npTDMS": "NI TDMS, read and written",
    "numpy": "all numbers",
    "platformdirs": "where settings, logs and data of a user belong on each system",
    "pydantic": "setups, session records and their faults in words",
    "PyOpenGL": "the track in space",
    "pyqtgraph": "live plots, the track in space",
    "PySide6-Essentials": "the window",
    "rich": "progress and tables on a terminal",
    "scipy": "filters, splines, sparse solvers, MATLAB 5",
    "sigmf": "SigMF, checked when read and written",
    "threadpoolctl": "one thread of linear algebra while many small matrices are solved, four times faster",
    "tomlkit": "setups written so that comments stay",
    "typer": "the command line",
    "typst": "pages of the report as PDF",
}
IMPORTED = {"npTDMS": "nptdms", "PyOpenGL": "OpenGL", "PySide6-Essentials": "PySide6"}
HEAD = """# Dependencies

Written by `docs/make_dependencies.py` from `pyproject.toml`, the program's imports and the installed files (Linux,
Python 3.11, what a package brings along not counted). *Files*: how many modules of RadarGUI import it. The locks
(`packaging/requirements*.txt`) hold every package at one version with its hashes; `python3 packaging/dev.py audit`
asks a list of known vulnerabilities where there is a network; `bounds oldest` and `bounds newest` run the tests with
the oldest and newest versions allowed.

| package | allowed | what for | files | MB |
|---|---|---|---|---|
"""


def requirements() -> dict[str, str]:
    """Return each dependency with what is allowed of it."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    found = (re.match(r"([\w-]+)(?:\[[^]]*])?(.*)", one) for one in project["dependencies"])
    return {one[1]: one[2] for one in found if one}


def imports() -> dict[str, int]:
    """Return how many modules of the program import each top-level package."""
    count: dict[str, int] = {}
    for file in (ROOT / "radargui").rglob("*.py"):
        nodes = ast.walk(ast.parse(file.read_text(encoding="utf-8")))
        names = {
            name.partition(".")[0]
            for node in nodes
            for name in (
                [node.module or ""]
                if isinstance(node, ast.ImportFrom)
                else [alias.name for alias in node.names]
                if isinstance(node, ast.Import)
                else []
            )
        }
        for name in names:
            count[name] = count.get(name, 0) + 1
    return count


def weight_mb(name: str) -> float:
    """Return the size of the files that a package has installed."""
    files = (Path(str(one.locate())) for one in distribution(name).files or ())
    return sum(file.stat().st_size for file in files if file.is_file()) / 1e6


if __name__ == "__main__":
    count = imports()
    rows = [
        f"| {name} | `{allowed}` | {USES[name]} | {count[IMPORTED.get(name, name)]} | {weight_mb(name):.1f} |\n"
        for name, allowed in requirements().items()
    ]
    (ROOT / "docs" / "dependencies.md").write_text(HEAD + "".join(rows), encoding="utf-8", newline="\n")
