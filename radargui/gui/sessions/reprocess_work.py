"""Processing again in the background: first only compared, then kept where the operator wants it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from radargui.experiment.compare import Comparison, compare_with
from radargui.experiment.reprocess import own_setup, process_run
from radargui.gui.sessions.work_strip import Task
from radargui.model.errors import RadarGuiError
from radargui.model.setup import Setup
from radargui.model.setup_change import changed


@dataclass(frozen=True, slots=True)
class OtherSettings:
    """How runs are processed again.

    Attributes
    ----------
    setup
        None: each run's own.
    changes
        Keys of it with another value; None: as it is.
    """

    setup: Setup | None
    changes: Mapping[str, Any]

    def of(self, run: Path) -> Setup:
        """Return the setup for a run.

        Raises
        ------
        RadarGuiError
            The run holds none, or a value is not allowed.
        """
        return changed(self.setup or own_setup(run), self.changes, "the other settings")


@dataclass(frozen=True, slots=True)
class Outcome:
    """What came of one run: old beside new, or why not."""

    run: Path
    comparison: Comparison | None = None
    error: RadarGuiError | None = None


def compare_all(runs: Sequence[Path], other: OtherSettings, task: Task) -> tuple[Outcome, ...]:
    """Process runs with other settings, without keeping anything; one that fails does not stop the others."""

    def one(run: Path, tell: Callable[[float], None]) -> Comparison:
        return compare_with(run, other.setup, other.changes, progress=tell)

    return _each(runs, one, task)


def keep_all(runs: Sequence[Path], other: OtherSettings, task: Task) -> tuple[Outcome, ...]:
    """Process runs with other settings and let the results take the place of the old, whose figures stay beside."""

    def one(run: Path, tell: Callable[[float], None]) -> None:
        process_run(run, other.of(run), progress=tell)

    return _each(runs, one, task)


def _each(
    runs: Sequence[Path], one: Callable[[Path, Callable[[float], None]], Comparison | None], task: Task
) -> tuple[Outcome, ...]:
    outcomes = []
    for done, run in enumerate(runs):

        def tell(share: float, done: int = done) -> None:
            task.tell((done + share) / len(runs))

        tell(0.0)
        try:
            outcomes.append(Outcome(run, one(run, tell)))
        except RadarGuiError as error:
            outcomes.append(Outcome(run, error=error))
    return tuple(outcomes)
