"""Processes of our own: one thread each for numerics, and Ctrl-C left to their parent."""

from __future__ import annotations

import contextlib
import os
import signal
import threading
from collections.abc import Iterator

_ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMEXPR_NUM_THREADS")


@contextlib.contextmanager
def workers_ignoring_interrupts() -> Iterator[None]:
    """Let processes that are started here use one thread for numerics, and not hear Ctrl-C."""
    kept = {name: os.environ.get(name) for name in _ONE_THREAD}
    os.environ.update(dict.fromkeys(_ONE_THREAD, "1"))
    is_main = threading.current_thread() is threading.main_thread()
    # What a process ignores, its children ignore from their first instruction on.
    handler = signal.signal(signal.SIGINT, signal.SIG_IGN) if is_main else None
    try:
        yield
    finally:
        if is_main:
            signal.signal(signal.SIGINT, handler)
        for name, value in kept.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value
