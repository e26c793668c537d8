"""The experiment: arms, records, processes and saves runs; the window and the command line both call it."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from pathlib import Path

from radargui.acquisition.acquisition import Acquisition
from radargui.acquisition.faults import attempt
from radargui.acquisition.recorder import Recorder
from radargui.acquisition.state import Ending, RecorderState
from radargui.experiment.event import Event, EventKind
from radargui.experiment.recorded_run import RecordedRun
from radargui.experiment.reprocess import process_run
from radargui.experiment.state import ExperimentState
from radargui.model.errors import RadarGuiError
from radargui.model.result import RunResult
from radargui.model.setup import Setup
from radargui.session.session import Session
from radargui.sources.contract import Source

_HEALTH_S = 0.25

Listener = Callable[[Event], None]


class Experiment:
    """Runs recorded one after the other into one session.

    `record_run` and `record` do the work in the caller's thread, where the listener is called too; `finish`, `cancel`
    and the properties may be used from any thread.

    Parameters
    ----------
    setup
        Geometry, limits of a recording, processing.
    source_factory
        Makes the source of a run from its number, counted from 0.
    session
        Where the runs are kept.
    seconds
        Length of runs that start at once; None: each run waits for motion and lasts until it is quiet again.
    process
        Whether to process each run after it was recorded.
    listener
        Told what happens.
    live
        Whether to make a live track.
    patient
        Whether the source loses nothing when it has to wait: a simulation or replay that is as fast as asked.
    attributes
        Further facts to keep with each run file.
    """

    def __init__(
        self,
        setup: Setup,
        source_factory: Callable[[int], Source],
        session: Session,
        *,
        seconds: float | None = None,
        process: bool = True,
        listener: Listener | None = None,
        live: bool = True,
        patient: bool = False,
        attributes: Mapping[str, str | float | int] | None = None,
    ) -> None:
        self._setup = setup
        self._source_factory = source_factory
        self._session = session
        self._seconds = seconds
        self._process = process
        self._listener = listener
        self._live = live
        self._patient = patient
        self._attributes = dict(attributes or {})
        self._lock = threading.Lock()
        self._cancelled = False
        self._number = 0
        self._state = ExperimentState.IDLE
        self._acquisition: Acquisition | None = None

    @property
    def state(self) -> ExperimentState:
        """Where the experiment is."""
        return self._state

    @property
    def acquisition(self) -> Acquisition | None:
        """The present acquisition, or the last one, to pull samples, live track and health from."""
        return self._acquisition

    @property
    def session(self) -> Session:
        """Where the runs are kept."""
        return self._session

    @property
    def is_cancelled(self) -> bool:
        """Whether `cancel` was called: nothing more will be recorded."""
        return self._cancelled

    def record(self, n_runs: int) -> Iterator[RecordedRun]:
        """Record runs one after the other and yield each; the last one has no file where nothing moved any more.

        Raises
        ------
        RadarGuiError
            A run failed while it was recorded.
        """
        for _ in range(n_runs):
            if self._cancelled:
                return
            run = self.record_run()
            yield run
            if run.path is None:
                return

    def record_run(self) -> RecordedRun:
        """Record one run, process it and save its results.

        Returns
        -------
        RecordedRun
            Without file where nothing moved or it was ended before; with `error` where only processing failed.

        Raises
        ------
        RadarGuiError
            The source or the disk failed; what was recorded until then is kept, the error says where.
        """
        self._number += 1
        try:
            recorder = self._acquire()
        except RadarGuiError as error:
            self._enter(ExperimentState.FAILED, str(error), error=error)
            raise
        run = self._processed(recorder) if self._wants_processing(recorder) else self._unprocessed(recorder)
        if run.error is None:
            self._enter(ExperimentState.DONE if run.path else ExperimentState.IDLE, run.message)
        else:
            self._enter(ExperimentState.FAILED, run.message, error=run.error)
        self._tell(EventKind.RUN, run.message, run=run)
        return run

    def finish(self) -> None:
        """End the recording that is under way; it is kept and processed."""
        acquisition = self._acquisition
        if acquisition is not None:
            acquisition.request_stop()

    def cancel(self) -> None:
        """End everything soon: what was recorded is kept, nothing more is recorded or processed."""
        with self._lock:
            self._cancelled = True
        self.finish()

    def _acquire(self) -> Recorder:
        """Record until the run is complete; all threads are gone afterwards."""
        signals: queue.SimpleQueue[RecorderState | None] = queue.SimpleQueue()
        recorder = Recorder(
            partial(self._session.new_run, attributes=self._attributes),
            self._setup.recording,
            folder=self._session.path,
            seconds=self._seconds,
            on_change=signals.put,
        )
        acquisition = Acquisition(
            self._source_factory(self._number - 1),
            self._setup,
            recorder=recorder,
            live=self._live,
            patient=self._patient,
            on_end=lambda: signals.put(None),
        )
        with self._lock:
            self._acquisition = acquisition
            if self._cancelled:
                acquisition.request_stop()
        acquisition.start()
        try:
            self._follow(acquisition, signals)
        finally:
            acquisition.stop()
        if acquisition.error is not None:
            raise _with_place(acquisition.error, recorder.path)
        self._warn(acquisition)
        return recorder

    def _follow(self, acquisition: Acquisition, signals: queue.SimpleQueue[RecorderState | None]) -> None:
        """Tell what happens until the acquisition has ended."""
        while True:
            try:
                signal = signals.get(timeout=_HEALTH_S)
            except queue.Empty:
                health = acquisition.health
                self._tell(EventKind.HEALTH, health.line(), health=health)
                if self._cancelled:
                    return
                continue
            if signal is None:
                return
            if signal is RecorderState.ARMED and self._seconds is None:
                self._enter(ExperimentState.ARMED, "waiting for the sphere to move")
            elif signal is RecorderState.RECORDING:
                self._enter(ExperimentState.RECORDING, "recording")

    def _warn(self, acquisition: Acquisition) -> None:
        health = acquisition.health
        if health.samples_lost:
            self._tell(
                EventKind.WARNING,
                f"{health.samples_lost} samples of each channel were lost by the source in {health.gaps} gaps",
            )
        if health.samples_not_written:
            self._tell(
                EventKind.WARNING,
                f"{health.samples_not_written} samples of each channel could not be written in time and are lost",
            )
        if health.live_error is not None:
            self._tell(EventKind.WARNING, str(health.live_error), error=health.live_error)
        self._tell(EventKind.HEALTH, health.line(), health=health)

    def _wants_processing(self, recorder: Recorder) -> bool:
        return self._process and not self._cancelled and recorder.path is not None

    def _unprocessed(self, recorder: Recorder) -> RecordedRun:
        ending = recorder.ending or Ending.STOPPED
        if recorder.path is None:
            message = f"No run was recorded: {ending.value}."
        else:
            message = f"{recorder.path.name}: recorded, not processed."
        return RecordedRun(self._number, recorder.path, None, ending, message)

    def _processed(self, recorder: Recorder) -> RecordedRun:
        path, ending = recorder.path, recorder.ending or Ending.STOPPED
        if path is None:
            return self._unprocessed(recorder)
        self._enter(ExperimentState.PROCESSING, "processing")
        results: list[RunResult] = []
        error = attempt(lambda: results.append(process_run(path, self._setup, progress=self._progress)), "Processing")
        if isinstance(error, _CancelledError):
            return self._unprocessed(recorder)
        if error is not None:
            error = _with_place(error, path)
            return RecordedRun(self._number, path, None, ending, f"{path.name}: {error}", error)
        for warning in results[0].warnings:
            self._tell(EventKind.WARNING, warning)
        return RecordedRun(self._number, path, results[0], ending, f"{path.name}: {_said(results[0])}")

    def _progress(self, fraction: float) -> None:
        if self._cancelled:
            raise _CancelledError("Processing was cancelled")
        self._tell(EventKind.PROGRESS, fraction=fraction)

    def _enter(self, state: ExperimentState, message: str, *, error: RadarGuiError | None = None) -> None:
        self._state = state
        self._tell(EventKind.STATE, message, error=error)

    def _tell(self, kind: EventKind, message: str = "", **facts: object) -> None:
        if self._listener is not None:
            self._listener(Event(kind, self._state, self._number, message, **facts))  # type: ignore[arg-type]


class _CancelledError(RadarGuiError):
    """The operator cancelled while a run was processed."""


def _with_place(error: RadarGuiError, path: Path | None) -> RadarGuiError:
    """Return the error, telling also where the recording is kept."""
    place = f"What was recorded is kept in {path}."
    if path is not None and place not in error.remedy:
        error.remedy = f"{error.remedy} {place}".strip()
    return error


def _said(result: RunResult) -> str:
    if result.status != "ok":
        return f"{result.status.replace('_', ' ')}, {result.reason}".rstrip(", ")
    bounce = next((bounce for bounce in result.bounces.impacts if bounce.valid), None)
    return "processed, no bounce" if bounce is None else f"e = {bounce.e:.4f} ± {bounce.u_e:.4f}"
