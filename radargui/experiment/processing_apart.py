"""Processing apart: runs are processed in a process of their own, so that it cannot hold up the reader of samples."""

from __future__ import annotations

import contextlib
import logging
import multiprocessing
import os
import pickle
import signal
import sys
from collections.abc import Callable
from dataclasses import replace
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnProcess
from typing import Any

from radargui.experiment.finished import FinishedJob, process_finished
from radargui.experiment.live_agreement import LiveAgreement
from radargui.experiment.spawning import unheard_children
from radargui.model.errors import CancelledError, ProcessingError, RadarGuiError
from radargui.model.recording import Recording
from radargui.model.result import RunResult
from radargui.processing.long_recording import read_again

_logger = logging.getLogger(__name__)
_STOP = "stop"
_CLOSE_S = 5.0
_BELOW_NORMAL_PRIORITY = 0x4000
_LOWER_BY = 10


class ProcessingApart:
    """One process that does one job after the other, started with the first; used from one thread.

    Threads share Python's one lock: a processing thread beside the reader's makes it wait for tenths of a second. A
    process does not. The window is drawn in time, too. It runs at a lower priority.
    """

    def __init__(self) -> None:
        self._process: SpawnProcess | None = None
        self._connection: Connection | None = None

    def start(self) -> None:
        """Start the process, which takes a second, before there is a job; idempotent.

        Raises
        ------
        ProcessingError
            The system starts no process.
        """
        self._connected()

    def process(
        self, job: FinishedJob, progress: Callable[[float], None], standing: Callable[[RunResult], None]
    ) -> tuple[RunResult, LiveAgreement | None]:
        """Do a job, as `process_finished` does.

        Raises
        ------
        RadarGuiError, CancelledError
            As raised there, or the process cannot be started, or ended without an answer.
        """
        connection = self._connected()
        connection.send(job)
        stopped = False
        samples: Recording | None = None
        try:
            while True:
                kind, value = connection.recv()
                if kind == "error":
                    raise value
                if kind == "progress":
                    try:
                        progress(value)
                    except CancelledError:
                        if not stopped:
                            connection.send(_STOP)
                        stopped = True
                    continue
                result, agreement = _received(connection, value)
                samples = samples or read_again(job.path, result.recording)
                result = replace(result, recording=samples)
                if kind == "result":
                    return result, agreement
                standing(result)
        except (EOFError, OSError, pickle.PickleError) as error:
            self.close()
            raise ProcessingError(
                "The process that processes runs ended without an answer",
                reasons=("the memory does not suffice", "somebody ended it"),
                remedy="Process the run again.",
            ) from error

    def close(self) -> None:
        """End the process; idempotent."""
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
            process = context.Process(target=_serve, args=(theirs,), name="radargui-processing", daemon=True)
            try:
                with unheard_children():
                    process.start()
            except OSError as error:
                ours.close()
                raise ProcessingError(
                    f"The process that processes runs cannot be started: {error}",
                    reasons=("the memory does not suffice", "too many processes run"),
                    remedy="Process the run again.",
                ) from error
            finally:
                theirs.close()
            self._connection, self._process = ours, process
        return self._connection


def _serve(connection: Connection) -> None:
    """Do jobs until None comes or the parent is gone; in the process."""
    # the parent hears Ctrl-C and says what becomes of the job
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    _lower_priority()
    with contextlib.suppress(EOFError, OSError):
        while (job := connection.recv()) is not None:
            if job != _STOP:
                _answer(connection, job)


def _answer(connection: Connection, job: FinishedJob) -> None:
    def progress(fraction: float) -> None:
        connection.send(("progress", fraction))
        if connection.poll() and connection.recv() in (None, _STOP):
            raise CancelledError

    try:
        result, agreement = process_finished(
            job, progress, lambda preliminary: _send(connection, "standing", preliminary, None)
        )
    except (RadarGuiError, CancelledError) as error:
        connection.send(("error", error))
    except Exception as error:
        _logger.exception("Processing failed")
        connection.send(("error", ProcessingError(f"Processing failed unexpectedly: {type(error).__name__}: {error}")))
    else:
        _send(connection, "result", result, agreement)


def _send(connection: Connection, kind: str, result: RunResult, agreement: LiveAgreement | None) -> None:
    """Send a result without its samples: those are in the file, the parent reads them there."""
    light = replace(result, recording=replace(result.recording, raw=result.recording.raw[:, :0]))
    buffers: list[pickle.PickleBuffer] = []
    data = pickle.dumps((light, agreement), protocol=5, buffer_callback=buffers.append)
    connection.send((kind, (data, len(buffers))))
    for buffer in buffers:
        connection.send_bytes(buffer.raw())


def _received(connection: Connection, sent: tuple[bytes, int]) -> tuple[RunResult, LiveAgreement | None]:
    data, count = sent
    result, agreement = pickle.loads(  # noqa: S301 - from the process that we started
        data, buffers=[connection.recv_bytes() for _ in range(count)]
    )
    return result, agreement


def _lower_priority() -> None:
    with contextlib.suppress(OSError, AttributeError):
        if sys.platform == "win32":
            import ctypes

            kernel: Any = ctypes.windll.kernel32
            kernel.SetPriorityClass(kernel.GetCurrentProcess(), _BELOW_NORMAL_PRIORITY)
        else:
            os.nice(_LOWER_BY)
