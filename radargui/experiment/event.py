"""What an experiment tells while it runs: frozen values for the window and the command line."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from pathlib import Path

from radargui.acquisition.health import Health
from radargui.acquisition.state import Ending
from radargui.experiment.live_agreement import LiveAgreement
from radargui.model.errors import RadarGuiError
from radargui.model.result import RunResult


class ExperimentState(Enum):
    """Where an experiment is."""

    IDLE = "idle"
    ARMED = "armed"
    RECORDING = "recording"
    SETTLING = "settling"
    PROCESSING = "processing"
    DONE = "done"
    FAILED = "failed"


@dataclass(frozen=True, slots=True)
class RecordedRun:
    """What came of one run.

    Attributes
    ----------
    number
        Counted from 1 within the experiment.
    path
        Its file; None where nothing was recorded.
    result
        None where it was not processed.
    ending
        Why the recording ended.
    message
        What came of it, one sentence.
    error
        Why processing failed; the recording is safe.
    set_aside
        Why the run was rejected by itself, in a series; empty where it counts.
    agreement
        How far the live track was from the result; None where there was none to compare.
    health
        How the recording went, as it is in the file.
    """

    number: int
    path: Path | None
    result: RunResult | None
    ending: Ending
    message: str
    error: RadarGuiError | None = None
    set_aside: str = ""
    agreement: LiveAgreement | None = None
    health: Mapping[str, object] = field(default_factory=dict)

    @property
    def health_line(self) -> str:
        """How the recording went, as one line; empty where nobody knows."""
        return str(self.health.get("line", ""))


class EventKind(Enum):
    """What an event is about."""

    STATE = "state"
    HEALTH = "health"
    PROGRESS = "progress"
    WARNING = "warning"
    RECORDED = "recorded"
    PRELIMINARY = "preliminary"
    RUN = "run"


@dataclass(frozen=True, slots=True)
class Event:
    """One thing that happened.

    Attributes
    ----------
    kind
        STATE: `state` has changed; HEALTH: `health` is new; PROGRESS: of processing, `fraction` from 0 to 1; WARNING:
        `message` is for the operator; RECORDED: the file of `run` is closed, its result will follow; PRELIMINARY: what
        `run` gives so far, its final result will follow; RUN: `run` is finished.
    state
        Where the experiment is.
    number
        Of the run, counted from 1.
    message
        One sentence for the operator; may be empty.
    topic
        What a warning is about, where many of a kind may come; empty: about itself.
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
    topic: str = ""
