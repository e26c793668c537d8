"""Open the window from the command line."""

import os
import sys
from collections.abc import Callable
from pathlib import Path

from radargui.model.errors import RadarGuiError, worded


def open_window(path: Path | None = None, run: Callable[..., int] | None = None) -> int:
    """Open the window and return the exit status when it is closed.

    Parameters
    ----------
    path
        Setup file, session or run that it begins with.
    run
        Shows the window; None: `radargui.gui.app.run_window`.

    Raises
    ------
    RadarGuiError
        There is no display, or a system library that Qt loads is missing.
    """
    from radargui.system.qt_libraries import OFFSCREEN, WINDOW, advice, has_display, missing

    if not has_display() and "QT_QPA_PLATFORM" not in os.environ:
        raise worded(RadarGuiError, "no_display")
    # Qt itself would abort without saying which package helps
    on_x11 = bool(os.environ.get("DISPLAY")) and "QT_QPA_PLATFORM" not in os.environ
    if sys.platform.startswith("linux") and (lost := missing(WINDOW if on_x11 else OFFSCREEN)):
        said, remedy = advice(lost)
        raise RadarGuiError(said, remedy=remedy)
    from radargui.gui.app import run_window

    show = run or run_window
    if path is None or path.suffix.lower() == ".toml":
        return show(path)
    return show(session=path if path.is_dir() else path.parent)
