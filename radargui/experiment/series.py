"""A series: runs of one acquisition or several, each processed while the next one is armed."""

import queue
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import KW_ONLY, dataclass
from pathlib import Path

from radargui.acquisition.acquisition import Acquisition
from radargui.acquisition.recorder import Recorder
from radargui.acquisition.run_output import FinishedRun
from radargui.acquisition.run_plan import Ending, RecorderState
from radargui.experiment.event import (
    EventKind,
    ExperimentState,
    Publisher,
    RecordedRun,
    RunningWarnings,
    losses,
    signal_warnings,
)
from radargui.model.errors import RadarGuiError

HEALTH_S = 0.25
"""Between two reports of the health. Chosen by hand."""

_ENTERED = {
    RecorderState.ARMED: (ExperimentState.ARMED, "waiting for the sphere to move"),
    RecorderState.RECORDING: (ExperimentState.RECORDING, "recording"),
    RecorderState.SETTLING: (ExperimentState.SETTLING, "waiting until nothing moves"),
}


Message = RecorderState | FinishedRun | RecordedRun | Callable[[], None] | None
"""What the recorder or the processing says; a report to make; None: the acquisition has ended."""
Messages = queue.SimpleQueue[Message]


@dataclass(eq=False)
class AcquisitionSeries:
    """Follows acquisitions that record runs; reports what happens and hands out runs in order.

    Parameters
    ----------
    acquire
        Makes the next acquisition and its recorder, not started; both put into `messages`.
    n_left
        How many there are at most: none follows one that failed, was stopped, or in which nothing moved.
    messages
        Changes of the recorder, finished runs, the end of the acquisition; processing adds its own.
    publisher
        Its `number` is that of the run before the first.
    process
        Processes a run of an acquisition, in another thread; never raises. None: runs are not processed.
    announce
        Called with a run that waits for its processing; must not take long.
    set_aside
        Rejects a run in the session.
    is_cancelled
        Whether the operator wants nothing more.
    cancel
        Makes it so: of the run that is being processed the preliminary result is kept.
    waits_for_motion
        Whether the recorder waits while it is armed.

    Attributes
    ----------
    failure, failed_file
        What ended the last acquisition, or kept the next one from being made, and the file that was being written.
    """

    acquire: Callable[[], tuple[Acquisition, Recorder]]
    n_left: int
    messages: Messages
    publisher: Publisher
    _: KW_ONLY
    process: Callable[[Acquisition, FinishedRun, int], RecordedRun] | None
    announce: Callable[[Acquisition, FinishedRun, int], None]
    set_aside: Callable[[FinishedRun], None]
    is_cancelled: Callable[[], bool]
    cancel: Callable[[], None]
    waits_for_motion: bool

    def __post_init__(self) -> None:
        self._warnings = RunningWarnings()
        self._n_processing = 0
        self._next_number = self.publisher.number + 1
        self._outcomes: dict[int, RecordedRun] = {}
        self.failure: RadarGuiError | None = None
        self.failed_file: Path | None = None
        self._begin()

    def _begin(self) -> None:
        """Make the next acquisition."""
        self.publisher.number += 1
        self._base = self.publisher.number - 1
        self._held: FinishedRun | None = None
        self._last_number: int | None = None
        self._ended = False
        self.n_left -= 1
        self._acquisition, self._recorder = self.acquire()

    def runs(self) -> Iterator[RecordedRun]:
        """Start, and yield runs until the last acquisition has ended and all are processed."""
        self._acquisition.start()
        try:
            # one thread: runs are processed one after the other
            with ThreadPoolExecutor(1, "experiment-processing") as jobs:
                try:
                    while not self._ended or self._n_processing:
                        self._take(self._next(), jobs)
                        yield from self._in_order()
                except BaseException:
                    # Ctrl-C, or whoever asked for the runs has left: nobody waits for what is being computed
                    self.cancel()
                    raise
        finally:
            self._acquisition.stop()

    def _next(self) -> Message:
        """Return the next message; report the health while there is none."""
        while True:
            try:
                return self.messages.get(timeout=HEALTH_S)
            except queue.Empty:
                if self._ended:
                    continue
                if self._acquisition.wait(0.0):
                    # stopped before it had begun: then nobody reports it
                    return None
                health = self._acquisition.health
                self.publisher.report(EventKind.HEALTH, health.line(), health=health)
                for warning in self._warnings.of(health):
                    self.publisher.report(EventKind.WARNING, warning)
                if self.is_cancelled():
                    self._acquisition.stop()

    def _take(self, message: Message, jobs: ThreadPoolExecutor) -> None:
        match message:
            case RecorderState():
                self._enter_as(message)
            case FinishedRun():
                self._finished(message, jobs)
            case RecordedRun():
                self._n_processing -= 1
                self._outcomes[message.number] = message
            case None:
                self._end(jobs)
            case report:
                report()

    def _in_order(self) -> Iterator[RecordedRun]:
        """Yield what came of runs, none before those of lower number, the last one when all is over."""
        while (run := self._outcomes.get(self._next_number)) is not None:
            if run.number == self._last_number and not self._ended:
                return
            del self._outcomes[self._next_number]
            self._next_number += 1
            yield self._published(run, is_last=self._ended and not self._n_processing and not self._outcomes)

    def _enter_as(self, state: RecorderState) -> None:
        if state in _ENTERED and (self.waits_for_motion or state is not RecorderState.ARMED):
            self.publisher.enter(*_ENTERED[state])

    def _finished(self, run: FinishedRun, jobs: ThreadPoolExecutor) -> None:
        number = self._base + run.number
        if run.is_last:
            self._last_number = number
        else:
            self.publisher.number = number + 1
        if run.ending is Ending.FAILED:
            return
        for warning in signal_warnings(run):
            self.publisher.report(EventKind.WARNING, warning, number=number, topic="signal")
        if run.set_aside:
            self.set_aside(run)
        self.publisher.report(EventKind.RECORDED, run=unprocessed(run, number))
        if run.set_aside or self.process is None or self.is_cancelled():
            self._outcomes[number] = unprocessed(run, number)
        elif run.is_last:
            # the processing of the last one can wait until all else is done
            self._held = run
        else:
            self._submit(self._acquisition, run, number, jobs)

    def _end(self, jobs: ThreadPoolExecutor) -> None:
        """See to the end of an acquisition: the next one begins, or this was the last."""
        self._acquisition.stop()
        self._warn()
        self._ended = True
        self.failure, self.failed_file = self._acquisition.error, self._recorder.path
        held, base = self._held, self._base
        last = self._acquisition
        if self._is_followed():
            self._follow()
        if self._ended and (held is not None or self._n_processing):
            self.publisher.enter(ExperimentState.PROCESSING, "processing")
        if held is not None:
            self._submit(last, held, base + held.number, jobs)
        if self._ended and self._last_number is None and self.failure is None:
            ending = self._recorder.ending or Ending.STOPPED
            message = f"No run was recorded: {ending.value}."
            number = self.publisher.number
            self._outcomes[number] = RecordedRun(number, None, None, ending, message)

    def _is_followed(self) -> bool:
        """Return whether another acquisition comes after the one that has ended."""
        if self.n_left == 0 or self.is_cancelled():
            return False
        recorded = self._last_number is not None and self.failure is None
        return recorded and self._recorder.ending is not Ending.STOPPED

    def _follow(self) -> None:
        try:
            self._begin()
        except RadarGuiError as error:
            # reported after the results of the runs before
            self._ended = True
            self.failure, self.failed_file = error, None
        else:
            self._acquisition.start()

    def _submit(self, acquisition: Acquisition, run: FinishedRun, number: int, jobs: ThreadPoolExecutor) -> None:
        if self._n_processing:
            self.announce(acquisition, run, number)
        self._n_processing += 1
        jobs.submit(self._work, acquisition, run, number)

    def _work(self, acquisition: Acquisition, run: FinishedRun, number: int) -> None:
        if self.process is not None:
            self.messages.put(self.process(acquisition, run, number))

    def _published(self, run: RecordedRun, *, is_last: bool) -> RecordedRun:
        if run.result is not None:
            for warning in run.result.warnings:
                self.publisher.report(EventKind.WARNING, warning, number=run.number)
        if is_last and run.error is not None:
            self.publisher.enter(ExperimentState.FAILED, run.message, error=run.error)
        elif is_last:
            self.publisher.enter(ExperimentState.DONE if run.path else ExperimentState.IDLE, run.message)
        self.publisher.report(EventKind.RUN, run=run)
        return run

    def _warn(self) -> None:
        health = self._acquisition.health
        for warning in (*self._warnings.of(health), *losses(health)):
            self.publisher.report(EventKind.WARNING, warning)
        if health.live_error is not None:
            self.publisher.report(EventKind.WARNING, str(health.live_error), error=health.live_error)
        self.publisher.report(EventKind.HEALTH, health.line(), health=health)


def unprocessed(run: FinishedRun, number: int) -> RecordedRun:
    """Return what came of a run that is kept as it is."""
    said = f"set aside, {run.set_aside}" if run.set_aside else "recorded, not processed."
    message = f"{run.path.name}: {said}"
    return RecordedRun(number, run.path, None, run.ending, message, set_aside=run.set_aside, health=run.health)
