"""What the program is doing, as the operator names it."""

from enum import Enum


class AppState(Enum):
    """The state shown in large letters; the value is the word shown."""

    IDLE = "IDLE"
    STARTING = "STARTING"
    LIVE = "LIVE"
    ARMED = "ARMED"
    RECORDING = "RECORDING"
    SETTLING = "SETTLING"
    PROCESSING = "PROCESSING"
    STOPPING = "STOPPING"
    DONE = "DONE"
    FAILED = "FAILED"

    @property
    def running(self) -> bool:
        """Whether samples come in or are worked on."""
        return self not in (AppState.IDLE, AppState.DONE, AppState.FAILED)

    @property
    def holds_a_run(self) -> bool:
        """Whether stopping now would cut a run off."""
        return self in (AppState.RECORDING, AppState.PROCESSING)
