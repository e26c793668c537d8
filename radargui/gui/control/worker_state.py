"""How far the worker of a recording or live view is, and what it is asked: one object behind one lock."""

import threading
from dataclasses import dataclass, replace
from enum import IntEnum
from typing import Any

from radargui.acquisition.acquisition import Acquisition
from radargui.acquisition.health import Health
from radargui.acquisition.run_plan import RecorderState
from radargui.experiment.event import ExperimentState
from radargui.experiment.experiment import Experiment
from radargui.gui.control.app_state import AppState
from radargui.model.daq import Daq
from radargui.sources.contract import Source

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


@dataclass(frozen=True, slots=True)
class Reached:
    """What the worker has made so far.

    Attributes
    ----------
    source
        The newest one; asked only what it answers at once.
    live
        The acquisition of a live view; None while runs are recorded.
    experiment
        What records; None in a live view.
    health
        Newest snapshot.
    progress
        Share of the present run's processing that is done.
    run_number
        The run that is armed or recorded, from 1.
    asked
        What the window wants of the worker.
    """

    source: Source | None = None
    live: Acquisition | None = None
    experiment: Experiment | None = None
    health: Health | None = None
    progress: float = 0.0
    run_number: int = 1
    asked: Asked = Asked.NOTHING

    @property
    def acquisition(self) -> Acquisition | None:
        """What samples come through now."""
        return self.live if self.experiment is None else self.experiment.acquisition

    @property
    def records(self) -> AppState:
        """What the recorder does; PROCESSING where it has ended."""
        recorder = self.acquisition.recorder if self.acquisition is not None else None
        return AppState.STARTING if recorder is None else _RECORDING.get(recorder.state, AppState.PROCESSING)

    @property
    def only_processes(self) -> bool:
        """Whether nothing is recorded any more."""
        return self.experiment is not None and self.experiment.state is ExperimentState.PROCESSING


class WorkerState:
    """Written by the worker, asked by the window; one for each worker, so that a late one writes to its own."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._reached = Reached()

    @property
    def reached(self) -> Reached:
        """All that is known at one instant."""
        with self._lock:
            return self._reached

    def put(self, **changes: Any) -> None:
        """Take new values of `Reached`."""
        with self._lock:
            self._reached = replace(self._reached, **changes)

    @property
    def stops(self) -> bool:
        """Whether the worker is asked to end."""
        return self.reached.asked > Asked.NOTHING

    @property
    def leaves(self) -> bool:
        """Whether results that are still to come are left for later."""
        return self.reached.asked is Asked.LEAVE

    def ask(self, what: Asked) -> None:
        """Ask the worker to end; what was asked before and goes further stays."""
        with self._lock:
            self._reached = replace(self._reached, asked=max(what, self._reached.asked))

    def end_soon(self, worker: threading.Thread) -> None:
        """Ask whatever runs to end until the worker is gone; a device may take its time to stop: not for the window."""
        # said repeatedly: there may have been nothing to end the first time
        while worker.is_alive():
            reached = self.reached
            if (experiment := reached.experiment) is not None:
                ends = {Asked.FINISH: experiment.finish, Asked.CANCEL: experiment.cancel, Asked.LEAVE: experiment.leave}
                ends[reached.asked]()
            if reached.live is not None:
                reached.live.request_stop()
            worker.join(0.05)


class RestartNews:
    """Says once of each restart of a source that it happened."""

    def __init__(self) -> None:
        self._reported = 0

    def of(self, source: Source) -> str:
        """Return what is to be said of restarts since the last call; empty where there was none."""
        count = source.restarts
        if count <= self._reported:
            return ""
        self._reported = count
        times = "once" if count == 1 else f"{count} times"
        return f"The device failed and was started again, {times} so far. What was lost meanwhile is a gap in the run."


def edge_words(daq: Daq) -> str:
    """Return the edge that a run starts at: `rising edge at PFI0`."""
    level = f" through {daq.start_level_v:g} V" if daq.start == "analog" else ""
    return f"{daq.start_edge} edge{level} at {daq.start_source or 'the start terminal'}"
