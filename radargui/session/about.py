"""Collect what a bug report needs: versions, driver, OpenGL, paths.

`radargui info` prints it, the window copies it.
"""

import os
import platform
import re
import sys
from collections.abc import Iterable
from ctypes.util import find_library
from datetime import datetime
from pathlib import Path

import platformdirs

from radargui import __version__
from radargui.model.calibrated_setup import calibration_words, edited_since, too_old
from radargui.model.errors import RadarGuiError
from radargui.model.setup import Setup, dump_setup
from radargui.session.info import default_data_folder, version_of
from radargui.system.resources import default_setup_path, log_path

PACKAGES = ("numpy", "scipy", "h5py", "matplotlib", "nidaqmx", "PySide6-Essentials", "pyqtgraph", "PyOpenGL")
_NAME = r"[^\\/\s:;\"'<>|]+"
_FOLDERS = re.compile(rf"(?<![\w.>…/\\])(?!//)(?:~|[A-Za-z]:)?[\\/]+(?:{_NAME}(?: {_NAME})*[\\/]+)+(?={_NAME})")
"""The folders of an absolute path; its last name stays."""
_GL_NAMES = {"win32": ("opengl32",), "darwin": ("OpenGL",)}


def about_lines(setup: Setup) -> tuple[str, ...]:
    """Return one fact a line, of the program, this computer and the calibration that a setup refers to."""
    edited = edited_since(setup)
    said = (calibration_words(setup), too_old(setup, datetime.now().astimezone()), edited.text if edited else "")
    facts = {
        "RadarGUI": __version__,
        "Python": f"{platform.python_version()} ({sys.executable})",
        "system": platform.platform(),
        **{name: version_of(name) or "not installed" for name in PACKAGES},
        "NI-DAQmx driver": _driver(),
        "OpenGL library": _opengl(),
        "display": _display(),
        "program": str(Path(__file__).resolve().parent.parent),
        "default setup": str(default_setup_path()),
        "calibration": "; ".join(filter(None, said)) or "none",
        "data folder": str(default_data_folder()),
        "window's settings": str(_settings()),
        "log file": str(log_path()),
    }
    width = max(map(len, facts))
    return tuple(f"{name:{width}}  {fact}" for name, fact in facts.items())


def _settings() -> Path:
    """Return where Qt keeps the window's settings."""
    return platformdirs.user_config_path("RadarGUI", appauthor=False, roaming=True) / "RadarGUI.ini"


def _driver() -> str:
    from radargui.sources.ni.discovery import driver_version

    try:
        return driver_version() or "not installed on this computer"
    except RadarGuiError as error:
        return f"not usable: {error}"


def _opengl() -> str:
    found = filter(None, map(find_library, _GL_NAMES.get(sys.platform, ("GL", "EGL"))))
    return ", ".join(found) or "none found: the track is drawn as projections"


def _display() -> str:
    if not sys.platform.startswith("linux"):
        return platform.system()
    found = [f"{name}={os.environ[name]}" for name in ("DISPLAY", "WAYLAND_DISPLAY") if os.environ.get(name)]
    return ", ".join(found) or "none: only headless commands work here"


def report_text(setup: Setup, entries: Iterable[str], private: dict[str, str]) -> str:
    """Return the text of a bug report: versions and system, the log, the setup.

    Parameters
    ----------
    entries
        Of the log.
    private
        Folders that are nobody's business, and what stands for them.
    """
    log = "\n".join(entries) or "(empty)"
    parts = {"RadarGUI and this computer": "\n".join(about_lines(setup)), "Log": log, "Setup": dump_setup(setup)}
    text = "\n".join(f"--- {title} ---\n{part.strip()}\n" for title, part in parts.items())
    return without_folders(text, private)


def without_folders(text: str, private: dict[str, str]) -> str:
    """Return a text in which paths have lost their folders: names of people and projects stand there."""
    # the longest first: one may lie in another; a text may have backslashes doubled
    for folder in sorted(filter(None, private), key=len, reverse=True):
        for written in {folder, folder.replace("\\", "\\\\"), folder.replace("\\", "/")}:
            text = text.replace(written, private[folder])
    return _FOLDERS.sub("…/", text)
