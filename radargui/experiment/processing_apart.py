"""Process runs in a separate process, so that computing cannot delay the reader of samples."""

import atexit
import contextlib
import importlib
import logging
import multiprocessing
import os
import pickle
import signal
import sys
import threading
from collections import deque
from collections.abc import Callable, Sequence
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnProcess
from pathlib import Path
from typing import Any

import numpy as np

from radargui.experiment.finished import (
    BegunJob,
    FinishedJob,
    LiveAgreement,
    early_result,
    preliminary_result,
    process_finished,
)
from radargui.model.errors import CancelledError, ProcessingError, RadarGuiError, fault_of, worded
from radargui.model.result import RunResult
from radargui.processing.process import OnPreliminary
from radargui.system.cores import on_cores, workers_ignoring_interrupts

_PIECE = 1 << 20
"""Bytes of one message where a pipe knows messages only: copied once more, under the lock, in less than a millisecond.
Chosen by hand."""


def send_arrays(connection: Connection, arrays: Sequence[memoryview]) -> None:
    """Send the bytes of arrays without holding Python's lock; the other end gets their sizes before.

    `Connection.recv_bytes` takes memory for all that is still to come with each piece that has come, and joins the
    pieces under Python's lock: the thread that draws would wait for tenths of a second.

    Parameters
    ----------
    connection
        One end of a pipe; nothing else is sent meanwhile.
    arrays
        Flat, of single bytes, as `pickle.PickleBuffer.raw` gives them.

    Raises
    ------
    OSError
        The other end is closed.
    """
    for array in arrays:
        while array:
            array = array[_send_piece(connection, array) :]


def received_arrays(connection: Connection, sizes: Sequence[int]) -> list[memoryview]:
    """Return the bytes of arrays that `send_arrays` sends, not to be written to.

    Parameters
    ----------
    connection
        The other end.
    sizes
        Bytes of each array.

    Raises
    ------
    EOFError, OSError
        The other end was closed before all had come.
    """
    return [_received_bytes(connection, size) for size in sizes]


def _received_bytes(connection: Connection, size: int) -> memoryview:
    # not a bytearray: that would fill with zeros, under the lock, what is filled here
    whole = np.empty(size, dtype=np.uint8).data
    left = whole
    while left:
        left = left[_receive_piece(connection, left) :]
    return whole.toreadonly()


if sys.platform == "win32":

    def _send_piece(connection: Connection, data: memoryview) -> int:
        connection.send_bytes(data[:_PIECE])
        return min(len(data), _PIECE)

    def _receive_piece(connection: Connection, room: memoryview) -> int:
        return connection.recv_bytes_into(room)

else:

    def _send_piece(connection: Connection, data: memoryview) -> int:
        return os.write(connection.fileno(), data)

    def _receive_piece(connection: Connection, room: memoryview) -> int:
        count = os.readv(connection.fileno(), [room])
        if count == 0:
            raise EOFError
        return count


_logger = logging.getLogger(__name__)
_STOP, _SOON = "stop", "soon"
"""Beside a job: end the one that is done now; look at one that waits meanwhile."""
_LOOK_S = 0.1
"""Between two looks whether a result so far is still wanted."""
_LOADED = ("radargui.processing.by_estimate", "radargui.processing.by_flights")
"""What takes a second to load, and is loaded while the first run is recorded."""
OnBegun = Callable[[RunResult | None], None]
_CLOSE_S = 5.0
"""Given to a process that was asked to end; one that still computes is ended. Chosen by hand."""
_BELOW_NORMAL_PRIORITY = 0x4000  # BELOW_NORMAL_PRIORITY_CLASS of the Windows API
_LOWER_BY = 10
"""Steps of Unix niceness: half of the way down."""


class ProcessingApart:
    """One process that does one job after the other, started with the first.

    Used from one thread, but for `announce` and `announce_begun`.

    Threads share Python's one lock: a processing thread beside the reader's makes it wait for tenths of a second. A
    process does not. The window is drawn in time, too. It runs at a lower priority.
    """

    def __init__(self) -> None:
        self._process: SpawnProcess | None = None
        self._connection: Connection | None = None
        self._sending = threading.Lock()
        self._on_preliminary: dict[Path, OnPreliminary | None] = {}
        self._on_begun: OnBegun | None = None

    def start(self) -> None:
        """Start the process, which takes a second, before there is a job; idempotent.

        Raises
        ------
        ProcessingError
            The system starts no process.
        """
        self._connected()

    def announce(self, job: FinishedJob, on_preliminary: OnPreliminary) -> None:
        """Let the preliminary result of a job that waits be computed between two rounds of the one that is done now."""
        self._on_preliminary[job.path] = on_preliminary
        connection = self._connection
        if connection is not None:
            with self._sending, contextlib.suppress(OSError):
                connection.send((_SOON, job))

    def announce_begun(self, job: BegunJob, on_begun: OnBegun) -> None:
        """Let the result so far of a run be computed, now or between two rounds of the job that is done.

        What comes of it is given to `on_begun` in the thread that calls `process` or `await_begun`. One at a time:
        where the one before is still computed the processor is too slow for it.
        """
        connection = self._connection
        if connection is None or self._on_begun is not None:
            return
        self._on_begun = on_begun
        try:
            with self._sending:
                connection.send((_SOON, job))
        except OSError:
            self._on_begun = None

    def await_begun(self, is_wanted: Callable[[], bool]) -> None:
        """Wait for the result so far that was announced; return at once where none was, or it is there.

        Parameters
        ----------
        is_wanted
            Asked ten times a second; where it is not, the process is told to stop.
        """
        connection, stopped = self._connection, False
        try:
            while connection is not None and self._on_begun is not None:
                if connection.poll(_LOOK_S):
                    self._take_begun(connection, connection.recv()[1])
                elif not stopped and not is_wanted():
                    stopped = True
                    with self._sending:
                        connection.send(_STOP)
        except (EOFError, OSError, pickle.PickleError):
            # what is broken is told by the job that follows
            self._on_begun = None

    def _take_begun(self, connection: Connection, value: Any) -> None:
        report, self._on_begun = self._on_begun, None
        result = None if value is None else _received(connection, value)[1]
        if report is not None:
            report(result)

    def process(
        self, job: FinishedJob, progress: Callable[[float], None], on_preliminary: OnPreliminary
    ) -> tuple[RunResult, LiveAgreement | None]:
        """Do a job, as `process_finished` does.

        Raises
        ------
        RadarGuiError, CancelledError
            As raised there, or the process cannot be started, or ended without an answer.
        """
        connection = self._connected()
        self._on_preliminary.setdefault(job.path, on_preliminary)
        stopped = False
        try:
            with self._sending:
                connection.send(job)
            while True:
                kind, value = connection.recv()
                if kind == "error":
                    raise value
                if kind == "progress":
                    try:
                        progress(value)
                    except CancelledError:
                        if not stopped:
                            with self._sending:
                                connection.send(_STOP)
                        stopped = True
                    continue
                if kind == "begun":
                    self._take_begun(connection, value)
                    continue
                path, result, agreement = _received(connection, value)
                if kind == "result":
                    return result, agreement
                report = self._on_preliminary.get(path)
                # once, also where the job was announced before
                self._on_preliminary[path] = None
                if report is not None:
                    report(result)
        except (EOFError, OSError, pickle.PickleError) as error:
            self.close()
            raise worded(ProcessingError, "process_ended") from error
        finally:
            self._on_preliminary.pop(job.path, None)

    def close(self) -> None:
        """End the process; idempotent."""
        atexit.unregister(self.close)
        process, connection = self._process, self._connection
        self._process = self._connection = self._on_begun = None
        if connection is not None:
            with contextlib.suppress(OSError):
                connection.send(None)
            connection.close()
        if process is not None:
            process.join(_CLOSE_S)
            if process.is_alive():
                process.terminate()
                process.join()
            process.close()

    def _connected(self) -> Connection:
        if self._connection is None:
            context = multiprocessing.get_context("spawn")
            ours, theirs = context.Pipe()
            # no daemon, which may begin no process of its own; the interpreter would wait for it when it ends
            process = context.Process(target=_serve, args=(theirs,), name="radargui-processing")
            atexit.register(self.close)
            try:
                with workers_ignoring_interrupts():
                    process.start()
            except OSError as error:
                ours.close()
                raise worded(ProcessingError, "no_process", error=error) from error
            finally:
                theirs.close()
            self._connection, self._process = ours, process
        return self._connection


class ProcessingHere(ProcessingApart):
    """Does the jobs in this process: for what can wait meanwhile, and may be computed beside it."""

    def start(self) -> None:
        """Nothing is to be started."""

    def announce(self, job: FinishedJob, on_preliminary: OnPreliminary) -> None:
        """Nothing is computed between two rounds of another job."""

    def process(
        self, job: FinishedJob, progress: Callable[[float], None], on_preliminary: OnPreliminary
    ) -> tuple[RunResult, LiveAgreement | None]:
        """Do a job, as `process_finished` does."""
        return process_finished(job, progress, on_preliminary)


def _serve(connection: Connection) -> None:
    """Do jobs until None comes or the parent is gone; in the process."""
    # the parent hears Ctrl-C and says what becomes of the job
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    _lower_priority()
    with contextlib.suppress(EOFError, OSError), on_cores():
        for name in _LOADED:
            importlib.import_module(name)
        inbox = _Inbox(connection)
        while (job := inbox.take()) is not None:
            # what was announced comes now itself, and what was to be stopped has ended
            if isinstance(job, FinishedJob):
                _answer(connection, inbox, job)
            elif isinstance(job, tuple) and isinstance(job[1], BegunJob):
                _answer_begun(connection, inbox, job[1])


class _Inbox:
    """What the parent says, in order; what was looked at too early is read again."""

    def __init__(self, connection: Connection) -> None:
        self._connection = connection
        self._unread: deque[Any] = deque()

    def has_any(self) -> bool:
        """Return whether there is something to take."""
        return bool(self._unread) or self._connection.poll()

    def take(self) -> Any:
        """Return what was said next."""
        return self._unread.popleft() if self._unread else self._connection.recv()

    def is_to_stop(self) -> bool:
        """Return whether something was said meanwhile that ends the work; all of it stays unread."""
        while self._connection.poll():
            self._unread.append(self._connection.recv())
        return any(said is None or said == _STOP for said in self._unread)


def _answer(connection: Connection, inbox: _Inbox, job: FinishedJob) -> None:
    def progress(fraction: float) -> None:
        connection.send(("progress", fraction))
        while inbox.has_any():
            said = inbox.take()
            # None comes where the parent closes meanwhile
            if said in (_STOP, None):
                raise CancelledError
            if isinstance(said[1], BegunJob):
                _answer_begun(connection, inbox, said[1])
            else:
                _answer_soon(connection, said[1])

    try:
        result, agreement = process_finished(
            job, progress, lambda preliminary: _send(connection, "preliminary", job.path, preliminary, None)
        )
    except (RadarGuiError, CancelledError) as error:
        connection.send(("error", error))
    except Exception as error:
        _logger.exception("Processing failed")
        connection.send(("error", fault_of(error, "Processing")))
    else:
        _send(connection, "result", job.path, result, agreement)


def _answer_soon(connection: Connection, job: FinishedJob) -> None:
    try:
        preliminary = preliminary_result(job)
    except Exception:
        # reported when it is the turn of the job
        _logger.info("There is no preliminary result of %s", job.path, exc_info=True)
        return
    if preliminary is not None:
        _send(connection, "preliminary", job.path, preliminary, None)


def _answer_begun(connection: Connection, inbox: _Inbox, job: BegunJob) -> None:
    def progress(_: float) -> None:
        if inbox.is_to_stop():
            raise CancelledError

    result: RunResult | None = None
    try:
        result = early_result(job, progress)
    except CancelledError:
        _logger.info("What is recorded so far is not wanted any more")
    except Exception:
        # reported when it is the turn of the run
        _logger.info("There is no result so far of %s", job.recording.name, exc_info=True)
    if result is None:
        connection.send(("begun", None))
    else:
        _send(connection, "begun", Path(job.recording.name), result, None)


def _send(connection: Connection, kind: str, path: Path, result: RunResult, agreement: LiveAgreement | None) -> None:
    buffers: list[pickle.PickleBuffer] = []
    data = pickle.dumps((path, result, agreement), protocol=5, buffer_callback=buffers.append)
    arrays = [buffer.raw() for buffer in buffers]
    connection.send((kind, (data, [array.nbytes for array in arrays])))
    send_arrays(connection, arrays)


def _received(
    connection: Connection, sent: tuple[bytes, Sequence[int]]
) -> tuple[Path, RunResult, LiveAgreement | None]:
    data, sizes = sent
    found: tuple[Path, RunResult, LiveAgreement | None] = pickle.loads(  # noqa: S301 - from the process that we started
        data, buffers=received_arrays(connection, sizes)
    )
    return found


def _lower_priority() -> None:
    with contextlib.suppress(OSError, AttributeError):
        if sys.platform == "win32":
            import ctypes

            kernel: Any = ctypes.windll.kernel32
            kernel.SetPriorityClass(kernel.GetCurrentProcess(), _BELOW_NORMAL_PRIORITY)
        else:
            os.nice(_LOWER_BY)
