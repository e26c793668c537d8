"""Installs the system libraries that Qt loads, or says how."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

sys.path.insert(1, str(Path(__file__).resolve().parent.parent))

from radargui.system.qt_libraries import OFFSCREEN, WINDOW, advice, has_display, missing

__all__ = ["OFFSCREEN", "WINDOW", "ensure", "has_display", "install"]


def ensure(libraries: dict[str, str]) -> None:
    """Install what is missing as root on Debian or Ubuntu; elsewhere print the command and stop.

    Raises
    ------
    SystemExit
        Something is missing and cannot be installed from here.
    """
    if not sys.platform.startswith("linux"):
        return
    lost = missing(libraries)
    if not lost:
        return
    if shutil.which("apt-get") is None or os.geteuid() != 0:
        sys.exit(" ".join(advice(lost)))
    packages = sorted(lost.values())
    print(f"Installing system libraries for Qt: {' '.join(packages)}", flush=True)
    install(packages)
    if lost := missing(libraries):
        sys.exit(f"apt-get ran, but these libraries are still missing: {', '.join(lost)}")


def install(packages: list[str]) -> None:
    """Install packages by apt-get without questions.

    Raises
    ------
    SystemExit
        apt-get failed.
    """
    quiet = {**os.environ, "DEBIAN_FRONTEND": "noninteractive"}
    update = ["apt-get", "update", "-q"]
    fetch = ["apt-get", "install", "-y", "-q", "--no-install-recommends", *packages]
    for command in (update, fetch):
        if subprocess.run(command, env=quiet, check=False, stdout=subprocess.DEVNULL).returncode:
            sys.exit(f"This failed: {' '.join(command)}")
