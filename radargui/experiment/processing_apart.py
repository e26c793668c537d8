"""Process runs in a separate process, so that computing cannot delay the reader of samples."""

import atexit
import contextlib
import logging
import multiprocessing
import os
import pickle
import signal
import sys
import threading
from collections.abc import Callable, Sequence
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnProcess
from pathlib import Path
from typing import Any

from radargui.experiment.array_pipe import received_arrays, send_arrays
from radargui.experiment.finished import FinishedJob, LiveAgreement, preliminary_result, process_finished
from radargui.model.cores import on_cores
from radargui.model.errors import CancelledError, ProcessingError, RadarGuiError, fault_of, worded
from radargui.model.result import RunResult
from radargui.model.workers import workers_ignoring_interrupts
from radargui.processing.process import OnPreliminary

_logger = logging.getLogger(__name__)
_STOP, _SOON = "stop", "soon"
"""Beside a job: end the one that is done now; look at one that waits meanwhile."""
_CLOSE_S = 5.0
"""Given to a process that was asked to end; one that still computes is ended. Chosen by hand."""
_BELOW_NORMAL_PRIORITY = 0x4000  # BELOW_NORMAL_PRIORITY_CLASS of the Windows API
_LOWER_BY = 10
"""Steps of Unix niceness: half of the way down."""


class ProcessingApart:
    """One process that does one job after the other, started with the first; used from one thread but for `announce`.

    Threads share Python's one lock: a processing thread beside the reader's makes it wait for tenths of a second. A
    process does not. The window is drawn in time, too. It runs at a lower priority.
    """

    def __init__(self) -> None:
        self._process: SpawnProcess | None = None
        self._connection: Connection | None = None
        self._sending = threading.Lock()
        self._on_preliminary: dict[Path, OnPreliminary | None] = {}

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
        self._process = self._connection = None
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
        while (job := connection.recv()) is not None:
            # what was announced comes now itself, and what was to be stopped has ended
            if isinstance(job, FinishedJob):
                _answer(connection, job)


def _answer(connection: Connection, job: FinishedJob) -> None:
    def progress(fraction: float) -> None:
        connection.send(("progress", fraction))
        while connection.poll():
            said = connection.recv()
            # None comes where the parent closes meanwhile
            if said in (_STOP, None):
                raise CancelledError
            _answer_soon(connection, said[1])

    try:
        result, agreement = process_finished(
            job, progress, lambda preliminary: _send(connection, "preliminary", job, preliminary, None)
        )
    except (RadarGuiError, CancelledError) as error:
        connection.send(("error", error))
    except Exception as error:
        _logger.exception("Processing failed")
        connection.send(("error", fault_of(error, "Processing")))
    else:
        _send(connection, "result", job, result, agreement)


def _answer_soon(connection: Connection, job: FinishedJob) -> None:
    try:
        preliminary = preliminary_result(job)
    except Exception:
        # reported when it is the turn of the job
        _logger.info("There is no preliminary result of %s", job.path, exc_info=True)
        return
    if preliminary is not None:
        _send(connection, "preliminary", job, preliminary, None)


def _send(
    connection: Connection, kind: str, job: FinishedJob, result: RunResult, agreement: LiveAgreement | None
) -> None:
    buffers: list[pickle.PickleBuffer] = []
    data = pickle.dumps((job.path, result, agreement), protocol=5, buffer_callback=buffers.append)
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
