"""Start, record, stop: owns the acquisition of the live view and the worker that records runs."""

from __future__ import annotations

import threading
from collections.abc import Callable
from datetime import datetime
from pathlib import Path
from typing import Any

from PySide6.QtCore import QObject, Signal

from radargui.acquisition.acquisition import Acquisition
from radargui.acquisition.health import Health
from radargui.acquisition.state import RecorderState
from radargui.experiment.event import Event, EventKind
from radargui.experiment.experiment import Experiment
from radargui.experiment.recorded_run import RecordedRun
from radargui.experiment.state import ExperimentState
from radargui.gui.control.app_state import AppState
from radargui.gui.control.feed import Feed
from radargui.gui.control.run_request import MakeSource, RunRequest, at_once
from radargui.gui.control.source_watch import SourceWatch
from radargui.gui.mailbox import Mailbox
from radargui.model.setup import Setup
from radargui.processing.live_memory import LiveMemory
from radargui.session.info import calibration_of_file
from radargui.session.session import Session
from radargui.sources.contract import Source
from radargui.sources.factory import SourceKind

__all__ = ["MakeSource", "RunControl", "RunRequest"]

_HEALTH_S = 0.2


class RunControl(QObject):
    """The window's hand on acquisition and experiment.

    Workers never touch a widget: what they have to say waits in a mailbox; `poll`, called by the window's timer,
    looks after everything that changes often.
    """

    state_changed = Signal()
    feed_changed = Signal(object)
    run_preliminary = Signal(object)
    run_recorded = Signal(object)
    session_changed = Signal()
    failed = Signal(object)
    warned = Signal(str)

    def __init__(self, make_source: MakeSource, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._make = make_source
        self._state = AppState.IDLE
        self._acquisition: Acquisition | None = None
        self._experiment: Experiment | None = None
        self._worker: threading.Thread | None = None
        self._stopping = threading.Event()
        self._next: RunRequest | None = None
        self._ticket = 0
        self._pulled: Acquisition | None = None
        self._setup: Setup | None = None
        self._health: Health | None = None
        self._stopper: threading.Thread | None = None
        self._cancel = False
        self.session: Session | None = None
        self.feed: Feed | None = None
        self.run_number = 0
        self.n_runs = 0
        self.waits_for = ""
        self._kept = 0
        self._memory = LiveMemory()
        self._watch: SourceWatch | None = None
        self._continuous = False
        self.progress = 0.0
        self.has_preliminary = False
        self._mailbox = Mailbox(self)

    @property
    def state(self) -> AppState:
        """What is being done."""
        return self._state

    @property
    def health(self) -> Health | None:
        """The newest snapshot of the running acquisition; None where none runs. Taken by its worker, not here."""
        return self._health if self._state.running else None

    @property
    def kept(self) -> int:
        """Runs recorded since Record was asked for, without those that were set aside."""
        return self._kept

    @property
    def recorded_s(self) -> float:
        """Length of the run so far."""
        recorder = self._pulled.recorder if self._pulled is not None else None
        return recorder.count / self.feed.rate_hz if recorder is not None and self.feed is not None else 0.0

    def start_live(
        self,
        setup: Setup,
        kind: SourceKind,
        file: Path | None,
        *,
        make: Callable[[Setup], Source] | None = None,
    ) -> None:
        """Show what the source gives, without recording; `make`: what makes another source instead."""
        if self._state.running:
            return
        self._begin(setup)

        def work(_ticket: int) -> None:
            # to look at the signal nobody waits for an edge
            looked = at_once(setup)
            source = make(looked) if make else self._source(kind, looked, repeat=True, file=file)
            acquisition = Acquisition(source, looked)
            self._acquisition = acquisition
            if self._stopping.is_set():
                acquisition.request_stop()
            acquisition.start()
            while not acquisition.wait(_HEALTH_S):
                # a disk or device that does not answer must not hold up the window: the window never asks them
                self._health = acquisition.health
            acquisition.stop()
            if acquisition.error is not None:
                raise acquisition.error

        self._launch(work, "live view")

    def record(self, request: RunRequest) -> None:
        """Record runs one after the other; the first one makes the session. A live view is ended before."""
        if self._state is AppState.LIVE:
            self.stop()
            self._next = request
            return
        if self._state.running:
            return
        setup = request.setup
        self._begin(setup)
        self.run_number, self.n_runs = 1, request.n_runs
        self._continuous = request.continuous
        session = self.session
        if session is not None and (session.setup != setup or session.read_only):
            session = None

        def work(ticket: int) -> None:
            here = session or Session.create(
                request.data_folder,
                setup,
                operator=request.operator,
                sample=request.sample,
                target=request.target,
                notes=request.notes,
                calibration=calibration_of_file(request.setup_file) if request.setup_file else None,
                setup_name=request.setup_file.stem if request.setup_file else "",
                now=datetime.now().astimezone(),
            )
            if session is None:
                # what the live track learned belongs to one set of antennas and wires
                self._memory = LiveMemory()
                self._mailbox.post(self._on_told, self._set_session, here, ticket)
            done = len(here.run_paths(with_rejected=True))
            experiment = Experiment(
                setup,
                lambda run: self._source(
                    request.kind, setup, run=done + run, repeat=request.continuous, file=request.file
                ),
                here,
                listener=self._hear,
                continuous=request.continuous,
                attributes={"source": request.kind},
                memory=self._memory,
            )
            self._experiment = experiment
            if self._stopping.is_set():
                return
            for recorded in experiment.record(request.n_runs):
                self._mailbox.post(self._on_told, self._recorded, recorded, ticket)

        self._launch(work, "recording")

    def reject(self, run: Path, *, back: bool = False) -> None:
        """Set a run of the session aside, or take it `back`; waits for the disk, from any thread.

        Raises
        ------
        SessionError
            No such run, or the session cannot be written.
        """
        session, experiment = self.session, self._experiment
        if session is None:
            return
        if back:
            session.restore(run)
        elif experiment is not None and self._continuous and self._state.running:
            known = run.name in session.rejected
            experiment.reject(run)
            # another one is recorded in its place, unless that was the last and all is over
            self.n_runs += not known and self._state is not AppState.PROCESSING
        else:
            session.reject(run, "rejected by the operator")

    def stop(self) -> None:
        """End what runs, without waiting: a run under way is kept and processed.

        Asked again, or while there is nothing but processing, that ends too: what stands already is kept.
        """
        if not self._state.running:
            return
        self._next = None
        experiment = self._experiment
        only_processes = experiment is not None and experiment.state is ExperimentState.PROCESSING
        self._cancel = self._stopping.is_set() or only_processes
        self._stopping.set()
        self._enter(AppState.STOPPING)
        self._end_from_aside()

    def stop_and_wait(self, timeout_s: float = 60.0) -> bool:
        """End what runs now, keep what was recorded, and wait until all threads are gone; False where one hangs."""
        self._next = None
        self._cancel = True
        self._stopping.set()
        self._end_from_aside()
        for thread in (self._worker, self._stopper):
            if thread is not None:
                thread.join(timeout_s)
                if thread.is_alive():
                    return False
        self._ticket += 1
        self._finish(AppState.IDLE)
        return True

    def poll(self) -> None:
        """Look what changed; called by the window's timer."""
        if not self._state.running:
            return
        experiment = self._experiment
        acquisition = experiment.acquisition if experiment is not None else self._acquisition
        if acquisition is not None and acquisition is not self._pulled and acquisition.digitisation is not None:
            self._pulled = acquisition
            if self._setup is not None:
                self.feed = Feed(acquisition, self._setup)
                self.feed_changed.emit(self.feed)
        if self._stopping.is_set():
            return
        if self._watch is not None:
            self.waits_for = self._watch.waits_for(self._health)
            if news := self._watch.news():
                self.warned.emit(news)
        if experiment is not None:
            if self._continuous and acquisition is not None and acquisition.recorder is not None:
                self.run_number = min(acquisition.recorder.n_wanted + 1, self.n_runs)
            self._enter(_state_of(acquisition))
        elif self._pulled is not None:
            self._enter(AppState.LIVE)

    def use_session(self, session: Session | None) -> None:
        """Let the next Record add to a session that is there, or make a new one (None)."""
        if not self._state.running:
            self._memory = LiveMemory()
            self._set_session(session)

    def _end_from_aside(self) -> None:
        """Ask the worker to end, from a thread of its own: a device may take its time to stop."""
        worker = self._worker
        if worker is None or (self._stopper is not None and self._stopper.is_alive()):
            return

        def end() -> None:
            # said again and again: there may have been nothing to end the first time
            while worker.is_alive():
                experiment, acquisition = self._experiment, self._acquisition
                if experiment is not None:
                    experiment.cancel() if self._cancel else experiment.finish()
                if acquisition is not None:
                    acquisition.request_stop()
                worker.join(0.05)

        self._stopper = threading.Thread(target=end, name="gui stop", daemon=True)
        self._stopper.start()

    def _begin(self, setup: Setup) -> None:
        self._setup = setup
        self._stopping.clear()
        self._acquisition = self._experiment = self._pulled = self._watch = None
        self._continuous = False
        self.waits_for = ""
        self._next = None
        self._kept = 0
        self._cancel = False
        self._health = None
        self.progress = 0.0
        self.has_preliminary = False
        self._ticket += 1
        self._enter(AppState.STARTING)

    def _source(self, kind: SourceKind, setup: Setup, **options: Any) -> Source:
        source = self._make(kind, setup, **options)
        self._watch = SourceWatch(source, setup.daq, is_device=kind == "ni")
        return source

    def _launch(self, work: Callable[[int], None], what: str) -> None:
        ticket = self._ticket

        def run() -> None:
            try:
                work(ticket)
            except Exception as error:  # noqa: BLE001 - shown to the operator
                self._mailbox.post(self._on_told, self._ended, error, ticket)
            else:
                self._mailbox.post(self._on_told, self._ended, None, ticket)

        self._worker = threading.Thread(target=run, name=f"gui {what}", daemon=True)
        self._worker.start()

    def _hear(self, event: Event) -> None:
        """Take an event of the experiment; in its thread."""
        if event.kind is EventKind.PROGRESS and event.fraction is not None:
            self.progress = event.fraction
        elif event.kind is EventKind.HEALTH:
            self._health = event.health
        elif event.kind is EventKind.STATE and not self._continuous:
            self.run_number = min(event.number, self.n_runs)
        elif event.kind is EventKind.PRELIMINARY:
            self._mailbox.post(self._on_told, self._preliminary, event.run, self._ticket)
        elif event.kind is EventKind.WARNING and event.state is not ExperimentState.PROCESSING:
            # what processing warns of stands with the run's result
            self._mailbox.post(self.warned.emit, event.message)

    def _on_told(self, what: Callable[[Any], None], value: object, ticket: int) -> None:
        if ticket == self._ticket:
            what(value)

    def _set_session(self, session: object) -> None:
        self.session = session if isinstance(session, Session) else None
        self.session_changed.emit()

    def _preliminary(self, recorded: RecordedRun) -> None:
        self.has_preliminary = True
        self.run_preliminary.emit(recorded)

    def _recorded(self, recorded: RecordedRun) -> None:
        self.has_preliminary = False
        counts = recorded.path is not None and not recorded.set_aside
        self._kept += counts
        self.run_recorded.emit(recorded)
        self.progress = 0.0

    def _ended(self, error: object) -> None:
        if self._worker is not None:
            self._worker.join()
        request = self._next
        if error is not None:
            self._finish(AppState.IDLE if self._stopping.is_set() else AppState.FAILED)
            self.failed.emit(error)
        elif request is not None:
            self._finish(AppState.IDLE)
            self.record(request)
        else:
            self._finish(AppState.DONE if self._kept else AppState.IDLE)

    def _finish(self, state: AppState) -> None:
        self._worker = None
        self._acquisition = self._experiment = self._pulled = self._watch = None
        self.waits_for = ""
        self.feed = None
        self.feed_changed.emit(None)
        self._enter(state)

    def _enter(self, state: AppState) -> None:
        if state is not self._state:
            self._state = state
            self.state_changed.emit()


def _state_of(acquisition: Acquisition | None) -> AppState:
    recorder = acquisition.recorder if acquisition is not None else None
    if recorder is None:
        return AppState.STARTING
    match recorder.state:
        case RecorderState.IDLE:
            return AppState.STARTING
        case RecorderState.ARMED:
            return AppState.ARMED
        case RecorderState.RECORDING:
            return AppState.RECORDING
        case RecorderState.SETTLING:
            return AppState.SETTLING
        case _:
            return AppState.PROCESSING
