"""What an experiment tells while it runs: frozen values for the window and the command line."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from radargui.acquisition.health import Health
from radargui.experiment.recorded_run import RecordedRun
from radargui.experiment.state import ExperimentState
from radargui.model.errors import RadarGuiError


class EventKind(Enum):
    """What an event is about."""

    STATE = "state"
    HEALTH = "health"
    PROGRESS = "progress"
    WARNING = "warning"
    PRELIMINARY = "preliminary"
    RUN = "run"


@dataclass(frozen=True, slots=True)
class Event:
    """One thing that happened.

    Attributes
    ----------
    kind
        STATE: `state` has changed; HEALTH: `health` is new; PROGRESS: of processing, `fraction` from 0 to 1; WARNING:
        `message` is for the operator; PRELIMINARY: what `run` gives so far, its final result will follow; RUN: `run` is
        finished.
    state
        Where the experiment is.
    number
        Of the run, counted from 1.
    message
        One sentence for the operator; may be empty.
    fraction, health, run, error
        As `kind` says; `error` beside a change to FAILED.
    """

    kind: EventKind
    state: ExperimentState
    number: int
    message: str = ""
    fraction: float | None = None
    health: Health | None = None
    run: RecordedRun | None = None
    error: RadarGuiError | None = None
