"""Starts the window: the one thing the command line calls."""

from __future__ import annotations

import os
import sys
from pathlib import Path

from radargui.gui.opengl_probe import CHECK_VARIABLE, OpenGLProbe
from radargui.sources.factory import SourceKind


def run_window(setup_path: Path | None = None, *, source: SourceKind = "simulated") -> int:
    """Show the window until it is closed; return the exit status.

    Parameters
    ----------
    setup_path
        Setup to begin with; the last one, else the shipped default, where left out.
    source
        Source that is chosen at first.
    """
    if os.environ.get(CHECK_VARIABLE) and getattr(sys, "frozen", False):
        from radargui.gui.opengl_check import main

        return main()

    import signal

    from PySide6.QtCore import QCoreApplication, Qt
    from PySide6.QtWidgets import QApplication

    from radargui.gui.garbage import GarbageKeeper
    from radargui.gui.main_window import MainWindow
    from radargui.gui.notices import Hooks, NoticeBoard
    from radargui.gui.settings import Settings
    from radargui.gui.theme import Theme

    # with shared contexts the 3D view keeps its drawing when its panel is torn off and put back
    QCoreApplication.setAttribute(Qt.ApplicationAttribute.AA_ShareOpenGLContexts)
    application = QApplication.instance() or QApplication(sys.argv[:1])
    application.setApplicationName("RadarGUI")
    application.setApplicationDisplayName("RadarGUI")
    GarbageKeeper(application)
    board = NoticeBoard()
    hooks = Hooks(board)
    settings = Settings()
    theme = Theme(application, settings.theme())
    if settings.set_aside is not None:
        board.post("warning", f"The remembered settings were damaged; they are kept in {settings.set_aside}")
    window = MainWindow(theme, settings, board, setup_path=setup_path, source=source, probe=OpenGLProbe())
    window.show()
    # Ctrl+C in the terminal closes the window as its button does
    old = signal.signal(signal.SIGINT, lambda *_: window.close())
    try:
        return application.exec()
    finally:
        signal.signal(signal.SIGINT, old)
        hooks.remove()
