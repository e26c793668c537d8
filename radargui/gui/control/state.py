"""What the program is doing: what Record was asked for, how far its worker is, what the screen pulls from it."""

import threading
from collections.abc import Iterable
from dataclasses import dataclass, field
from enum import Enum, IntEnum
from pathlib import Path
from typing import NamedTuple, Protocol

from radargui.acquisition.acquisition import Acquisition
from radargui.acquisition.health import Health
from radargui.acquisition.ring import Ring
from radargui.acquisition.run_plan import RecorderState
from radargui.experiment.event import ExperimentState, RecordedRun
from radargui.experiment.series import Experiment
from radargui.live.track import LiveTrack
from radargui.model.drop import RunOrigin
from radargui.model.recording import Digitisation
from radargui.model.setup import Setup
from radargui.session.info import SessionDetails, about_setup_file
from radargui.sources.contract import Source
from radargui.sources.factory import SourceKind


class AppState(Enum):
    """The state shown in large letters; the value is the word shown.

    Attributes
    ----------
    role
        Its colour.
    next
        What the operator does now; armed and failed say more.
    """

    role: str
    next: str

    IDLE = "IDLE", "idle", "Press R to record, Space to look at the signal"
    STARTING = "STARTING", "busy", "Wait: the source starts"
    LIVE = "LIVE", "busy", "Press R to record"
    ARMED = "ARMED", "mark", "Let the sphere drop"
    RECORDING = "RECORDING", "alarm", "Hands off: this is being recorded"
    SETTLING = "SETTLING", "busy", "Hands off until nothing moves"
    PROCESSING = "PROCESSING", "busy", "The result is being computed"
    STOPPING = "STOPPING", "busy", "Wait: what runs is being ended"
    DONE = "DONE", "good", "Hang the sphere up again, then press R"
    FAILED = "FAILED", "alarm", "Press R to try again"

    def __new__(cls, word: str, role: str, then: str) -> "AppState":
        """Return a state whose value is its word alone."""
        made = object.__new__(cls)
        made._value_, made.role, made.next = word, role, then
        return made

    @property
    def running(self) -> bool:
        """Whether samples come in or are worked on."""
        return self not in (AppState.IDLE, AppState.DONE, AppState.FAILED)

    @property
    def may_record(self) -> bool:
        """Whether Record may be asked for: also while former runs are only computed."""
        return not self.running or self in (AppState.LIVE, AppState.PROCESSING)

    @property
    def holds_a_run(self) -> bool:
        """Whether stopping now would cut a run off."""
        return self in (AppState.RECORDING, AppState.PROCESSING)


class RunWord(Enum):
    """What has become of a run, in large letters where nothing runs; the value is the word shown."""

    FINAL = "FINAL"
    PRELIMINARY = "PRELIMINARY"
    REJECTED = "REJECTED"
    NO_E = "NO e"
    NOT_COMPUTED = "NOT COMPUTED"


NOT_RECORDED = "NOT RECORDED"
"""Stands in place of a result while samples are only looked at."""
LARGE_WORDS = (*(state.value for state in AppState), *(word.value for word in RunWord))
"""All that is written in the letters of the state: the longest says how large they are."""


class Feed:
    """One acquisition under its setup, as panels see it.

    Parameters
    ----------
    ring, digitisation
        The last seconds of samples, and how they are digitised.
    live
        The last seconds of live estimates; None without live track.
    setup
        Under which it runs.
    """

    def __init__(self, ring: Ring, digitisation: Digitisation, live: LiveTrack | None, setup: Setup) -> None:
        self.ring, self.digitisation, self.live, self.setup = ring, digitisation, live, setup
        self.n_receivers, self.rate_hz = digitisation.n_receivers, digitisation.sample_rate_hz

    def samples(self, seconds: float) -> int:
        """Return how many samples so many seconds are."""
        return max(1, round(seconds * self.rate_hz))


_FALLING = ("drop", "bed")
"""Simulated scenes that, begun again and again, give one fall after the other."""


class MakeSource(Protocol):
    """Makes a source; `sources.factory.make_source` is one."""

    def __call__(
        self, kind: SourceKind, setup: Setup, *, run: int = 0, repeat: bool = False, file: Path | None = None
    ) -> Source:
        """Return a source, not yet open."""


class Details(NamedTuple):
    """What the operator says of a session."""

    operator: str
    notes: str
    sample: str = ""
    target: str = ""


@dataclass(frozen=True, slots=True)
class RunRequest:
    """What Record was asked for."""

    setup: Setup
    kind: SourceKind
    file: Path | None
    n_runs: int
    data_folder: Path
    details: Details
    setup_file: Path | None = None
    is_edited: bool = False

    @property
    def about(self) -> SessionDetails:
        """What is said of a session that is made for it."""
        said, file = self.details, about_setup_file(self.setup_file, is_edited=self.is_edited)
        own = SessionDetails(operator=said.operator, notes=said.notes, sample=said.sample, target=said.target)
        return own | file

    @property
    def continuous(self) -> bool:
        """Whether one source serves all runs: a device that starts at once, a simulated fall that is repeated."""
        if self.kind == "ni":
            return self.setup.daq.start == "now"
        return self.kind == "simulated" and self.n_runs > 1 and self.setup.simulation.scene in _FALLING


class Backlog(list[Path]):
    """What was recorded since Record was asked for and has no result yet; results come in the order of the runs."""

    last_recorded: Path | None = None

    def __init__(self, waiting: Iterable[Path] = ()) -> None:
        super().__init__(waiting)
        self._numbers: dict[Path, int] = {}

    @property
    def number(self) -> int:
        """The number of the run whose result is computed now; 0 where none waits."""
        return self._numbers[self[0]] if self else 0

    @property
    def computed(self) -> Path | None:
        """The run whose result is computed now; None where none waits."""
        return next(iter(self), None)

    def take(self, run: RecordedRun) -> None:
        """Take a run that is on the disk; one that was set aside gets no result."""
        if run.path is not None and not run.set_aside:
            self.append(run.path)
            self._numbers[run.path] = run.number
            self.last_recorded = run.path


_RECORDING = {
    RecorderState.IDLE: AppState.STARTING,
    RecorderState.ARMED: AppState.ARMED,
    RecorderState.RECORDING: AppState.RECORDING,
    RecorderState.SETTLING: AppState.SETTLING,
}


class Asked(IntEnum):
    """What the window wants of a worker; each goes further than the one before."""

    NOTHING = 0
    FINISH = 1
    """End what is recorded, compute what is there."""
    CANCEL = 2
    """End also what is only being computed; what stands already is kept."""
    LEAVE = 3
    """And leave for later what waits to be computed."""


@dataclass(eq=False)
class WorkerState:
    """What the worker has made so far, and what is wanted of it; one for each worker: a late one writes to its own.

    Each value is put there by one thread and as a whole, which needs no lock; whoever asks for one twice takes it once.

    Attributes
    ----------
    source
        The newest one; asked only what it answers at once.
    live
        The acquisition of a live view; None while runs are recorded.
    experiment
        What records; None in a live view.
    origin
        Where the samples come from; None until that is looked up.
    health
        Newest snapshot.
    progress
        Share of each run's processing that is done, by its number: the next one begins before the window has taken
        the result of the one before.
    run_number
        The run that is armed or recorded, from 1.
    asked
        What the window wants of the worker.
    """

    source: Source | None = None
    live: Acquisition | None = None
    experiment: Experiment | None = None
    origin: RunOrigin | None = None
    health: Health | None = None
    progress: dict[int, float] = field(default_factory=dict)
    run_number: int = 1
    asked: Asked = Asked.NOTHING

    @property
    def acquisition(self) -> Acquisition | None:
        """What samples come through now."""
        experiment = self.experiment
        return self.live if experiment is None else experiment.acquisition

    @property
    def records(self) -> AppState:
        """What the recorder does; where it has ended PROCESSING, or STOPPING where there is nothing to process."""
        acquisition = self.acquisition
        recorder = acquisition.recorder if acquisition is not None else None
        if recorder is None:
            return AppState.STARTING
        # a device that is not there ends before any run began
        is_empty = recorder.path is None and not self.only_processes
        return _RECORDING.get(recorder.state, AppState.STOPPING if is_empty else AppState.PROCESSING)

    @property
    def only_processes(self) -> bool:
        """Whether nothing is recorded any more."""
        experiment = self.experiment
        return experiment is not None and experiment.state is ExperimentState.PROCESSING

    @property
    def stops(self) -> bool:
        """Whether the worker is asked to end."""
        return self.asked > Asked.NOTHING

    def end_soon(self, worker: threading.Thread) -> None:
        """Ask whatever runs to end until the worker is gone; a device may take its time to stop: not for the window."""
        # said repeatedly: there may have been nothing to end the first time
        while worker.is_alive():
            if (experiment := self.experiment) is not None:
                ends = {Asked.FINISH: experiment.finish, Asked.CANCEL: experiment.cancel, Asked.LEAVE: experiment.leave}
                ends[self.asked]()
            if (live := self.live) is not None:
                live.request_stop()
            worker.join(0.05)
