"""Worker processes: they leave Ctrl-C to who began them, and end with it."""

import multiprocessing
import os
import signal
import threading
from multiprocessing.connection import wait


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
