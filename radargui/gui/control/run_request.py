"""What Record was asked for, how sources are asked to go about it, and which runs still wait for their result."""

from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from radargui.experiment.event import RecordedRun
from radargui.files.run_card import RunCard, read_run_card
from radargui.gui.setup.session_panel import Details
from radargui.model.errors import RadarGuiError
from radargui.model.setup import Setup
from radargui.sources.contract import Source
from radargui.sources.factory import SourceKind

_FALLING = ("drop", "bed")
"""Simulated scenes that, begun again and again, give one fall after the other."""


class MakeSource(Protocol):
    """Makes a source; `sources.factory.make_source` is one."""

    def __call__(
        self, kind: SourceKind, setup: Setup, *, run: int = 0, repeat: bool = False, file: Path | None = None
    ) -> Source:
        """Return a source, not yet open."""


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

    @property
    def continuous(self) -> bool:
        """Whether one source serves all runs: a device that starts at once, a simulated fall that is repeated."""
        if self.kind == "ni":
            return self.setup.daq.start == "now"
        return self.kind == "simulated" and self.n_runs > 1 and self.setup.simulation.scene in _FALLING


def at_once(setup: Setup) -> Setup:
    """Return the setup for looking only: the device starts without waiting for an edge."""
    changes = {"start": "now", "start_source": None, "start_pretrigger": False}
    return setup.model_copy(update={"daq": setup.daq.model_copy(update=changes)})


class Backlog:
    """Counts what was recorded since Record was asked for; results come in the order of the runs."""

    def __init__(self) -> None:
        self._waiting: dict[Path, RecordedRun] = {}
        self.last_recorded: Path | None = None

    def __len__(self) -> int:
        return len(self._waiting)

    @property
    def computed(self) -> Path | None:
        """The run whose result is computed now; None where none waits."""
        return next(iter(self._waiting), None)

    def take(self, run: RecordedRun) -> None:
        """Take a run that is on the disk; one that was set aside gets no result."""
        if run.path is not None and not run.set_aside:
            self._waiting[run.path] = run
            self.last_recorded = run.path

    def drop(self, run: RecordedRun) -> None:
        """Take the outcome of a run."""
        if run.path is not None:
            self._waiting.pop(run.path, None)


def card_of(run: RecordedRun) -> RunCard:
    """Return what the file of a run says of it; an empty card where it cannot be read."""
    try:
        return RunCard() if run.path is None else read_run_card(run.path)
    except RadarGuiError:
        return RunCard()
