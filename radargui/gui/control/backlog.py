"""Runs that are on the disk and wait for their result: which, how many, which one is computed now."""

from __future__ import annotations

from pathlib import Path

from radargui.experiment.event import RecordedRun
from radargui.files.run_card import RunCard, read_run_card
from radargui.model.errors import RadarGuiError


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
