"""The teller: keeps the state of an experiment and tells its listener what happens."""

from __future__ import annotations

from collections.abc import Callable

from radargui.acquisition.health import Health
from radargui.experiment.event import Event, EventKind
from radargui.experiment.recorded_run import RecordedRun
from radargui.experiment.state import ExperimentState
from radargui.model.errors import RadarGuiError

Listener = Callable[[Event], None]


class Teller:
    """Tells events, in the thread of whoever calls.

    Parameters
    ----------
    listener
        Told; None: nobody is.

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
        self._tell(Event(EventKind.STATE, state, self.number, message, error=error))

    def fail(self, error: RadarGuiError) -> None:
        """Change the state to FAILED."""
        self.enter(ExperimentState.FAILED, str(error), error=error)

    def health(self, health: Health) -> None:
        """Tell a snapshot."""
        self._tell(Event(EventKind.HEALTH, self.state, self.number, health.line(), health=health))

    def progress(self, number: int, fraction: float) -> None:
        """Tell how far the processing of a run is."""
        self._tell(Event(EventKind.PROGRESS, self.state, number, fraction=fraction))

    def warn(self, message: str, *, number: int | None = None, error: RadarGuiError | None = None) -> None:
        """Tell a sentence for the operator."""
        self._tell(
            Event(EventKind.WARNING, self.state, self.number if number is None else number, message, error=error)
        )

    def preliminary(self, run: RecordedRun) -> None:
        """Tell what a run gives so far."""
        self._tell(Event(EventKind.PRELIMINARY, self.state, run.number, run.message, run=run))

    def run(self, run: RecordedRun) -> None:
        """Tell what came of a run."""
        self._tell(Event(EventKind.RUN, self.state, run.number, run.message, run=run))

    def _tell(self, event: Event) -> None:
        if self._listener is not None:
            self._listener(event)
