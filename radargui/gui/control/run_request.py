"""What Record was asked for, and how sources are asked to go about it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

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
    operator: str = ""
    notes: str = ""
    sample: str = ""
    target: str = ""
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
