"""Compute alternatives side by side on the cores of this computer.

The result does not depend on where one is computed: it is the same code, with one thread for numerics (decision 0052).
Worker processes that leave Ctrl-C to the process that began them, and end with it.

Limit the linear algebra of this process to one thread while many small matrices are solved.
"""

from __future__ import annotations

import contextlib
import importlib
import logging
import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextvars import ContextVar
from multiprocessing import connection
from typing import TypeVar

from threadpoolctl import ThreadpoolController

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
    connection.wait([parent])
    # at once, whatever is computed: nobody takes the answer
    os._exit(1)


_log = logging.getLogger(__name__)

_Piece = TypeVar("_Piece")
_Done = TypeVar("_Done")

_MOST = 4
"""Processes: 80 MB each; with more, the longest alternative sets the time (decision 0052)."""
_SPARED = 2
"""Cores left to the reader of samples and to the window."""
_WORTH = 4
"""Pieces of work for which other processes are begun: with or without a floor is decided sooner than they begin."""


class Cores:
    """Processes on other cores, begun when they are first wanted, because each takes a second to begin.

    Parameters
    ----------
    count
        Number of processes; below two all work is done here.
    """

    def __init__(self, count: int) -> None:
        self.count = count if count > 1 else 0
        self._pool: ProcessPoolExecutor | None = None
        self._begun: list[Future[object]] = []

    def map(self, work: Callable[[_Piece], _Done], pieces: Sequence[_Piece]) -> Iterator[_Done]:
        """Yield what a function of a module makes of each piece, in order.

        Four pieces begin the other processes. Until these are ready, and once one of them has failed, all is done here.
        """
        done = 0
        try:
            if self.count and self._pool is None and len(pieces) >= _WORTH:
                self._begin(work.__module__)
            if self._pool is not None and len(pieces) > 1 and self.wait_ready(0.0):
                for one in self._pool.map(work, pieces):
                    done += 1
                    yield one
        except (BrokenProcessPool, OSError):
            _log.warning("Alternatives are computed one after the other: another process failed", exc_info=True)
            self.count = 0
            self.close()
        yield from map(work, pieces[done:])

    def wait_ready(self, within_s: float) -> bool:
        """Return whether other processes were begun, and all of them are ready within a time."""
        return bool(self._begun) and not wait(self._begun, within_s).not_done

    def close(self) -> None:
        """End the other processes; idempotent."""
        if self._pool is not None:
            self._pool.shutdown(cancel_futures=True)
        self._pool, self._begun = None, []

    def _begin(self, module: str) -> None:
        self._pool = ProcessPoolExecutor(self.count, multiprocessing.get_context("spawn"), begin_worker)
        with workers_ignoring_interrupts():
            # each begins a process, and has it read all that the work imports
            self._begun = [self._pool.submit(_read, module) for _ in range(self.count)]


def _read(module: str) -> None:
    importlib.import_module(module)


_NONE = Cores(0)
_CORES: ContextVar[Cores] = ContextVar("cores", default=_NONE)


def cores() -> Cores:
    """Return the other cores that the work that goes on here may use."""
    return _CORES.get()


@contextlib.contextmanager
def on_cores(count: int | None = None) -> Generator[Cores]:
    """Let alternatives be computed side by side within this block.

    This is for one run at a time; a batch keeps all cores busy with runs.

    Parameters
    ----------
    count
        Processes; None: up to four, two cores left to the reader and the window.
    """
    one = Cores(min(_MOST, (os.cpu_count() or 1) - _SPARED) if count is None else count)
    before = _CORES.set(one)
    try:
        yield one
    finally:
        _CORES.reset(before)
        one.close()


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
