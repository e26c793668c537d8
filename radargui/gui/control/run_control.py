"""Start, record, stop: owns the acquisition of the live view and the worker that records runs."""

import threading
from collections.abc import Callable
from contextlib import suppress
from datetime import datetime
from functools import partial
from pathlib import Path

from PySide6.QtCore import QObject, Signal

from radargui.acquisition.acquisition import Acquisition
from radargui.acquisition.health import Health
from radargui.experiment.awake import kept_awake
from radargui.experiment.event import Event, EventKind, ExperimentState, RecordedRun
from radargui.experiment.processing_apart import ProcessingApart
from radargui.experiment.series import Experiment
from radargui.files.run_card import RunCard, origin_attributes, origin_of_source, read_run_card
from radargui.gui.background import Mailbox
from radargui.gui.control.state import AppState, Asked, Backlog, Feed, MakeSource, RunRequest, WorkerState
from radargui.live.processor import LiveMemory
from radargui.model.daq import Daq
from radargui.model.errors import RadarGuiError, SourceError
from radargui.model.result import Bounce
from radargui.model.setup import Setup
from radargui.model.words import percent
from radargui.session.session import BY_OPERATOR, Session
from radargui.sources.contract import Source
from radargui.sources.factory import SourceKind, at_once

HEALTH_S = 0.2
"""Between two snapshots that are taken, and shown: figures that change more often cannot be read."""


class RunControl(QObject):
    """The window's hand on acquisition and experiment.

    Workers never touch a widget, nor this object: what they have reached stands in a `WorkerState`, what they have to
    say waits in a mailbox; `poll`, called by the window's timer, looks after everything that changes often.
    """

    state_changed = Signal()
    feed_changed = Signal(object)
    bounced = Signal()
    run_taken = Signal(object, object)
    run_preliminary = Signal(object)
    run_recorded = Signal(object)
    session_changed = Signal()
    failed = Signal(object)
    warned = Signal(str, str)
    left = Signal(object)
    """Runs whose results were still to come as another recording was asked for: they are to be computed beside it."""

    def __init__(self, make_source: MakeSource, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._make = make_source
        self.state = AppState.IDLE
        self._worker: threading.Thread | None = None
        self._stopper: threading.Thread | None = None
        self._setup: Setup | None = None
        self._memory = LiveMemory()
        self.session: Session | None = None
        self.feed: Feed | None = None
        self.run_number = self.n_runs = 0
        self.processing: Callable[[], ProcessingApart] | None = None
        """Makes what processes the runs, as of `Experiment`."""
        self.kind: SourceKind | None = None
        self.is_reviewed = False
        """Whether the session was opened and not made here: nobody has said yet that runs are to be added to it."""
        self.had_source = False
        """Whether what failed last had a source by then: else it could not be made, a file not be read."""
        self._mailbox = Mailbox(self)
        self._begin(None)

    def _begin(self, setup: Setup | None) -> None:
        """Forget what Record or Start was asked for before."""
        self._setup, self.reached = setup, WorkerState()
        self._pulled: Acquisition | None = None
        self._next: RunRequest | None = None
        self._left: tuple[Path, ...] = ()
        self._restarts, self._continuous, self.waits_for = 0, False, ""
        self.backlog = Backlog()
        self.kept = 0
        """Runs recorded since Record was asked for, without those that were set aside."""
        self.ended_by_hand = False
        """Whether the operator ended what was to be recorded before any run was kept."""
        self.live_bounce: Bounce | None = None
        """The first bounce of the run under way, as the live track sees it; None until it does."""

    @property
    def health(self) -> Health | None:
        """The newest snapshot of the running acquisition; None where none runs. Taken by its worker, not here."""
        reached = self.reached
        return reached.health if self.state.running and not reached.only_processes else None

    @property
    def recorded_s(self) -> float:
        """Length of the run so far."""
        recorder = self._pulled.recorder if self._pulled is not None else None
        return recorder.count / self.feed.rate_hz if recorder is not None and self.feed is not None else 0.0

    @property
    def progress(self) -> float:
        """Share that is done of the run whose result is computed now."""
        return self.reached.progress.get(self.backlog.number, 0.0)

    @property
    def unfinished(self) -> str:
        """What has still to end before the program can, in words; empty where nothing runs."""
        threads = (self._worker, self._stopper)
        if not any(thread is not None and thread.is_alive() for thread in threads):
            return ""
        reached = self.reached
        if reached.experiment is None:
            return "the source to stop"
        if not (reached.only_processes or reached.records is AppState.PROCESSING):
            return "the end of the recording"
        runs = "the result of the last run" if len(self.backlog) < 2 else f"the results of {len(self.backlog)} runs"
        return f"{runs} ({percent(self.progress)} of one computed)" if self.backlog else runs

    def start_live(
        self, setup: Setup, kind: SourceKind, file: Path | None, *, make: Callable[[Setup], Source] | None = None
    ) -> None:
        """Show what the source gives, without recording; `make`: what makes another source instead."""
        if self.state.running:
            return
        self._begin(setup)
        self.kind = kind

        def work(state: WorkerState) -> None:
            state.origin = origin_of_source(kind, file, setup.daq.device)
            # to look at the signal nobody waits for an edge
            looked = at_once(setup)
            source = make(looked) if make else self._make(kind, looked, repeat=True, file=file)
            acquisition = Acquisition(source, looked)
            state.source, state.live = source, acquisition
            if state.stops:
                acquisition.request_stop()
            acquisition.start()
            while not acquisition.wait(HEALTH_S):
                # a disk or device that does not answer must not hold up the window: the window never asks them
                state.health = acquisition.health
            acquisition.stop()
            if acquisition.error is not None:
                raise acquisition.error

        self._launch(work, "live view")

    def record(self, request: RunRequest) -> None:
        """Record runs one after the other; the first one makes the session.

        A live view is ended before; results that are still to come are left, see `left`.
        """
        if self.state is AppState.LIVE:
            self.stop()
            self._next = request
            return
        if self.state is AppState.PROCESSING:
            self.end(Asked.LEAVE)
            self._next, self._left = request, ()
            return
        if self.state.running:
            return
        setup = request.setup
        self._begin(setup)
        self.run_number, self.n_runs, self.kind = 1, request.n_runs, request.kind
        self._continuous = continuous = request.continuous
        session = self.session
        if session is not None and (session.setup != setup or session.read_only):
            session = None
        if session is None:
            # what the live track learned belongs to one set of antennas and wires
            self._memory = LiveMemory()
        memory, n_runs = self._memory, self.n_runs

        def work(state: WorkerState) -> None:
            state.origin = origin_of_source(request.kind, request.file, setup.daq.device)
            about = request.about | {"source": state.origin.badge}
            here = session or Session.create(request.data_folder, setup, **about, now=datetime.now().astimezone())
            if session is None:
                self._post(state, self._set_session, here)
            done = len(here.run_paths(with_rejected=True))

            def source_of(run: int) -> Source:
                source = self._make(request.kind, setup, run=done + run, repeat=continuous, file=request.file)
                state.source = source
                return source

            experiment = Experiment(
                setup,
                source_of,
                here,
                listener=lambda event: self._hear(event, state, 0 if continuous else n_runs),
                continuous=continuous,
                attributes=origin_attributes(request.kind, request.file, setup.daq.device),
                memory=memory,
                processing=self.processing,
                # a simulation that sleeps loses nothing
                awake=partial(kept_awake, reports=request.kind == "ni"),
            )
            state.experiment = experiment
            if state.stops:
                return
            try:
                for recorded in experiment.record(n_runs):
                    self._post(state, self._recorded, recorded)
            except SourceError:
                # a device that does not start leaves no empty session behind
                if session is None and here.discard_empty():
                    self._post(state, self._set_session, None)
                raise

        self._launch(work, "recording")

    def reject(self, run: Path, reason: str = BY_OPERATOR, *, back: bool = False) -> None:
        """Set a run of the session aside, or take it `back`; waits for the disk, from any thread.

        Raises
        ------
        SessionError
            No such run, or the session cannot be written.
        """
        session, state = self.session, self.reached
        experiment = state.experiment
        if session is None:
            return
        if back:
            session.restore(run)
        elif experiment is not None and self._continuous:
            known = run.name in session.rejected
            experiment.reject(run, reason)
            if not known:
                self._post(state, self._one_more)
        else:
            session.reject(run, reason)

    def stop(self) -> None:
        """End what runs, without waiting: a run under way is kept and processed.

        Asked again, or while there is nothing but processing, that ends too: what stands already is kept.
        """
        again = self.reached.stops or self.reached.only_processes
        self.end(Asked.CANCEL if again else Asked.FINISH)

    def poll(self) -> None:
        """Look what changed; called by the window's timer."""
        setup, reached = self._setup, self.reached
        if setup is None or not self.state.running:
            return
        acquisition = reached.acquisition
        if reached.only_processes:
            # nothing comes in any more: what is shown is not now
            if self.feed is not None:
                self.feed = None
                self.feed_changed.emit(None)
        else:
            self._show_new(setup)
        if self.reached.stops:
            return
        if reached.source is not None:
            self.waits_for = edge_words(setup.daq) if reached.source.is_waiting else ""
            if (count := reached.source.restarts) > self._restarts:
                self._restarts = count
                self.warned.emit(restart_words(count), "restart")
        if reached.experiment is not None:
            self.run_number = reached.run_number
            if self._continuous and acquisition is not None and acquisition.recorder is not None:
                self.run_number = min(acquisition.recorder.n_wanted + 1, self.n_runs)
            self._enter(reached.records)
        elif self._pulled is not None:
            self._enter(AppState.LIVE)

    def _show_new(self, setup: Setup) -> None:
        """Let what comes in now be shown, where that is not yet so."""
        acquisition = self.reached.acquisition
        if acquisition is not None and acquisition is not self._pulled:
            ring, digitisation = acquisition.ring, acquisition.digitisation
            if ring is not None and digitisation is not None:
                self._pulled = acquisition
                self.feed = Feed(ring, digitisation, acquisition.live, setup)
                self.feed_changed.emit(self.feed)

    def use_session(self, session: Session | None, *, reviewed: bool = False) -> None:
        """Let the next Record add to a session that is there, or make a new one (None); what was before is over."""
        if not self.state.running:
            self._memory = LiveMemory()
            self.is_reviewed = reviewed and session is not None
            self.kept = self.run_number = self.n_runs = 0
            self.backlog, self.ended_by_hand = Backlog(), False
            self._set_session(session)
            self._enter(AppState.IDLE)

    def end(self, asked: Asked) -> None:
        """End what runs as far as is asked, without waiting; what was recorded is kept."""
        if not self.state.running:
            return
        self._next = None
        state, worker = self.reached, self._worker
        state.asked = max(asked, state.asked)
        self._enter(AppState.STOPPING)
        if worker is None or (self._stopper is not None and self._stopper.is_alive()):
            return
        self._stopper = threading.Thread(target=state.end_soon, args=(worker,), name="gui stop", daemon=True)
        self._stopper.start()

    def _launch(self, work: Callable[[WorkerState], None], what: str) -> None:
        self._enter(AppState.STARTING)
        state = self.reached

        def run() -> None:
            failure: Exception | None = None
            try:
                work(state)
            except Exception as error:  # noqa: BLE001 - shown to the operator
                failure = error
            self._post(state, self._ended, failure)

        self._worker = threading.Thread(target=run, name=f"gui {what}", daemon=True)
        self._worker.start()

    def _hear(self, event: Event, state: WorkerState, n_runs: int) -> None:
        """Take an event of the experiment, in its thread; `n_runs` is 0 where its events do not number the runs."""
        if event.kind is EventKind.PROGRESS and event.fraction is not None:
            state.progress[event.number] = event.fraction
        elif event.kind is EventKind.HEALTH:
            state.health = event.health
        elif event.kind is EventKind.STATE and n_runs:
            state.run_number = min(event.number, n_runs)
        elif event.kind is EventKind.PRELIMINARY:
            self._post(state, self.run_preliminary.emit, event.run)
        elif event.kind is EventKind.BOUNCE:
            self._post(state, self._bounced, event.bounce)
        elif event.kind is EventKind.RECORDED and event.run is not None:
            self._post(state, self._taken, event.run, card_of(event.run))
        elif event.kind is EventKind.WARNING and event.state is not ExperimentState.PROCESSING:
            # what processing warns of stands with the run's result
            self._post(state, self.warned.emit, event.message, event.topic)

    def _post(self, state: WorkerState, call: Callable[..., None], *values: object) -> None:
        """Let a call be made in the window's thread, unless another worker runs by then; from any thread."""

        def deliver() -> None:
            if state is self.reached:
                call(*values)

        self._mailbox.post(deliver)

    def _set_session(self, session: Session | None) -> None:
        if session is not self.session and self.state.running:
            self.is_reviewed = False
        self.session = session
        self.session_changed.emit()

    def _one_more(self) -> None:
        # another one is recorded in place of a rejected one, unless that was the last and all is over
        self.n_runs += self.state.running and self.state is not AppState.PROCESSING

    def _bounced(self, bounce: Bounce) -> None:
        self.live_bounce = bounce
        self.bounced.emit()

    def _taken(self, run: RecordedRun, card: RunCard) -> None:
        self.backlog.take(run)
        # before the list is longer: what is recorded now is called by the number of the next one
        self.poll()
        self.run_taken.emit(run, card)
        # it stands in the run's own line from now on
        self.live_bounce = None

    def _recorded(self, recorded: RecordedRun) -> None:
        if recorded.path is not None and recorded.path in self.backlog:
            self.backlog.remove(recorded.path)
        counts = recorded.path is not None and not recorded.set_aside
        self.kept += counts
        # the backlog may not have heard of a run yet when Record is pressed: what comes without a result was left
        if self._next is not None and counts and recorded.path and recorded.result is None and recorded.error is None:
            self._left = (*self._left, recorded.path)
        self.run_recorded.emit(recorded)

    def _ended(self, error: BaseException | None) -> None:
        if self._worker is not None:
            self._worker.join()
        request = self._next
        if error is None and self._setup is not None:
            # a short file may end before anybody has looked
            self._show_new(self._setup)
        self.ended_by_hand = self.reached.stops and self.reached.experiment is not None and not self.kept
        self.had_source = self.reached.source is not None
        if error is not None:
            self._finish(AppState.IDLE if self.reached.stops else AppState.FAILED)
            self.failed.emit(error)
        elif request is not None:
            left, self._left = self._left, ()
            self._finish(AppState.IDLE)
            self.record(request)
            if left:
                self.left.emit(left)
        else:
            self._finish(AppState.DONE if self.kept else AppState.IDLE)

    def _finish(self, state: AppState) -> None:
        self._worker = self._pulled = None
        self.waits_for, self.feed = "", None
        self.reached.source = self.reached.live = self.reached.experiment = None
        self.feed_changed.emit(None)
        self._enter(state)

    def _enter(self, state: AppState) -> None:
        if state is not self.state:
            self.state = state
            self.state_changed.emit()


def card_of(run: RecordedRun) -> RunCard:
    """Return what the file of a run says of it; an empty card where it cannot be read."""
    with suppress(RadarGuiError):
        return RunCard() if run.path is None else read_run_card(run.path)
    return RunCard()


def restart_words(count: int) -> str:
    """Return what is to be said where a device was started again, so many times."""
    times = "once" if count == 1 else f"{count} times"
    return f"The device failed and was started again, {times} so far. What was lost meanwhile is a gap in the run."


def edge_words(daq: Daq) -> str:
    """Return the edge that a run starts at: `rising edge at PFI0`."""
    level = f" through {daq.start_level_v:g} V" if daq.start == "analog" else ""
    return f"{daq.start_edge} edge{level} at {daq.start_source or 'the start terminal'}"
