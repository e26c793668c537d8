"""Whether OpenGL is usable: asked in a process of its own, because a bad driver can take the process with it."""

import os
import sys

from PySide6.QtCore import QObject, QProcess, QProcessEnvironment, QTimer, Signal
from PySide6.QtGui import QGuiApplication

TIME_LIMIT_S = 20.0
"""Chosen by hand: less takes a slow start for a driver that hangs. Projections are shown until it is answered."""
CHECK_VARIABLE = "RADARGUI_OPENGL_CHECK"
"""Set for the process that checks: a frozen program is started again and asks this before anything else."""
FORCE_VARIABLE = "RADARGUI_NO_OPENGL"
"""Set to anything: projections, whatever the computer can do."""


class OpenGLProbe(QObject):
    """Runs the test once; `answered` tells whether the view in space will work, and whether it is a good choice.

    OpenGL in software (no graphics card, remote desktop) works, but every plot of the window is then put together
    by the processor: measured 6 frames a second against 30 with projections. It is left to the operator.
    """

    answered = Signal(bool, bool, str)

    def __init__(self, command: list[str] | None = None, parent: QObject | None = None) -> None:
        super().__init__(parent)
        program, *arguments = command or check_command()
        self._process = process = QProcess(self)
        process.setProgram(program)
        process.setArguments(arguments)
        environment = QProcessEnvironment.systemEnvironment()
        environment.insert(CHECK_VARIABLE, "1")
        process.setProcessEnvironment(environment)
        process.setStandardErrorFile(QProcess.nullDevice())
        process.finished.connect(self._ended)
        process.errorOccurred.connect(self._failed)
        self._limit = QTimer(self, singleShot=True, interval=round(1e3 * TIME_LIMIT_S))
        self._limit.timeout.connect(process.kill)
        self._closed = False

    def start(self) -> None:
        """Begin to ask; answers at once where the answer is known."""
        platform = QGuiApplication.platformName()
        known = f"no OpenGL on the platform {platform}" if platform in {"offscreen", "minimal", "vnc"} else ""
        known = f"{FORCE_VARIABLE} is set" if os.environ.get(FORCE_VARIABLE) else known
        if known:
            QTimer.singleShot(0, self, lambda: self._answer(UNUSABLE, known))
        else:
            self._process.start(QProcess.OpenModeFlag.ReadOnly)
            self._limit.start()

    @property
    def busy(self) -> bool:
        """Whether the other process is still looked after."""
        return self._process.state() != QProcess.ProcessState.NotRunning

    def close(self) -> None:
        """Give up, without waiting for the other process to be gone."""
        self._closed = True
        self._process.kill()

    def _failed(self, error: QProcess.ProcessError) -> None:
        if error == QProcess.ProcessError.FailedToStart:
            self._answer(UNUSABLE, f"the test of OpenGL could not be run: {self._process.errorString()}")

    def _ended(self, status: int, how: QProcess.ExitStatus) -> None:
        if how == QProcess.ExitStatus.CrashExit:
            in_time = self._limit.isActive()
            self._answer(UNUSABLE, "the test of OpenGL crashed" if in_time else "the test of OpenGL did not end")
            return
        lines = bytes(self._process.readAllStandardOutput().data()).decode("utf-8", "replace").strip().splitlines()
        self._answer(status, lines[-1] if lines else f"the test of OpenGL ended with status {status}")

    def _answer(self, status: int, words: str) -> None:
        self._limit.stop()
        if not self._closed:
            self.answered.emit(status in (USABLE, SOFTWARE), status == USABLE, words)


def check_command() -> list[str]:
    """Return the command that runs the test: a frozen program starts itself again."""
    return [sys.executable] if getattr(sys, "frozen", False) else [sys.executable, "-m", "radargui.gui.opengl_probe"]


USABLE, SOFTWARE, UNUSABLE = 40, 41, 42
"""Exit statuses: a program without a console has no standard output to answer on."""
_SOFTWARE_NAMES = ("llvmpipe", "softpipe", "swrast", "swiftshader", "gdi generic", "basic render")
MIN_VERSION = (2, 1)
"""Of OpenGL: what pyqtgraph's view in space asks for."""


def check(arguments: list[str]) -> tuple[int, str]:
    """Return whether a 3D view will work, or work slowly (`SOFTWARE`), and the renderer or why not in a few words."""
    from PySide6.QtGui import QGuiApplication, QOffscreenSurface, QOpenGLContext, QSurfaceFormat

    application = QGuiApplication(arguments)
    if application.platformName() in {"offscreen", "minimal", "vnc"}:
        return UNUSABLE, f"no OpenGL on the platform {application.platformName()}"
    context = QOpenGLContext()
    context.setFormat(QSurfaceFormat.defaultFormat())
    if not context.create():
        return UNUSABLE, "no OpenGL context could be made"
    surface = QOffscreenSurface()
    surface.setFormat(context.format())
    surface.create()
    if not context.makeCurrent(surface):
        return UNUSABLE, "the OpenGL context could not be used"
    try:
        version = context.format().version()
        if version < MIN_VERSION:
            return UNUSABLE, f"OpenGL {version[0]}.{version[1]} is too old"
        from OpenGL.platform import PLATFORM

        if not PLATFORM.GetCurrentContext():
            return UNUSABLE, "PyOpenGL does not see the context"
        from OpenGL.GL import GL_RENDERER, glGetString

        renderer = (glGetString(GL_RENDERER) or b"").decode("ascii", "replace")
    finally:
        context.doneCurrent()
    slow = any(name in renderer.lower() for name in _SOFTWARE_NAMES)
    return SOFTWARE if slow else USABLE, f"OpenGL {version[0]}.{version[1]} by {renderer}"


def check_here() -> int:
    """Return the answer; its words go to standard output where there is one."""
    status, words = check(sys.argv[:1])
    if sys.stdout is not None:
        sys.stdout.write(words + "\n")
        sys.stdout.flush()
    return status


if __name__ == "__main__":
    sys.exit(check_here())
