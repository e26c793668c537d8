"""What is made of the checkout: help, wheel, frozen folder; and whether its dependencies hold, oldest and newest."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys

import environment

ROOT = environment.ROOT
BUILD, DIST = ROOT / "build", ROOT / "dist"
HELP = BUILD / "help"
LOCKS = tuple(environment.LOCKS.values())
FOR_EACH = {"oldest": "lowest-direct", "newest": "highest"}


def docs(arguments: list[str]) -> int:
    """Build the help that F1 opens, which is the static site too; every warning is an error."""
    python = environment.ensure("package")
    return _call(
        [str(python), "-m", "sphinx", "-W", "-q", "-E", "-d", str(BUILD / "doctrees"), *arguments, "docs", str(HELP)]
    )


def wheel(arguments: list[str]) -> int:
    """Build wheel and source distribution with all resources and the help, and try the wheel."""
    if code := docs([]):
        return code
    shutil.rmtree(DIST / "wheel", ignore_errors=True)
    python = environment.ensure("package")
    made = [
        str(python),
        "-m",
        "hatchling",
        "build",
        "-t",
        "wheel",
        "-t",
        "sdist",
        "-d",
        str(DIST / "wheel"),
        *arguments,
    ]
    return _call(made) or _call([str(python), "packaging/try_wheel.py"])


def freeze(arguments: list[str]) -> int:
    """Build the frozen folder dist/radargui, and try it."""
    if code := docs([]):
        return code
    python = str(environment.ensure("package"))
    where = ["--distpath", str(DIST), "--workpath", str(BUILD / "frozen")]
    made = [python, "-m", "PyInstaller", "--noconfirm", "--log-level", "WARN", *where, "packaging/radargui.spec"]
    return _call([*made, *arguments]) or _call([python, "packaging/try_frozen.py", str(DIST / "radargui")])


def audit(arguments: list[str]) -> int:
    """Ask a public list of vulnerabilities for every locked package; one it cannot ask about fails (network needed)."""
    python = str(environment.ensure("package"))
    files = [word for path in LOCKS for word in ("--requirement", str(path))]
    return _call([python, "-m", "pip_audit", "--strict", "--require-hashes", "--disable-pip", *files, *arguments])


def bounds(arguments: list[str]) -> int:
    """Run the tests with the oldest or the newest versions that pyproject.toml allows: bounds oldest [PYTEST ...]."""
    if not arguments or arguments[0] not in FOR_EACH:
        sys.exit(f"bounds takes one of {', '.join(FOR_EACH)}, then arguments of pytest")
    environment.ensure("dev")
    uv, folder = str(environment.tool("uv")), BUILD / arguments[0]
    python = folder / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    install = [uv, "pip", "install", "--quiet", "--python", str(python), "--resolution", FOR_EACH[arguments[0]]]
    return (
        _call([uv, "venv", "--quiet", "--clear", "--python", sys.executable, str(folder)])
        or _call([*install, "--group", "test", "--group", "build", "--editable", "."])
        # an old library warns of what the newest of another one has renamed
        or _call([str(python), "-m", "pytest", "-n", "2", "-W", "default", *arguments[1:]])
    )


def _call(command: list[str]) -> int:
    kept = {name: value for name, value in os.environ.items() if name not in ("PYTHONHOME", "PYTHONPATH")}
    return subprocess.run(command, cwd=ROOT, env=kept, check=False).returncode
