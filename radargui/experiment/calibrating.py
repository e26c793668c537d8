"""A calibration as both doors order it: recordings, what is known of each, what is unknown."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from radargui.files.access import Progress
from radargui.model.calibration import Calibration
from radargui.model.errors import UsageError
from radargui.model.setup import Setup

FALL = "fall"


@dataclass(frozen=True, slots=True)
class CalibrationOrder:
    """What to calibrate from.

    Attributes
    ----------
    files
        Recordings.
    known
        Of each: `fall`, or a PATH.toml or CSV that says its motion.
    setup
        Where the antennas are thought to be, and how well that is known.
    free
        Groups of unknowns.
    operator
        Who asks for it.
    """

    files: tuple[Path, ...]
    known: tuple[str, ...]
    setup: Setup
    free: tuple[str, ...]
    operator: str = ""


Calibrate = Callable[[CalibrationOrder, Progress], Calibration]


def calibrate(order: CalibrationOrder, progress: Progress) -> Calibration:
    """Return what the recordings say about the antennas."""
    raise UsageError("not joined yet")
