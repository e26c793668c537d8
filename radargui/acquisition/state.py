"""The states that an acquisition passes through."""

from enum import Enum


class AcquisitionState(Enum):
    """Where an acquisition is: IDLE, OPENING, RUNNING, STOPPING, then STOPPED or FAILED for good."""

    IDLE = "idle"
    OPENING = "opening"
    RUNNING = "running"
    STOPPING = "stopping"
    STOPPED = "stopped"
    FAILED = "failed"


class RecorderState(Enum):
    """Where a recorder is: IDLE until the source is open, ARMED until something moves, RECORDING, at last DONE.

    Where further runs follow it is ARMED again after each run; SETTLING in between where it is not quiet yet.
    """

    IDLE = "idle"
    ARMED = "armed"
    RECORDING = "recording"
    SETTLING = "settling"
    DONE = "done"


class Ending(Enum):
    """Why a recorder is done."""

    QUIET = "the sphere came to rest"
    MAXIMUM = "the longest length of a run was reached"
    SECONDS = "the length asked for was reached"
    END_OF_DATA = "the source gave no more samples"
    STOPPED = "stopped by the operator"
    FAILED = "recording failed"
    DISK = "the disk was almost full"
    NO_MOTION = "the source ended before anything moved"
    WAITED = "nothing moved in the time allowed for waiting"
