"""The versions that a session was recorded with."""

from __future__ import annotations

import platform
from importlib.metadata import PackageNotFoundError, version

from radargui import __version__

_LIBRARIES = ("numpy", "scipy", "h5py", "nidaqmx")


def versions() -> dict[str, str]:
    """Return program, Python, system and libraries with their versions."""
    found = {"radargui": __version__, "python": platform.python_version(), "system": platform.platform()}
    for library in _LIBRARIES:
        try:
            found[library] = version(library)
        except PackageNotFoundError:
            continue
    return found
