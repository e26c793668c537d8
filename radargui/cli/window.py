"""The window, opened from the command line."""

import os
import sys

from radargui.model.errors import RadarGuiError


def open_window() -> int:
    """Open the window and return the exit status when it is closed.

    Raises
    ------
    RadarGuiError
        There is no display.
    """
    headless = sys.platform.startswith("linux") and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))
    if headless and "QT_QPA_PLATFORM" not in os.environ:
        raise RadarGuiError(
            "There is no display for the window (DISPLAY and WAYLAND_DISPLAY are unset).",
            remedy="The commands work without one: see radargui --help.",
        )
    from radargui.gui.app import run_window

    return run_window()
