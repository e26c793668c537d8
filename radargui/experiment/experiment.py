"""The experiment: arms, records, processes and saves runs; the window and the command line both call it."""

import contextlib
import queue
import threading
from collections.abc import Callable, Iterator, Mapping
from dataclasses import KW_ONLY, dataclass, field
from functools import partial
from pathlib import Path

from radargui.acquisition.acquisition import Acquisition
from radargui.acquisition.recorder import Recorder
from radargui.acquisition.run_output import FinishedRun
from radargui.conditioning.fall import FallTest
from radargui.experiment.event import EventKind, ExperimentState, Listener, Publisher, RecordedRun
from radargui.experiment.finished import FinishedJob, LiveAgreement, process_finished
from radargui.experiment.processing_apart import ProcessingApart
from radargui.experiment.series import AcquisitionSeries, Message, Messages, unprocessed
from radargui.model.errors import CancelledError, ProcessingError, RadarGuiError, attempt
from radargui.model.result import RunResult
from radargui.model.rounding import quantity
from radargui.model.setup import Setup
from radargui.processing.live import LiveMemory, LiveProcessor
from radargui.session.session import BY_OPERATOR, Session
from radargui.sources.contract import Source

__all__ = ["Experiment", "Listener"]


@dataclass(eq=False)
class Experiment:
    """Runs recorded one after the other into one session.

    `record_run` and `record` do the work in the caller's thread, where the listener is called too; `finish`, `cancel`
    and the properties may be used from any thread. Runs are processed in order, in a process of their own, or a thread
    where the source is patient.

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
        Called with each event.
    live
        Whether to make a live track.
    patient
        Whether the source loses nothing when it has to wait: a simulation or replay that is as fast as asked.
    continuous
        Whether the source goes on after a run: `record` then opens one source and arms again after each run without
        losing a sample; else it opens one after the other. Runs without a fall are set aside, where
        `recording.falls_only` is true: rejected in the session, not counted, not processed.
    attributes
        Further facts to keep with each run file.
    memory
        What the live corrections of earlier runs of the session have learned.

    Attributes
    ----------
    acquisition
        The present acquisition, or the last one, to pull samples, live track and health from.
    session
        Where the runs are kept.
    is_cancelled
        Whether `cancel` was called: nothing more will be recorded.
    """

    setup: Setup
    source_factory: Callable[[int], Source]
    session: Session
    _: KW_ONLY
    seconds: float | None = None
    process: bool = True
    listener: Listener | None = None
    live: bool = True
    patient: bool = False
    continuous: bool = False
    attributes: Mapping[str, str | float | int] = field(default_factory=dict)
    memory: LiveMemory = field(default_factory=LiveMemory)

    def __post_init__(self) -> None:
        self._publisher = Publisher(self.listener)
        self._lock = threading.Lock()
        self._leaves = False
        self.is_cancelled = False
        self.acquisition: Acquisition | None = None

    @property
    def state(self) -> ExperimentState:
        """Where the experiment is."""
        return self._publisher.state

    def record(self, n_runs: int) -> Iterator[RecordedRun]:
        """Record runs and yield each when it is processed, in order; the next one is armed meanwhile.

        Those that were set aside come too and do not count. The last one has no file where nothing moved any more.

        Raises
        ------
        RadarGuiError
            A run failed while it was recorded.
        """
        if n_runs < 1 or self.is_cancelled:
            return
        yield from self._series(1, n_runs) if self.continuous else self._series(n_runs, 1)

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
        return list(self._series(1, 1))[-1]

    def finish(self) -> None:
        """End the recording that is under way; it is kept and processed."""
        acquisition = self.acquisition
        if acquisition is not None:
            acquisition.request_stop()

    def reject(self, run: Path, reason: str = BY_OPERATOR) -> None:
        """Set a run aside (kept, hidden, reversible); a series that goes on records another one in its place.

        Raises
        ------
        SessionError
            No such run, or the session cannot be written.
        """
        known = run.name in self.session.rejected
        self.session.reject(run, reason)
        acquisition = self.acquisition
        if not known and acquisition is not None and acquisition.recorder is not None:
            acquisition.recorder.want_another()

    def cancel(self) -> None:
        """End everything soon: what was recorded is kept, nothing more is recorded or processed.

        Of a run that is being processed the preliminary result is kept, where it has one already.
        """
        with self._lock:
            self.is_cancelled = True
        self.finish()

    def leave(self) -> None:
        """End everything now, as `cancel` does; runs that wait for their results are left without, for later."""
        self._leaves = True
        self.cancel()

    def _series(self, n_acquisitions: int, n_runs: int) -> Iterator[RecordedRun]:
        """Record runs, so many from each source; each is processed while the next one is armed."""
        messages: Messages = queue.SimpleQueue[Message]()
        apart = ProcessingApart()
        try:
            series = AcquisitionSeries(
                partial(self._make, messages, n_runs),
                n_acquisitions,
                messages,
                self._publisher,
                process=partial(self._processed, messages, apart) if self.process else None,
                announce=partial(self._announced, messages, apart),
                set_aside=lambda run: self.session.reject(run.path, run.set_aside),
                is_cancelled=lambda: self.is_cancelled,
                cancel=self.cancel,
                waits_for_motion=self.seconds is None,
            )
        except RadarGuiError as error:
            self._publisher.enter(ExperimentState.FAILED, str(error), error=error)
            raise
        try:
            if self.process and not self.patient:
                # what fails here is reported when there is something to process
                with contextlib.suppress(ProcessingError):
                    apart.start()
            yield from series.runs()
        finally:
            apart.close()
        if series.failure is not None:
            failure = _with_place(series.failure, series.failed_file)
            self._publisher.enter(ExperimentState.FAILED, str(failure), error=failure)
            raise failure

    def _make(self, messages: Messages, n_runs: int) -> tuple[Acquisition, Recorder]:
        sets_aside = self.continuous and self.seconds is None and self.setup.recording.falls_only
        recorder = Recorder(
            partial(self.session.new_run, attributes=self.attributes),
            self.setup.recording,
            folder=self.session.path,
            seconds=self.seconds,
            n_runs=n_runs,
            make_judge=partial(FallTest, self.setup) if sets_aside else None,
            on_change=messages.put,
            on_run=messages.put,
        )
        acquisition = Acquisition(
            self.source_factory(self._publisher.number - 1),
            self.setup,
            recorder=recorder,
            live=self.live,
            patient=self.patient,
            on_end=lambda: messages.put(None),
            make_processor=lambda setup, digitisation: LiveProcessor(setup, digitisation, self.memory),
        )
        with self._lock:
            self.acquisition = acquisition
            if self.is_cancelled:
                acquisition.request_stop()
        return acquisition, recorder

    def _announced(
        self, messages: Messages, apart: ProcessingApart, _: Acquisition, run: FinishedRun, number: int
    ) -> None:
        """Let the preliminary result of a run that waits be there soon."""
        if not self.patient:
            job = FinishedJob(run.path, self.setup, run.first_index, None)
            apart.announce(job, self._preliminary(messages, run, number))

    def _processed(
        self, messages: Messages, apart: ProcessingApart, acquisition: Acquisition, run: FinishedRun, number: int
    ) -> RecordedRun:
        """Process a run and return what came of it; in the thread of the jobs."""
        if self._leaves:
            return unprocessed(run, number)
        live = None if acquisition.live is None else acquisition.live.since(run.first_index)
        job = FinishedJob(run.path, self.setup, run.first_index, live)
        found: list[tuple[RunResult, LiveAgreement | None]] = []

        def progress(fraction: float) -> None:
            if self.is_cancelled:
                raise CancelledError
            messages.put(partial(self._publisher.report, EventKind.PROGRESS, number=number, fraction=fraction))

        def work() -> None:
            do = process_finished if self.patient else apart.process
            with contextlib.suppress(CancelledError):
                found.append(do(job, progress, self._preliminary(messages, run, number)))

        error = attempt(work, "Processing")
        if error is not None:
            error = _with_place(error, run.path)
            message = f"{run.path.name}: {error}"
            return RecordedRun(number, run.path, None, run.ending, message, error, health=run.health)
        return _recorded(run, number, *found[0]) if found else unprocessed(run, number)

    def _preliminary(self, messages: Messages, run: FinishedRun, number: int) -> Callable[[RunResult], None]:
        """Return what reports the preliminary result of a run."""
        report = partial(self._publisher.report, EventKind.PRELIMINARY)
        return lambda result: messages.put(partial(report, run=_recorded(run, number, result, None)))


def _recorded(run: FinishedRun, number: int, result: RunResult, agreement: LiveAgreement | None) -> RecordedRun:
    message = f"{run.path.name}: {_said(result, agreement)}"
    return RecordedRun(number, run.path, result, run.ending, message, agreement=agreement, health=run.health)


def _with_place(error: RadarGuiError, path: Path | None) -> RadarGuiError:
    """Return the error, which says also where the recording is kept."""
    place = f"What was recorded is kept in {path}."
    if path is not None and path.exists() and place not in error.remedy:
        error.remedy = f"{error.remedy} {place}".strip()
    return error


def _said(result: RunResult, agreement: LiveAgreement | None) -> str:
    if result.status != "ok":
        return f"{result.status.replace('_', ' ')}, {result.reason}".rstrip(", ")
    bounce = next((bounce for bounce in result.bounces.impacts if bounce.valid), None)
    said = "processed, no bounce" if bounce is None else f"e = {quantity(bounce.e, bounce.u_stated)}"
    said = f"{said}, preliminary" if result.preliminary else said
    return said if agreement is None else f"{said}, live within {1e3 * agreement.rms_m:.2f} mm"
