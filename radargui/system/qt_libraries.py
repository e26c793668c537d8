"""The system libraries that Qt loads: which are missing here, and the packages of Debian and Ubuntu that hold them.

Nothing but the standard library is imported: `packaging/dev.py` reads this before anything is installed.
"""

import ctypes
import os
import shutil
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


def advice(lost: dict[str, str]) -> tuple[str, str]:
    """Return what is missing as a sentence, and what to do about it."""
    said = f"Qt needs system libraries that are missing: {', '.join(lost)}."
    if shutil.which("apt-get") is None:
        return said, "Install them with your package manager."
    packages = " ".join(sorted(lost.values()))
    return said, f"Install them with:\n  sudo apt-get update && sudo apt-get install -y {packages}"
