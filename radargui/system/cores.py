"""Run alternatives step by step on the cores of this computer, and compare them as they go.

The result does not depend on where a step is done: one process does each piece of work from its first step to its last,
by the same code, with one thread for numerics (decision 0052). Worker processes that leave Ctrl-C to the process that
began them, and end with it.

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
from contextvars import ContextVar
from multiprocessing.connection import Connection, wait
from multiprocessing.context import SpawnProcess
from typing import Any, Generic, TypeVar

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
    wait([parent])
    # at once, whatever is computed: nobody takes the answer
    os._exit(1)


_log = logging.getLogger(__name__)

_Have = TypeVar("_Have")
_Summary = TypeVar("_Summary")
Work = Callable[..., Iterator[tuple[_Have, _Summary]]]
"""What a lane does: a function of a module, whose iterator has something after each step, and tells something of it."""

_MOST = 4
"""Processes: 80 MB each; with more, the longest alternative sets the time (decision 0052)."""
_SPARED = 2
"""Cores left to the reader of samples and to the window."""
_WORTH = 4
"""Pieces of work for which other processes are begun: with or without a floor is decided sooner than they begin."""
_CLOSE_S = 1.0
"""Given to a process that was told to end; it is ended then. Chosen by hand."""


class Lane(Generic[_Have, _Summary]):
    """Pieces of work that go step by step in this process.

    Parameters
    ----------
    work
        Function that begins a piece of work, called with its arguments.
    """

    def __init__(self, work: Work[_Have, _Summary]) -> None:
        self._work = work
        self._running: dict[int, Iterator[tuple[_Have, _Summary]]] = {}
        self._have: dict[int, _Have] = {}
        self._asked: Sequence[int] = ()

    def begin(self, number: int, *args: object) -> None:
        """Begin a piece of work; its first step is done when it is asked for."""
        self._running[number] = self._work(*args)

    def ask(self, numbers: Sequence[int]) -> None:
        """Start one more step of these pieces; `answer` must follow."""
        self._asked = numbers

    def answer(self) -> Iterator[tuple[int, _Summary]]:
        """Yield the reports of the pieces after the step; pieces that have ended are left out."""
        for number in self._asked:
            for have, summary in self._running[number]:
                self._have[number] = have
                yield number, summary
                break

    def result(self, number: int) -> _Have:
        """Return the state of a piece after its last step."""
        return self._have[number]

    def clear(self) -> None:
        """Forget all work."""
        self._running, self._have = {}, {}


class _LaneApart(Lane[_Have, _Summary]):
    """A lane in a process of its own, which begins with it."""

    def __init__(self, work: Work[_Have, _Summary]) -> None:
        context = multiprocessing.get_context("spawn")
        self._connection, theirs = context.Pipe()
        self._process: SpawnProcess = context.Process(
            target=_serve, args=(theirs, work), name="radargui-lane", daemon=True
        )
        self._waits = False
        try:
            with workers_ignoring_interrupts():
                self._process.start()
        finally:
            theirs.close()

    @property
    def pid(self) -> int:
        """Process identifier."""
        return self._process.pid or 0

    def is_ready(self, within_s: float = 0.0) -> bool:
        """Return whether the process has begun, and waits for work, now or within a time."""
        if not self._waits and self._connection.poll(within_s):
            self._waits = bool(self._connection.recv())
        return self._waits

    def begin(self, number: int, *args: object) -> None:
        self._connection.send(("begin", (number, *args)))

    def ask(self, numbers: Sequence[int]) -> None:
        self._connection.send(("answer", numbers))

    def answer(self) -> Iterator[tuple[int, _Summary]]:
        yield from self._received()

    def result(self, number: int) -> _Have:
        self._connection.send(("result", number))
        have: _Have = self._received()
        return have

    def clear(self) -> None:
        self._connection.send(("clear", None))
        # what was asked for before is answered before
        while self._connection.recv() != ("cleared", None):
            pass

    def close(self) -> None:
        """End the process; idempotent."""
        self._connection.close()
        self._process.join(_CLOSE_S)
        if self._process.is_alive():
            self._process.kill()
            self._process.join()

    def _received(self) -> Any:
        kind, value = self._connection.recv()
        if kind == "error":
            raise value
        return value


def _serve(connection: Connection, work: Work[Any, Any]) -> None:
    """Serve a lane in its process until the other end is closed."""
    begin_worker()
    lane = Lane(work)
    with contextlib.suppress(EOFError, OSError):
        # said when all that the work imports has been read
        connection.send(True)
        while True:
            kind, value = connection.recv()
            if kind == "begin":
                lane.begin(*value)
            elif kind == "clear":
                lane.clear()
                connection.send(("cleared", None))
            else:
                connection.send(_answered(lane, kind, value))


def _answered(lane: Lane[Any, Any], kind: str, value: Any) -> tuple[str, Any]:
    try:
        if kind == "result":
            return "result", lane.result(value)
        lane.ask(value)
        return "answer", list(lane.answer())
    except Exception as error:  # noqa: BLE001  raised again by who asked
        return "error", error


class Cores:
    """Lanes on other cores, made when they are first wanted, because each takes a second to begin.

    Parameters
    ----------
    count
        Number of lanes; below two all work is done here.
    """

    def __init__(self, count: int) -> None:
        self.count = count if count > 1 else 0
        self._lanes: list[_LaneApart[Any, Any]] = []

    def lanes(self, work: Work[_Have, _Summary], pieces: int) -> Sequence[Lane[_Have, _Summary]]:
        """Return lanes for some pieces of work: one here as long as the others are not ready.

        Parameters
        ----------
        work
            The same in each call.
        pieces
            How many there are: for four the other lanes are begun, for two they are used where they have been.
        """
        if self.count and not self._lanes and pieces >= _WORTH:
            try:
                self._lanes = [_LaneApart(work) for _ in range(self.count)]
            except OSError:
                self.give_up()
        try:
            ready = [lane for lane in self._lanes if lane.is_ready()] if pieces > 1 else []
        except (EOFError, OSError):
            self.give_up()
            ready = []
        return ready[:pieces] if len(ready) > 1 else [Lane(work)]

    def wait_ready(self, within_s: float) -> bool:
        """Return whether all lanes that were begun are ready within a time each."""
        return bool(self._lanes) and all(lane.is_ready(within_s) for lane in self._lanes)

    def processes(self) -> list[int]:
        """Return the process identifiers of the lanes that were begun."""
        return [lane.pid for lane in self._lanes]

    def give_up(self) -> None:
        """Do all work here from now on, because a process could not be started or has ended."""
        _log.warning("Alternatives are computed one after the other: another process failed", exc_info=True)
        self.count = 0
        self.close()

    def close(self) -> None:
        """End the other lanes; idempotent."""
        for lane in self._lanes:
            lane.close()
        self._lanes = []


_NONE = Cores(0)
_CORES: ContextVar[Cores] = ContextVar("cores", default=_NONE)


def cores() -> Cores:
    """Return the lanes that the work that goes on here may use."""
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
