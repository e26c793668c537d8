"""Run a series of one or several acquisitions; each run is processed while the next one is armed.

Arm, record, process and save runs; the window and the command line both call this.
"""

import math
import queue
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import AbstractContextManager, nullcontext, suppress
from dataclasses import KW_ONLY, dataclass, field, replace
from functools import partial
from pathlib import Path

from radargui.acquisition.acquisition import Acquisition
from radargui.acquisition.health import hardly_seen
from radargui.acquisition.recorder import Recorder
from radargui.acquisition.run_output import FinishedRun
from radargui.acquisition.run_plan import Ending, RecorderState
from radargui.experiment.event import (
    LIVE,
    EventKind,
    ExperimentState,
    Listener,
    Publisher,
    RecordedRun,
    RunningWarnings,
    losses,
    recorded,
    shortfall,
    signal_warnings,
    unprocessed,
    with_place,
)
from radargui.experiment.finished import BegunJob, FinishedJob, LiveAgreement
from radargui.experiment.live_bounce import first_bounce
from radargui.experiment.processing_apart import ProcessingApart, ProcessingHere
from radargui.live.processor import LiveMemory, LiveProcessor
from radargui.live.trigger import FallTest
from radargui.model.errors import CancelledError, ProcessingError, RadarGuiError, attempt
from radargui.model.recording import Recording
from radargui.model.result import Bounce, RunResult
from radargui.model.rounding import quantity
from radargui.model.setup import Setup
from radargui.processing.process import BY_FLIGHTS
from radargui.session.session import BY_OPERATOR, Session
from radargui.sources.contract import Source

HEALTH_S = 0.25
"""Between two reports of the health. Chosen by hand."""
LOOK_S = 0.1
"""Between two looks at the live track for the first bounce: a fifth of the half second in which it shall be told."""

_ENTERED = {
    RecorderState.ARMED: (ExperimentState.ARMED, "waiting for the sphere to move"),
    RecorderState.RECORDING: (ExperimentState.RECORDING, "recording"),
    RecorderState.SETTLING: (ExperimentState.SETTLING, "waiting until nothing moves"),
}


Message = RecorderState | FinishedRun | RecordedRun | Callable[[], None] | None
"""What the recorder or the processing says; a report to make; None: the acquisition has ended."""


@dataclass(eq=False)
class RunOrder:
    """What shall be recorded into one session, how, and whether that is still wanted.

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
    awake
        Makes what keeps the computer awake from the first run to the last result, as `kept_awake` does; None: nothing.
    processing
        Makes what processes the runs; None: a process of its own, or this one where the source is patient.

    Attributes
    ----------
    acquisition
        The present acquisition, or the last one, to pull samples, live track and health from.
    is_cancelled
        Whether `cancel` was called: nothing more will be recorded.
    leaves
        Whether `leave` was: nothing more will be processed either.
    publisher
        Of the events.
    lock
        Held while the present acquisition is set or cancelled.
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
    awake: Callable[[], AbstractContextManager[str]] | None = None
    processing: Callable[[], ProcessingApart] | None = None

    def __post_init__(self) -> None:
        self.publisher = Publisher(self.listener)
        self.lock = threading.Lock()
        self.leaves = False
        self.is_cancelled = False
        self.acquisition: Acquisition | None = None

    def finish(self) -> None:
        """End the recording that is under way; it is kept and processed."""
        acquisition = self.acquisition
        if acquisition is not None:
            acquisition.request_stop()

    def cancel(self) -> None:
        """End everything soon: what was recorded is kept, nothing more is recorded or processed.

        Of a run that is being processed the preliminary result is kept, where it has one already.
        """
        with self.lock:
            self.is_cancelled = True
        self.finish()

    def leave(self) -> None:
        """End everything now, as `cancel` does; runs that wait for their results are left without, for later."""
        self.leaves = True
        self.cancel()


class AcquisitionSeries:
    """Follows acquisitions that record runs; reports what happens, has runs processed and hands them out in order.

    Parameters
    ----------
    order
        What is recorded; the number of its publisher is that of the run before the first.
    n_acquisitions
        How many there are at most: none follows one that failed, was stopped, or in which nothing moved.
    n_runs
        To record from each.

    Attributes
    ----------
    failure, failed_file
        What ended the last acquisition, or kept the next one from being made, and the file that was being written.
    """

    def __init__(self, order: RunOrder, n_acquisitions: int, n_runs: int) -> None:
        self._order, self._n_left, self._n_runs = order, n_acquisitions, n_runs
        self._waits_for_motion = order.seconds is None
        self._messages: queue.SimpleQueue[Message] = queue.SimpleQueue()
        make = order.processing or (ProcessingHere if order.patient else ProcessingApart)
        self._processing = make()
        # one thread: runs are processed one after the other
        self._jobs = ThreadPoolExecutor(1, "experiment-processing")
        self._warnings = RunningWarnings()
        self._n_processing = 0
        self._health_due_s = self._look_due_s = 0.0
        self._bounce: Bounce | None = None
        self._is_begun = False
        self._early_results: dict[int, RunResult | FinishedRun] = {}
        self._next_number = order.publisher.number + 1
        self._outcomes: dict[int, RecordedRun] = {}
        self.failure: RadarGuiError | None = None
        self.failed_file: Path | None = None
        self._begin()

    def _begin(self) -> None:
        """Make the next acquisition and its recorder, not started."""
        publisher = self._order.publisher
        publisher.number += 1
        self._base = publisher.number - 1
        self._held: FinishedRun | None = None
        self._last_number: int | None = None
        self._ended = False
        self._n_left -= 1
        order, messages = self._order, self._messages
        sets_aside = order.continuous and self._waits_for_motion and order.setup.recording.falls_only
        self._recorder = Recorder(
            partial(order.session.new_run, attributes=order.attributes),
            order.setup.recording,
            folder=order.session.path,
            seconds=order.seconds,
            n_runs=self._n_runs,
            make_judge=partial(FallTest, order.setup) if sets_aside else None,
            on_change=messages.put,
            on_run=messages.put,
        )
        self._acquisition = Acquisition(
            order.source_factory(self._base),
            order.setup,
            recorder=self._recorder,
            live=order.live,
            patient=order.patient,
            on_end=lambda: messages.put(None),
            make_processor=lambda setup, digitisation: LiveProcessor(setup, digitisation, order.memory),
        )
        with order.lock:
            order.acquisition = self._acquisition
            if order.is_cancelled:
                self._acquisition.request_stop()

    def runs(self) -> Iterator[RecordedRun]:
        """Start, and yield runs until the last acquisition has ended and all are processed."""
        with self._order.awake() if self._order.awake else nullcontext("") as why:
            if why:
                fact = f"This computer may fall asleep before the last run has ended ({why})."
                self._order.publisher.report(EventKind.WARNING, f"{fact} Switch that off in its power settings.")
            yield from self._started()

    def _started(self) -> Iterator[RecordedRun]:
        try:
            if self._order.process:
                # what fails here is reported when there is something to process
                with suppress(ProcessingError):
                    self._processing.start()
            self._acquisition.start()
            with self._jobs:
                try:
                    while not self._ended or self._n_processing:
                        self._take(self._next())
                        yield from self._in_order()
                except BaseException:
                    # Ctrl-C, or whoever asked for the runs has left: nobody waits for what is being computed
                    self._order.cancel()
                    raise
        finally:
            self._acquisition.stop()
            self._processing.close()

    def _next(self) -> Message:
        """Return the next message; look at the live track, and report the health while there is none."""
        self._health_due_s = time.monotonic() + HEALTH_S
        while True:
            self._look()
            with suppress(queue.Empty):
                return self._messages.get(timeout=LOOK_S)
            if self._ended:
                continue
            if self._acquisition.wait(0.0):
                # what it reported as it ended may have come meanwhile
                with suppress(queue.Empty):
                    return self._messages.get_nowait()
                # stopped before it had begun: then nobody reports it
                return None
            if time.monotonic() >= self._health_due_s:
                self._health_due_s += HEALTH_S
                self._report_health()
            if self._order.is_cancelled:
                self._acquisition.stop()

    def _report_health(self) -> None:
        health = self._acquisition.health
        self._order.publisher.report(EventKind.HEALTH, health.line(), health=health)
        for warning in self._warnings.of(health):
            self._order.publisher.report(EventKind.WARNING, warning)

    def _look(self) -> None:
        """Report the first bounce of the run under way, once, as soon as the live track tells its e."""
        live, recorder, now_s = self._acquisition.live, self._recorder, time.monotonic()
        if self._bounce is not None or now_s < self._look_due_s or recorder.state is not RecorderState.RECORDING:
            return
        self._look_due_s = now_s + LOOK_S
        if live is None or (output := recorder.output) is None:
            return
        found: list[Bounce | None] = []
        # a run that is being recorded cannot be repeated: it goes on without a live e
        error = attempt(lambda: found.append(first_bounce(live, output.first_index, self._order.setup)), "The live e")
        if error is not None:
            self._look_due_s = math.inf
            self._order.publisher.report(EventKind.WARNING, str(error))
        elif (bounce := found[0]) is not None:
            self._bounce = bounce
            self._report_bounce(bounce, LIVE)
            self._begin_result()

    def _report_bounce(self, bounce: Bounce, how: str) -> None:
        said = f"{how} e = {quantity(bounce.e, bounce.u_stated)}"
        self._order.publisher.report(EventKind.BOUNCE, said, bounce=bounce)

    def _begin_result(self) -> None:
        """Have the flights of the run under way computed, as far as it is recorded: the sphere may bounce for long."""
        order, output, ring = self._order, self._recorder.output, self._acquisition.ring
        digitisation = self._acquisition.digitisation
        if order.patient or not order.process or order.is_cancelled:
            return
        if output is None or ring is None or digitisation is None:
            return
        if order.setup.processing.correction not in BY_FLIGHTS:
            return
        end = ring.latest
        self._is_begun = True
        blocks = ring.blocks(output.first_index, end)
        # across a gap nothing is computed, and the ring holds ten seconds
        if len(blocks) != 1 or blocks[0].first_index != output.first_index:
            return
        recording = Recording(output.path.stem, blocks[0].samples, digitisation)
        number = order.publisher.number

        def report(result: RunResult | None) -> None:
            if result is not None:
                self._messages.put(partial(self._report_early, number, result))

        self._processing.announce_begun(BegunJob(recording, order.setup), report)
        self._jobs.submit(self._processing.await_begun, lambda: not order.is_cancelled)

    def _report_early(self, number: int, latest: RunResult | FinishedRun) -> None:
        """Report what the flights say so far of a run: its e as soon as that is known, all when its file is closed."""
        other = self._early_results.pop(number, None)
        if isinstance(latest, RunResult) and isinstance(other, FinishedRun):
            self._preliminary(other)(latest)
        elif isinstance(latest, FinishedRun) and isinstance(other, RunResult):
            self._preliminary(latest)(other)
        elif number >= self._next_number:
            self._early_results[number] = latest
            is_recorded = number == self._order.publisher.number and self._bounce is not None
            if is_recorded and isinstance(latest, RunResult) and any(one.valid for one in latest.bounces.impacts[:1]):
                self._report_bounce(latest.bounces.impacts[0], "preliminary")

    def _take(self, message: Message) -> None:
        match message:
            case RecorderState():
                if message in _ENTERED and (self._waits_for_motion or message is not RecorderState.ARMED):
                    self._order.publisher.enter(*_ENTERED[message])
            case FinishedRun():
                self._finished(replace(message, number=self._base + message.number))
            case RecordedRun():
                self._n_processing -= 1
                self._outcomes[message.number] = message
            case None:
                self._end()
            case report:
                report()

    def _in_order(self) -> Iterator[RecordedRun]:
        """Yield what came of runs, none before those of lower number, the last one when all is over."""
        while (run := self._outcomes.get(self._next_number)) is not None:
            if run.number == self._last_number and not self._ended:
                return
            del self._outcomes[self._next_number]
            self._early_results.pop(self._next_number, None)
            self._next_number += 1
            yield self._published(run, is_last=self._ended and not self._n_processing and not self._outcomes)

    def _finished(self, run: FinishedRun) -> None:
        publisher = self._order.publisher
        if run.is_last:
            self._last_number = run.number
        else:
            publisher.number = run.number + 1
        if run.ending is Ending.FAILED:
            return
        for warning in signal_warnings(run):
            publisher.report(EventKind.WARNING, warning, number=run.number, topic="signal")
        for warning in shortfall(run, self._order.seconds):
            publisher.report(EventKind.WARNING, warning, number=run.number)
        if run.set_aside:
            self._order.session.reject(run.path, run.set_aside)
        seen, self._bounce = self._bounce, None
        publisher.report(EventKind.RECORDED, run=unprocessed(run, seen))
        if self._is_begun and not run.set_aside:
            self._report_early(run.number, run)
        self._is_begun = False
        if run.set_aside or not self._order.process or self._order.is_cancelled:
            self._outcomes[run.number] = unprocessed(run)
        elif run.is_last:
            # the processing of the last one can wait until all else is done
            self._held = run
        else:
            self._submit(self._acquisition, run)

    def _end(self) -> None:
        """See to the end of an acquisition: the next one begins, or this was the last."""
        self._acquisition.stop()
        self._warn()
        self._ended = True
        self.failure, self.failed_file = self._acquisition.error, self._recorder.path
        held, last = self._held, self._acquisition
        if self._is_followed():
            self._follow()
        if self._ended and (held is not None or self._n_processing):
            self._order.publisher.enter(ExperimentState.PROCESSING, "processing")
        if held is not None:
            self._submit(last, held)
        if self._ended and self._last_number is None and self.failure is None:
            ending = self._recorder.ending or Ending.STOPPED
            message = f"No run was recorded: {ending.value}."
            if ending in (Ending.NO_MOTION, Ending.WAITED) and (why := hardly_seen(self._recorder.objection)):
                message += f" {why}"
            number = self._order.publisher.number
            self._outcomes[number] = RecordedRun(number, None, None, ending, message)

    def _is_followed(self) -> bool:
        """Return whether another acquisition comes after the one that has ended."""
        may = self._n_left > 0 and not self._order.is_cancelled and self.failure is None
        return may and self._last_number is not None and self._recorder.ending is not Ending.STOPPED

    def _follow(self) -> None:
        try:
            self._begin()
        except RadarGuiError as error:
            # reported after the results of the runs before
            self._ended = True
            self.failure, self.failed_file = error, None
        else:
            self._acquisition.start()

    def _submit(self, acquisition: Acquisition, run: FinishedRun) -> None:
        if self._n_processing:
            # its preliminary result shall be there soon, although it waits
            job = FinishedJob(run.path, self._order.setup, run.first_index, None)
            self._processing.announce(job, self._preliminary(run))
        self._n_processing += 1
        self._jobs.submit(lambda: self._messages.put(self._processed(acquisition, run)))

    def _processed(self, acquisition: Acquisition, run: FinishedRun) -> RecordedRun:
        """Process a run and return what came of it; in the thread of the jobs."""
        order = self._order
        if order.leaves:
            return unprocessed(run)
        live = None if acquisition.live is None else acquisition.live.since(run.first_index)
        job = FinishedJob(run.path, order.setup, run.first_index, live)
        found: list[tuple[RunResult, LiveAgreement | None]] = []

        def progress(fraction: float) -> None:
            if order.is_cancelled:
                raise CancelledError
            report = partial(order.publisher.report, EventKind.PROGRESS, number=run.number, fraction=fraction)
            self._messages.put(report)

        def work() -> None:
            with suppress(CancelledError):
                found.append(self._processing.process(job, progress, self._preliminary(run)))

        error = attempt(work, "Processing")
        if error is not None:
            error = with_place(error, run.path)
            message = f"{run.path.name}: {error}"
            return RecordedRun(run.number, run.path, None, run.ending, message, error, health=run.health)
        return recorded(run, *found[0]) if found else unprocessed(run)

    def _preliminary(self, run: FinishedRun) -> Callable[[RunResult], None]:
        """Return what reports the preliminary result of a run."""
        report = partial(self._order.publisher.report, EventKind.PRELIMINARY)
        return lambda result: self._messages.put(partial(report, run=recorded(run, result, None)))

    def _published(self, run: RecordedRun, *, is_last: bool) -> RecordedRun:
        if run.result is not None:
            for warning in run.result.warnings:
                self._order.publisher.report(EventKind.WARNING, warning, number=run.number)
        if is_last and run.error is not None:
            self._order.publisher.enter(ExperimentState.FAILED, run.message, error=run.error)
        elif is_last:
            self._order.publisher.enter(ExperimentState.DONE if run.path else ExperimentState.IDLE, run.message)
        self._order.publisher.report(EventKind.RUN, run=run)
        return run

    def _warn(self) -> None:
        health = self._acquisition.health
        for warning in (*self._warnings.of(health), *losses(health)):
            self._order.publisher.report(EventKind.WARNING, warning)
        if health.live_error is not None:
            self._order.publisher.report(EventKind.WARNING, str(health.live_error), error=health.live_error)
        self._order.publisher.report(EventKind.HEALTH, health.line(), health=health)


__all__ = ["Experiment", "Listener"]


class Experiment(RunOrder):
    """Runs recorded one after the other into one session; parameters and attributes as of `RunOrder`.

    `record` does the work in the caller's thread, where the listener is called too; `finish`, `cancel` and the
    properties may be used from any thread. Runs are processed in order, in a process of their own, or a thread
    where the source is patient.
    """

    @property
    def state(self) -> ExperimentState:
        """Where the experiment is."""
        return self.publisher.state

    def record(self, n_runs: int) -> Iterator[RecordedRun]:
        """Record runs and yield each when it is processed, in order; the next one is armed meanwhile.

        Those that were set aside come too and do not count. The last one has no file where nothing moved any more; one
        whose processing alone failed has an `error`.

        Raises
        ------
        RadarGuiError
            The source or the disk failed; what was recorded until then is kept, the error says where.
        """
        if n_runs < 1 or self.is_cancelled:
            return
        yield from self._series(1, n_runs) if self.continuous else self._series(n_runs, 1)

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

    def _series(self, n_acquisitions: int, n_runs: int) -> Iterator[RecordedRun]:
        """Record runs, so many from each source; each is processed while the next one is armed."""
        try:
            series = AcquisitionSeries(self, n_acquisitions, n_runs)
        except RadarGuiError as error:
            self.publisher.enter(ExperimentState.FAILED, str(error), error=error)
            raise
        yield from series.runs()
        if series.failure is not None:
            failure = with_place(series.failure, series.failed_file)
            self.publisher.enter(ExperimentState.FAILED, str(failure), error=failure)
            raise failure
