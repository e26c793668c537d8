"""Processing apart: runs are processed in a process of their own, so that it cannot hold up the reader of samples."""

from __future__ import annotations

import contextlib
import logging
import multiprocessing
import os
import pickle
import sys
from collections.abc import Callable
from dataclasses import replace
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnProcess
from typing import Any

from radargui.experiment.finished import FinishedJob, process_finished
from radargui.experiment.live_agreement import LiveAgreement
from radargui.model.errors import ProcessingError, RadarGuiError
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
    process does not. It runs at a lower priority.
    """

    def __init__(self) -> None:
        self._process: SpawnProcess | None = None
        self._connection: Connection | None = None

    def process(self, job: FinishedJob, progress: Callable[[float], None]) -> tuple[RunResult, LiveAgreement | None]:
        """Do a job; as `process_finished`, and what `progress` raises ends it.

        Raises
        ------
        RadarGuiError
            As raised there, or the process ended without an answer.
        """
        connection = self._connected()
        connection.send(job)
        stopped: RadarGuiError | None = None
        try:
            while True:
                kind, value = connection.recv()
                if kind == "progress":
                    try:
                        progress(value)
                    except RadarGuiError as error:
                        if stopped is None:
                            connection.send(_STOP)
                        stopped = error
                    continue
                break
            if kind == "error":
                raise stopped or value
            result, agreement = pickle.loads(  # noqa: S301 - from the process that we started
                value[0], buffers=[connection.recv_bytes() for _ in range(value[1])]
            )
        except (EOFError, OSError, pickle.PickleError) as error:
            self.close()
            raise ProcessingError(
                "The process that processes runs ended without an answer",
                reasons=("the memory does not suffice", "somebody ended it"),
                remedy="Process the run again.",
            ) from error
        if stopped is not None:
            raise stopped
        return replace(result, recording=read_again(job.path, result.recording)), agreement

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
            self._connection, theirs = context.Pipe()
            self._process = context.Process(target=_serve, args=(theirs,), name="radargui-processing", daemon=True)
            self._process.start()
            theirs.close()
        return self._connection


def _serve(connection: Connection) -> None:
    """Do jobs until None comes or the parent is gone; in the process."""
    _lower_priority()
    with contextlib.suppress(EOFError, OSError, KeyboardInterrupt):
        while (job := connection.recv()) is not None:
            if job != _STOP:
                _answer(connection, job)


def _answer(connection: Connection, job: FinishedJob) -> None:
    def progress(fraction: float) -> None:
        connection.send(("progress", fraction))
        if connection.poll() and connection.recv() in (None, _STOP):
            raise _StoppedError("Processing was stopped")

    try:
        result, agreement = process_finished(job, progress)
    except RadarGuiError as error:
        connection.send(("error", error))
        return
    except Exception as error:
        _logger.exception("Processing failed")
        connection.send(("error", ProcessingError(f"Processing failed unexpectedly: {type(error).__name__}: {error}")))
        return
    # the samples are in the file: the parent reads them there
    light = replace(result, recording=replace(result.recording, raw=result.recording.raw[:, :0]))
    buffers: list[pickle.PickleBuffer] = []
    data = pickle.dumps((light, agreement), protocol=5, buffer_callback=buffers.append)
    connection.send(("result", (data, len(buffers))))
    for buffer in buffers:
        connection.send_bytes(buffer.raw())


class _StoppedError(RadarGuiError):
    """The parent wants no more of this job."""


def _lower_priority() -> None:
    with contextlib.suppress(OSError, AttributeError):
        if sys.platform == "win32":
            import ctypes

            kernel: Any = ctypes.windll.kernel32
            kernel.SetPriorityClass(kernel.GetCurrentProcess(), _BELOW_NORMAL_PRIORITY)
        else:
            os.nice(_LOWER_BY)
