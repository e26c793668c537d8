"""The publisher: keeps the state of an experiment and reports to its listener what happens."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

from radargui.acquisition.health import Health
from radargui.acquisition.run_output import FinishedRun
from radargui.experiment.event import Event, EventKind, ExperimentState, RecordedRun
from radargui.model.errors import RadarGuiError


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
            yield (
                f"The disk is filling up: about {left_min:.0f} minutes can still be recorded. "
                "Make room, or choose another folder after this run."
            )


def losses(health: Health) -> Iterator[str]:
    """Yield what was lost between source and file during an acquisition."""
    if health.samples_lost:
        gaps = f"{health.gaps} gap{'s' if health.gaps > 1 else ''}"
        yield f"{health.samples_lost} samples of each channel were lost by the source in {gaps}"
    if health.samples_not_written:
        yield f"{health.samples_not_written} samples of each channel could not be written in time and are lost"


def signal_warnings(run: FinishedRun) -> Iterator[str]:
    """Yield what is wrong with the voltages of a run."""
    channels = run.health.get("channels")
    for channel in channels if isinstance(channels, list) else ():
        if not isinstance(channel, Mapping):
            continue
        if channel["at_rail"]:
            yield (
                f"{channel['name']} sat at the end of its range in {_samples(channel['at_rail'])}: "
                "set a larger range (daq.range_v) or less gain"
            )
        if channel["not_a_number"]:
            yield f"{channel['name']} gave no number in {_samples(channel['not_a_number'])}"


def _samples(count: int) -> str:
    return f"{count} sample{'s' if count > 1 else ''}"


Listener = Callable[[Event], None]


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
        self,
        kind: EventKind,
        message: str = "",
        *,
        number: int | None = None,
        fraction: float | None = None,
        health: Health | None = None,
        run: RecordedRun | None = None,
        error: RadarGuiError | None = None,
        topic: str = "",
    ) -> None:
        """Report what happened, see `Event`; `number` is that of the run, of the present one where left out."""
        if run is not None:
            number, message = run.number, run.message
        if self._listener is not None:
            number = self.number if number is None else number
            self._listener(Event(kind, self.state, number, message, fraction, health, run, error, topic))
