"""A recorded run: its file, its result, and why it ended."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from radargui.acquisition.state import Ending
from radargui.experiment.live_agreement import LiveAgreement
from radargui.model.errors import RadarGuiError
from radargui.model.result import RunResult


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
