"""Close the run that is being recorded when the system ends the program (logout, shutdown, closed terminal)."""

import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from types import FrameType
from typing import Any

_NAMES = ("SIGTERM", "SIGHUP", "SIGBREAK")
"""SIGBREAK is Windows': Ctrl+Break, and what the console sends when it is closed."""


@contextmanager
def on_ending(act: Callable[[], object]) -> Iterator[None]:
    """Call `act` in the main thread when the system wants this program to end; from then on it is not asked again.

    A signal that is ignored already (nohup) stays so. Within another such `with` the inner one is called alone: the
    command line ends a command by an exception, which nothing would catch within the window's event loop. Outside the
    main thread nothing is done.
    """
    before: dict[int, Any] = {}
    ended = False

    def handle(number: int, _frame: FrameType | None) -> None:
        nonlocal ended
        ended = True
        # a logout sends several; what is being closed shall not be interrupted in its turn
        for other in before:
            signal.signal(other, signal.SIG_IGN)
        if number == getattr(signal, "SIGHUP", None):
            _leave_terminal()
        act()

    if threading.current_thread() is threading.main_thread():
        for name in _NAMES:
            number = getattr(signal, name, None)
            # None: set by another language, and not to be set again by this one
            if number is not None and signal.getsignal(number) not in (signal.SIG_IGN, None):
                before[number] = signal.signal(number, handle)
    try:
        with _console_close():
            yield
    finally:
        for number, earlier in before.items():
            # what comes around this is closing too; the outermost gives the signals back
            signal.signal(number, signal.SIG_IGN if ended and earlier != signal.SIG_DFL else earlier)


def interrupt() -> None:
    """End as Ctrl-C does.

    Raises
    ------
    KeyboardInterrupt
        Always.
    """
    raise KeyboardInterrupt


def _leave_terminal() -> None:
    """Let what is printed go nowhere where the terminal is gone: writing to it would fail in the midst of closing."""
    for descriptor in (1, 2):
        with suppress(OSError):
            if os.isatty(descriptor):
                nowhere = os.open(os.devnull, os.O_WRONLY)
                os.dup2(nowhere, descriptor)
                os.close(nowhere)


if sys.platform == "win32":
    import _thread
    import ctypes

    _CLOSE, _LOGOFF, _SHUTDOWN = 2, 5, 6
    _WAIT_S = 20.0
    """Windows ends the program when the handler returns, or after 5 s (close) to 20 s (shutdown) by itself."""

    @contextmanager
    def _console_close() -> Iterator[None]:
        over = threading.Event()

        def handle(event: int) -> bool:
            if event not in (_CLOSE, _LOGOFF, _SHUTDOWN):
                return False
            _thread.interrupt_main(signal.SIGBREAK)
            over.wait(_WAIT_S)
            return True

        kernel = ctypes.WinDLL("kernel32", use_last_error=True)
        handler = ctypes.WINFUNCTYPE(ctypes.c_int, ctypes.c_uint)(handle)
        kernel.SetConsoleCtrlHandler(handler, True)
        try:
            yield
        finally:
            kernel.SetConsoleCtrlHandler(handler, False)
            over.set()

else:

    @contextmanager
    def _console_close() -> Iterator[None]:
        yield
