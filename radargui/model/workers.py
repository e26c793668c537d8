"""Worker processes that leave Ctrl-C to the process that began them, and end with it."""

import contextlib
import multiprocessing
import os
import signal
import threading
from collections.abc import Iterator
from multiprocessing.connection import wait

_ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMEXPR_NUM_THREADS")


@contextlib.contextmanager
def workers_ignoring_interrupts() -> Iterator[None]:
    """Let processes that are started here use one thread for numerics, and not hear Ctrl-C."""
    kept = {name: os.environ[name] for name in _ONE_THREAD if name in os.environ}
    os.environ.update(dict.fromkeys(_ONE_THREAD, "1"))
    is_main = threading.current_thread() is threading.main_thread()
    # What a process ignores, its children ignore from their first instruction on.
    handler = signal.signal(signal.SIGINT, signal.SIG_IGN) if is_main else None
    try:
        yield
    finally:
        if is_main:
            signal.signal(signal.SIGINT, handler)
        for name in _ONE_THREAD:
            os.environ.pop(name, None)
        os.environ.update(kept)


def begin_worker() -> None:
    """Begin a process of a pool: its initializer.

    A worker holds the sending end of its own queue, so that it would wait for ever for who began it and was killed.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()
    if parent is not None:
        threading.Thread(target=_end_with, args=(parent.sentinel,), name="radargui-parent", daemon=True).start()


def _end_with(parent: int) -> None:
    wait([parent])
    # at once, whatever is computed: nobody takes the answer
    os._exit(1)
