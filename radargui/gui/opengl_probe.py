"""Asks whether OpenGL is usable, in another process, without holding up the window."""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
import threading

from PySide6.QtCore import QObject, Signal
from PySide6.QtGui import QGuiApplication

from radargui.gui.background import Mailbox
from radargui.gui.opengl_check import SOFTWARE, UNUSABLE, USABLE

TIME_LIMIT_S = 20.0
CHECK_VARIABLE = "RADARGUI_OPENGL_CHECK"
"""Set for the process that checks: a frozen program is started again and asks this before anything else."""
FORCE_VARIABLE = "RADARGUI_NO_OPENGL"
"""Set to anything: projections, whatever the computer can do."""

if sys.platform == "win32":
    _NO_CONSOLE = subprocess.CREATE_NO_WINDOW
else:
    _NO_CONSOLE = 0


class OpenGLProbe(QObject):
    """Runs the test once; `answered` tells whether the view in space will work, and whether it is a good choice.

    OpenGL in software (no graphics card, remote desktop) works, but every plot of the window is then put together
    by the processor: measured 6 frames a second against 30 with projections. It is left to the operator.
    """

    answered = Signal(bool, bool, str)

    def __init__(self, command: list[str] | None = None, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._command = command or check_command()
        self._process: subprocess.Popen[str] | None = None
        self._thread: threading.Thread | None = None
        self._closed = False
        self._mailbox = Mailbox(self)

    def start(self) -> None:
        """Begin to ask; answers at once where the answer is known."""
        platform = QGuiApplication.platformName()
        if os.environ.get(FORCE_VARIABLE):
            self._mailbox.post(self._answer, UNUSABLE, f"{FORCE_VARIABLE} is set")
        elif platform in {"offscreen", "minimal", "vnc"}:
            self._mailbox.post(self._answer, UNUSABLE, f"no OpenGL on the platform {platform}")
        else:
            self._thread = threading.Thread(target=self._ask, name="gui opengl test", daemon=True)
            self._thread.start()

    @property
    def busy(self) -> bool:
        """Whether the other process is still looked after."""
        return self._thread is not None and self._thread.is_alive()

    def close(self) -> None:
        """Give up, without waiting for the other process to be gone."""
        self._closed = True
        if self._process is not None:
            with contextlib.suppress(OSError):
                self._process.kill()

    def _ask(self) -> None:
        status, out = UNUSABLE, ""
        try:
            self._process = subprocess.Popen(
                self._command,
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                text=True,
                env={**os.environ, CHECK_VARIABLE: "1"},
                creationflags=_NO_CONSOLE,
            )
            with self._process as process:
                if self._closed:
                    process.kill()
                try:
                    out, _ = process.communicate(timeout=TIME_LIMIT_S)
                except subprocess.TimeoutExpired:
                    process.kill()
                    out = "the test of OpenGL did not end"
            status = process.returncode
        except OSError as error:
            out = f"the test of OpenGL could not be run: {error.strerror or error}"
        lines = out.strip().splitlines()
        if not self._closed:
            self._mailbox.post(
                self._answer, status, lines[-1] if lines else f"the test of OpenGL ended with status {status}"
            )

    def _answer(self, status: int, words: str) -> None:
        if self._thread is not None:
            self._thread.join()
        if not self._closed:
            self.answered.emit(status in (USABLE, SOFTWARE), status == USABLE, words)


def check_command() -> list[str]:
    """Return the command that runs the test: a frozen program starts itself again."""
    if getattr(sys, "frozen", False):
        return [sys.executable]
    return [sys.executable, "-m", "radargui.gui.opengl_check"]
