"""The hashed locks: every package at one version on every Python and system, without any address."""

from __future__ import annotations

import subprocess
import sys
import tempfile
from itertools import product
from pathlib import Path

import environment

HEADER = "# Written by packaging/dev.py lock from pyproject.toml: do not edit.\n"
GROUPS = {
    "run": ["build"],
    "dev": ["build", "test", "lint", "lock"],
    "package": ["build", "package"],
    "all": ["build", "test", "lint", "lock", "package"],
}
OLDEST, NEWEST = "3.11", "3.14"
PLATFORMS = ("windows", "x86_64-manylinux_2_35")  # PySide6 asks for glibc 2.34: Debian 12, Ubuntu 22.04


def lock(arguments: list[str]) -> int:
    """Write the locks; `--upgrade` in the arguments takes the newest versions instead of those locked now."""
    with tempfile.TemporaryDirectory() as folder:
        pins = Path(folder) / "pins.txt"
        known = [path.read_text(encoding="utf-8") for path in environment.LOCKS.values() if path.exists()]
        pins.write_text("\n".join(known), encoding="utf-8")
        # the versions good for the oldest Python are taken for all: what is tested is what runs
        _compile("all", pins, *arguments)
        for kind, path in environment.LOCKS.items():
            fresh = Path(folder) / path.name
            _compile(kind, fresh, "--universal", "--generate-hashes", "--constraint", str(pins))
            text = HEADER + fresh.read_text(encoding="utf-8")
            if "://" in text or "python_full_version" in text:
                sys.exit(f"{path.name}: the lock would name an address, or differ from Python to Python")
            path.write_text(text, encoding="utf-8", newline="\n")
            print(f"{path.name}: {text.count('==')} packages", flush=True)
        return _check_wheels(Path(folder))


def _check_wheels(folder: Path) -> int:
    """Ask the index whether every locked package has a wheel wherever RadarGUI runs; return the exit status."""
    failed = 0
    for kind, version, platform in product(("dev", "package"), (OLDEST, NEWEST), PLATFORMS):
        where = ["--python-version", version, "--python-platform", platform, "--target", str(folder / "none")]
        dry = ["install", "--dry-run", "--quiet", "--require-hashes", "--only-binary", ":all:", *where]
        code = _uv(*dry, "--requirement", str(environment.LOCKS[kind]))
        print(f"wheels of {kind} for Python {version} on {platform}: {'MISSING' if code else 'all there'}", flush=True)
        failed |= int(code != 0)
    return failed


def _compile(kind: str, output: Path, *options: str) -> None:
    groups = [word for group in GROUPS[kind] for word in ("--group", group)]
    neutral = ["--no-header", "--no-annotate", "--no-emit-index-url", "--quiet", "--python-version", OLDEST]
    if code := _uv("compile", "pyproject.toml", *groups, *neutral, *options, "--output-file", str(output)):
        sys.exit(f"The lock {kind} cannot be resolved (uv ended with status {code}).")


def _uv(*arguments: str) -> int:
    command = [str(environment.tool("uv")), "pip", *arguments]
    return subprocess.run(command, check=False, cwd=environment.ROOT, stdout=subprocess.DEVNULL).returncode
