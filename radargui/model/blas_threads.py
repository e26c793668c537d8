"""Limit the linear algebra of this process to one thread while many small matrices are solved."""

from __future__ import annotations

import contextlib
import importlib
import threading
from collections.abc import Callable, Generator

from threadpoolctl import ThreadpoolController

_LIBRARIES = ("numpy", "scipy.linalg")
"""Each brings a BLAS of its own, which can only be limited once it is loaded."""


class _Limit:
    """Counts the blocks of this process that want one thread, because the number of threads belongs to the process.

    The first block that begins sets one thread; the last that ends restores the former number, in whatever order they
    end.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._blocks = 0
        self._give_back: Callable[[], None] = lambda: None

    def begin(self) -> None:
        """Count one block more."""
        with self._lock:
            if self._blocks == 0:
                _in_a_thread(self._set)
            self._blocks += 1

    def end(self) -> None:
        """Count one block less."""
        with self._lock:
            self._blocks -= 1
            if self._blocks == 0:
                _in_a_thread(self._give_back)

    def _set(self) -> None:
        for name in _LIBRARIES:
            importlib.import_module(name)
        # looked for each time, which takes a millisecond: a plugin may have brought another library meanwhile
        self._give_back = ThreadpoolController().limit(limits=1, user_api="blas").restore_original_limits


def _in_a_thread(work: Callable[[], None]) -> None:
    """Do something in a thread that ends with it.

    From version 3.8 on threadpoolctl only obeys the thread that set a number, as long as that thread lives. The last
    block may end in another thread than the one in which the first began.
    """
    thread = threading.Thread(target=work, name="radargui-blas-limit")
    thread.start()
    thread.join()


_LIMIT = _Limit()


@contextlib.contextmanager
def one_blas_thread() -> Generator[None]:
    """Let the linear algebra of this process use one thread within this block.

    Threads cost several times what they save where matrices are many and small. Blocks may be nested, and overlap in
    several threads: after the last of them each library has as many threads as before the first.
    """
    _LIMIT.begin()
    try:
        yield
    finally:
        _LIMIT.end()
