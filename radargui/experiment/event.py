"""Report what an experiment does while it runs, as immutable values for the window and the command line."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from enum import Enum
from pathlib import Path
from typing import TypedDict, Unpack

from radargui.acquisition.health import Health
from radargui.acquisition.run_output import FinishedRun
from radargui.acquisition.run_plan import Ending
from radargui.experiment.finished import LiveAgreement
from radargui.model.errors import RadarGuiError
from radargui.model.result import Bounce, RunResult
from radargui.model.rounding import quantity
from radargui.model.words import counted


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
    live
        The first bounce as the live track saw it; None where it saw none, or nobody looked.
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
    live: Bounce | None = None

    @property
    def health_line(self) -> str:
        """How the recording went, as one line; empty where nobody knows."""
        return str(self.health.get("line", ""))


def unprocessed(run: FinishedRun, live: Bounce | None = None) -> RecordedRun:
    """Return what came of a run that is kept as it is, with what the live track saw of it."""
    said = f"set aside, {run.set_aside}" if run.set_aside else "recorded, not processed."
    message = f"{run.path.name}: {said}"
    return RecordedRun(
        run.number, run.path, None, run.ending, message, set_aside=run.set_aside, health=run.health, live=live
    )


def recorded(run: FinishedRun, result: RunResult, agreement: LiveAgreement | None) -> RecordedRun:
    """Return what came of a run that was processed."""
    message = f"{run.path.name}: {_said(result, agreement)}"
    return RecordedRun(run.number, run.path, result, run.ending, message, agreement=agreement, health=run.health)


def with_place(error: RadarGuiError, path: Path | None) -> RadarGuiError:
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


LIVE = "live"
"""Method of a bounce that the live track saw."""


class EventKind(Enum):
    """What an event is about."""

    STATE = "state"
    HEALTH = "health"
    PROGRESS = "progress"
    WARNING = "warning"
    BOUNCE = "bounce"
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
        `message` is for the operator; BOUNCE: `bounce` is the first one of the run under way, as the live track sees it
        (its method is `LIVE`), then as its flights tell it so far; RECORDED: the file of `run` is closed, its result
        will follow; PRELIMINARY: what `run` gives so far, its final result will
        follow; RUN: `run` is finished.
    state
        Where the experiment is.
    number
        Of the run, counted from 1.
    message
        One sentence for the operator; may be empty.
    topic
        What a warning is about, where many of a kind may come; empty: about itself.
    fraction, health, run, error, bounce
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
    bounce: Bounce | None = None


class RunningWarnings:
    """Says once what the operator should do something about."""

    def __init__(self) -> None:
        self._said_low_disk = False
        self._said_lost_file = ""

    def of(self, health: Health) -> Iterator[str]:
        """Yield what is new in a snapshot."""
        if health.lost_file != self._said_lost_file:
            self._said_lost_file = health.lost_file
            yield health.lost_file
        if health.disk_is_low and not self._said_low_disk:
            self._said_low_disk = True
            left_min = (health.disk_left_s or 0.0) / 60.0
            fact = f"The disk is filling up: about {left_min:.0f} minutes can still be recorded."
            yield f"{fact} Make room, or choose another folder after this run."


def losses(health: Health) -> Iterator[str]:
    """Yield what was lost between source and file during an acquisition."""
    if health.samples_lost:
        yield f"{health.samples_lost} samples of each channel were lost by the source in {counted(health.gaps, 'gap')}"
    if health.samples_not_written:
        yield f"{health.samples_not_written} samples of each channel could not be written in time and are lost"


def signal_warnings(run: FinishedRun) -> Iterator[str]:
    """Yield what is wrong with the voltages of a run."""
    channels = run.health.get("channels")
    for channel in channels if isinstance(channels, list) else ():
        if channel["at_rail"]:
            said = f"{channel['name']} sat at the end of its range in {counted(channel['at_rail'], 'sample')}"
            yield f"{said}: set a larger range (daq.range_v) or less gain"
        if channel["not_a_number"]:
            yield f"{channel['name']} gave no number in {counted(channel['not_a_number'], 'sample')}"


def shortfall(run: FinishedRun, seconds: float | None) -> Iterator[str]:
    """Yield that a run is shorter than was asked for, where its source ended before; `seconds` None: no length was."""
    rate_hz = run.health.get("sample_rate_hz")
    if seconds is not None and run.ending is Ending.END_OF_DATA and isinstance(rate_hz, float):
        long_s = (run.end_index - run.first_index) / rate_hz
        yield f"{long_s:.2f} s were recorded of the {seconds:g} s asked for: {run.ending.value}"


Listener = Callable[[Event], None]


class EventFacts(TypedDict, total=False):
    """What an event may hold beside its message, see `Event`."""

    fraction: float | None
    health: Health | None
    run: RecordedRun | None
    error: RadarGuiError | None
    topic: str
    bounce: Bounce | None


class Publisher:
    """Reports events, in the thread of whoever calls.

    Parameters
    ----------
    listener
        Called with each event; None: nobody listens.

    Attributes
    ----------
    state
        Where the experiment is.
    number
        Of the run that is recorded, or waited for.
    """

    def __init__(self, listener: Listener | None) -> None:
        self._listener = listener
        self.state = ExperimentState.IDLE
        self.number = 0

    def enter(self, state: ExperimentState, message: str, *, error: RadarGuiError | None = None) -> None:
        """Change the state."""
        self.state = state
        self.report(EventKind.STATE, message, error=error)

    def report(
        self, kind: EventKind, message: str = "", *, number: int | None = None, **facts: Unpack[EventFacts]
    ) -> None:
        """Report what happened, see `Event`; `number` is that of the run, of the present one where left out."""
        if (run := facts.get("run")) is not None:
            number, message = run.number, run.message
        if self._listener is not None:
            self._listener(Event(kind, self.state, self.number if number is None else number, message, **facts))
