"""Acquire samples: one thread reads the source, one records, one makes the live track; none waits for another."""

import threading
from collections.abc import Callable
from dataclasses import replace
from datetime import datetime
from functools import partial

from radargui.acquisition.health import Health, Status, health_record, snapshot
from radargui.acquisition.recorder import Recorder
from radargui.acquisition.ring import Ring
from radargui.acquisition.run_output import RunOutput
from radargui.acquisition.run_plan import AcquisitionState, Ending
from radargui.acquisition.stream import BlockQueue, LiveWorker, MakeProcessor, Peaks, Stream
from radargui.live.processor import LiveProcessor
from radargui.live.track import LiveTrack
from radargui.model.errors import RadarGuiError, SourceError, attempt
from radargui.model.recording import Digitisation
from radargui.model.setup import Setup
from radargui.sources.contract import SYSTEM_CLOCK, Source
from radargui.system.cores import one_blas_thread

_LONGEST_STOP_S = 60.0
"""A driver that hangs in a read or a network disk in a write; chosen by hand."""


class Acquisition:
    """Samples from one source into the ring, the run file and the live track, from `start` until `stop`.

    The reader's thread opens the source, starts it, reads until the end, and ends everything else; so `start` returns
    at once, and a source that cannot be opened shows in `error`. An acquisition is used once.

    Parameters
    ----------
    source
        Not opened yet; it is always stopped and closed.
    setup
        For the length of the writer's queue (`daq.buffer_s`) and the live track.
    ring_s
        Seconds that the ring holds; the live track holds a whole run, if that is longer.
    recorder
        Records a run; when it is done the acquisition stops. None: nothing is recorded.
    live
        Whether to make a live track.
    patient
        Whether the reader waits for the recorder instead of losing samples where that is too slow: for a source that
        loses nothing meanwhile, such as a simulation that is as fast as asked.
    on_end
        Called once at the end, in the reader's thread.
    make_processor
        Makes the live processor.

    Attributes
    ----------
    recorder
        What records; None where nothing is recorded.
    """

    def __init__(
        self,
        source: Source,
        setup: Setup,
        *,
        ring_s: float = 10.0,
        recorder: Recorder | None = None,
        live: bool = True,
        patient: bool = False,
        on_end: Callable[[], None] | None = None,
        make_processor: MakeProcessor = LiveProcessor,
    ) -> None:
        self._source = source
        self.recorder = recorder
        self._make_stream = partial(
            Stream,
            setup=setup,
            ring_s=ring_s,
            records=recorder is not None,
            make_processor=make_processor if live else None,
            clock=SYSTEM_CLOCK,
            patient=patient,
        )
        self._on_end = on_end
        # written under the lock, read as it is
        self._lock = threading.RLock()
        self._status = Status()
        self._done = threading.Event()
        self._reader: threading.Thread | None = None
        self._others: list[threading.Thread] = []

    @property
    def state(self) -> AcquisitionState:
        """Where the acquisition is."""
        return self._status.state

    @property
    def error(self) -> RadarGuiError | None:
        """Why it failed; None while all is well."""
        return self._status.error

    @property
    def digitisation(self) -> Digitisation | None:
        """How samples are digitised; None before the source is open."""
        return stream.digitisation if (stream := self._status.stream) else None

    @property
    def ring(self) -> Ring | None:
        """The last seconds of samples, to pull from; None before the source is open."""
        return stream.ring if (stream := self._status.stream) else None

    @property
    def live(self) -> LiveTrack | None:
        """The last seconds of live estimates, to pull from; None before the source is open or without live track."""
        return stream.track if (stream := self._status.stream) else None

    @property
    def health(self) -> Health:
        """A snapshot; made in the caller's thread."""
        return snapshot(self._status, self.recorder)

    def start(self) -> None:
        """Open the source and begin, in the reader's thread; idempotent, and without effect after `stop`."""
        with self._lock:
            if self.state is not AcquisitionState.IDLE:
                return
            self._status = replace(self._status, state=AcquisitionState.OPENING)
            # daemon: a driver that hangs must not keep the program from ending
            self._reader = threading.Thread(target=self._run, name="acquisition-reader", daemon=True)
            self._reader.start()

    def request_stop(self) -> None:
        """Let the acquisition end soon, without waiting for it; from any thread, any number of times."""
        self._stop_soon(Ending.STOPPED)

    def stop(self, timeout_s: float = _LONGEST_STOP_S) -> None:
        """End the acquisition and wait until all threads are gone; from any thread, any number of times.

        What was read is recorded first. Where the source or the disk does not answer for `timeout_s`, `error` says so.
        """
        self.request_stop()
        reader = self._reader
        if reader is None or threading.current_thread() in (reader, *self._others):
            return
        reader.join(timeout_s)
        if reader.is_alive():
            self._fail(SourceError(f"The acquisition did not end within {timeout_s:g} s: source or disk do not answer"))

    def wait(self, timeout_s: float | None = None) -> bool:
        """Wait for the end; True where it has come and nothing more will be written."""
        return self._done.wait(timeout_s)

    def _run(self) -> None:
        """Do the reader's whole life."""
        # the small matrices of the live track take thirty times as long with threads of their own on a busy computer
        with one_blas_thread():
            self._fail(attempt(self._open_and_read, "Reading the source"))
            self._end()
        self._done.set()

    def _open_and_read(self) -> None:
        stream = self._make_stream(self._source.open())
        with self._lock:
            self._status = replace(self._status, stream=stream)
        if not self._begin(stream):
            return
        while self._status.ending is None and (block := self._source.read()) is not None:
            stream.take(block)
            if stream.reading.backlog_is_due():
                stream.reading.backlog = self._source.backlog()

    def _begin(self, stream: Stream) -> bool:
        if self.recorder is not None:
            self.recorder.health_of_run = lambda run: self._health_of_run(stream, run)
            self.recorder.prepare(stream.digitisation, datetime.now().astimezone(), self._source.truth)
        with self._lock:
            # Under the lock, so that nobody stops the source between the question and the start.
            if self._status.ending is not None:
                return False
            self._source.start()
            self._status = replace(self._status, state=AcquisitionState.RUNNING)
        if self.recorder is not None and stream.queue is not None:
            self._run_beside(partial(self._record, stream, self.recorder, stream.queue), "acquisition-recorder")
        if stream.worker is not None:
            self._run_beside(partial(self._estimate, stream.worker), "acquisition-live")
        return True

    def _run_beside(self, work: Callable[[], None], name: str) -> None:
        thread = threading.Thread(target=work, name=name, daemon=True)
        self._others.append(thread)
        thread.start()

    def _record(self, stream: Stream, recorder: Recorder, queue: BlockQueue) -> None:
        def push_all() -> None:
            armed_at = None
            while not recorder.is_done and (block := queue.get()) is not None:
                recorder.push(block)
                if (index := recorder.armed_again_at) is not None and index != armed_at:
                    # the health record of the next run begins
                    armed_at = index
                    stream.peaks = Peaks()
                    if stream.worker is not None:
                        # after a drop it lies wherever it fell, and is followed on
                        hung = recorder.hung_up_at == index
                        (stream.worker.at_release if hung else stream.worker.fallen)(index)
            recorder.finish(self._ending())

        self._fail(attempt(push_all, "Recording"))
        # after a failure the file is closed with what it holds; after a good end this does nothing
        recorder.fail()
        queue.close()
        queue.clear()
        self._stop_soon()

    def _health_of_run(self, stream: Stream, run: RunOutput) -> dict[str, object]:
        health = self.health
        # an acquisition may record many runs: what is said of one is its own
        own = replace(health, samples_read=run.count, samples_lost=run.lost)
        return {**health_record(health, stream.peaks), "line": own.line()}

    def _estimate(self, worker: LiveWorker) -> None:
        error = attempt(worker.run, "The live track")
        with self._lock:
            self._status = replace(self._status, live_error=error)
        # A run that is being recorded cannot be repeated: it goes on without a live track.
        if self.recorder is None:
            self._fail(error)

    def _end(self) -> None:
        with self._lock:
            status = self._status = replace(self._status, state=AcquisitionState.STOPPING)
        self._guarded(self._source.stop, "Stopping the source")
        if status.stream is not None:
            status.stream.close()
        for thread in self._others:
            thread.join()
        recorder = self.recorder
        if recorder is not None:
            self._guarded(lambda: recorder.finish(self._ending()), "Finishing the run")
        self._guarded(self._source.close, "Closing the source")
        with self._lock:
            # who gives up waiting may tell an error meanwhile
            state = AcquisitionState.STOPPED if self.error is None else AcquisitionState.FAILED
            self._status = replace(self._status, state=state)
        if self._on_end is not None:
            self._guarded(self._on_end, "Telling the end")

    def _ending(self) -> Ending:
        status = self._status
        return Ending.FAILED if status.error is not None else status.ending or Ending.END_OF_DATA

    def _fail(self, error: RadarGuiError | None) -> None:
        if error is None:
            return
        self._note(error)
        self._stop_soon()

    def _note(self, error: RadarGuiError | None) -> None:
        with self._lock:
            # the first failure is the cause, later ones follow from it
            self._status = replace(self._status, error=self.error or error)

    def _stop_soon(self, why: Ending = Ending.END_OF_DATA) -> None:
        with self._lock:
            self._status = replace(self._status, ending=self._status.ending or why)
            if self.state is AcquisitionState.IDLE:
                self._status = replace(self._status, state=AcquisitionState.STOPPED)
                self._done.set()
            if self.state is AcquisitionState.RUNNING:
                self._guarded(self._source.stop, "Stopping the source")

    def _guarded(self, step: Callable[[], None], what: str) -> None:
        """Do a step of ending; its failure is reported but does not keep the next step from being done."""
        self._note(attempt(step, what))
