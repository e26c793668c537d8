"""The system libraries that Qt loads: which are missing here, and the command that installs them."""

from __future__ import annotations

import ctypes
import os
import shutil
import subprocess
import sys

# Library as the loader knows it -> package of Debian and Ubuntu
OFFSCREEN = {
    "libglib-2.0.so.0": "libglib2.0-0",
    "libEGL.so.1": "libegl1",
    "libGL.so.1": "libgl1",
    "libxkbcommon.so.0": "libxkbcommon0",
    "libdbus-1.so.3": "libdbus-1-3",
    "libfontconfig.so.1": "libfontconfig1",
}
WINDOW = {
    **OFFSCREEN,
    "libxcb-cursor.so.0": "libxcb-cursor0",
    "libxcb-icccm.so.4": "libxcb-icccm4",
    "libxcb-keysyms.so.1": "libxcb-keysyms1",
    "libxcb-shape.so.0": "libxcb-shape0",
    "libxkbcommon-x11.so.0": "libxkbcommon-x11-0",
}


def has_display() -> bool:
    """Return whether a window can be shown here."""
    if not sys.platform.startswith("linux"):
        return True
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def missing(libraries: dict[str, str]) -> dict[str, str]:
    """Return those libraries that the loader does not find, with their packages."""
    return {name: package for name, package in libraries.items() if not _loads(name)}


def _loads(name: str) -> bool:
    try:
        ctypes.CDLL(name)
    except OSError:
        return False
    return True


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
    names, packages = ", ".join(lost), sorted(lost.values())
    if shutil.which("apt-get") is None:
        sys.exit(f"Qt needs system libraries that are missing: {names}. Install them with your package manager.")
    if os.geteuid() != 0:
        sys.exit(
            f"Qt needs system libraries that are missing: {names}. Install them with:\n"
            f"  sudo apt-get update && sudo apt-get install -y {' '.join(packages)}"
        )
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
