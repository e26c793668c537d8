"""Starts the window: the one thing the command line calls."""

import ctypes
import gc
import logging
import multiprocessing
import os
import sys
from pathlib import Path

from radargui.gui.opengl_probe import CHECK_VARIABLE, OpenGLProbe, check_here

_log = logging.getLogger(__name__)
_COLLECT_S = 0.5
"""Rings of Python objects live so long; a whole collection takes some ten milliseconds, seldom (chosen by hand)."""


def run_window(setup_path: Path | None = None, *, session: Path | None = None) -> int:
    """Show the window until it is closed; return the exit status.

    Parameters
    ----------
    setup_path
        Setup to begin with; the last one, else the shipped default, where left out.
    session
        Session folder to show at first.
    """
    if os.environ.get(CHECK_VARIABLE) and getattr(sys, "frozen", False):
        return check_here()

    # a sixth of the start: it would look a dozen times through what is only just loaded; the one below is the window's
    gc.disable()

    import signal

    from pyqtgraph.util.garbage_collector import GarbageCollector
    from PySide6.QtCore import QCoreApplication, QEventLoop, Qt
    from PySide6.QtGui import QIcon
    from PySide6.QtWidgets import QApplication

    from radargui.gui.main_window import MainWindow
    from radargui.gui.notices import Hooks, NoticeBoard
    from radargui.gui.settings import Settings
    from radargui.gui.theme import Theme
    from radargui.session.ending import on_ending
    from radargui.system.resources import resources_folder

    # with shared contexts the 3D view keeps its drawing when its panel is torn off and put back
    QCoreApplication.setAttribute(Qt.ApplicationAttribute.AA_ShareOpenGLContexts)
    application = QApplication(sys.argv[:1])
    if sys.platform == "win32":
        # else the task bar shows the icon of Python
        ctypes.windll.shell32.SetCurrentProcessExplicitAppUserModelID("RadarGUI")
    application.setApplicationName("RadarGUI")
    application.setApplicationDisplayName("RadarGUI")
    application.setDesktopFileName("radargui")
    application.setWindowIcon(QIcon(str(resources_folder() / "window" / "radargui.svg")))
    garbage = GarbageCollector(interval=_COLLECT_S)
    board = NoticeBoard()
    hooks = Hooks(board)
    settings = Settings()
    theme = Theme(application, settings.theme())
    if settings.set_aside is not None:
        board.post("warning", f"The remembered settings were damaged; they are kept in {settings.set_aside}")
    window = MainWindow(theme, settings, board, setup_path=setup_path, probe=OpenGLProbe())
    # who was here before finds the window as it was left
    if settings.blob("geometry").isEmpty():
        window.setWindowState(Qt.WindowState.WindowMaximized)
    window.show()
    window.guide.show_at_first()
    if session is not None:
        window.sessions.open(session)

    def interrupted(*_: object) -> None:
        # Ctrl+C in the terminal closes the window as its button does; a second one does not wait
        window.closing.leave_now() if window.closing.active else window.close()

    def ended_by_system() -> None:
        # a logout or shutdown is not asked back, nobody may be there to answer; it kills what returns from here
        window.leave()
        if window.closing.active:
            loop = QEventLoop()
            window.closing.over.connect(loop.quit)
            loop.exec()

    old = signal.signal(signal.SIGINT, interrupted)
    application.commitDataRequest.connect(lambda _manager: ended_by_system())
    try:
        with on_ending(window.leave):
            status = application.exec()
    finally:
        signal.signal(signal.SIGINT, old)
        garbage.timer.stop()
        hooks.remove()
    if left := window.unfinished():
        # told not to wait: a device or disk that does not answer would hold up the interpreter's own end for ever
        _log.warning("left without waiting for %s", ", ".join(left))
        for child in multiprocessing.active_children():
            child.terminate()
        logging.shutdown()
        os._exit(status)
    return status
