"""The states that an experiment passes through."""

from __future__ import annotations

from enum import Enum


class ExperimentState(Enum):
    """Where an experiment is."""

    IDLE = "idle"
    ARMED = "armed"
    RECORDING = "recording"
    SETTLING = "settling"
    PROCESSING = "processing"
    DONE = "done"
    FAILED = "failed"
