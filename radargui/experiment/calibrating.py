"""Run a calibration as the window or the command line orders it.

Read and write calibration files; a file is read completely or refused, and not overwritten by accident.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from radargui.files.access import Progress, reading, refuse_existing, sha256_of, write_whole
from radargui.files.formats import own_setup_of
from radargui.model.calibration import Calibration, calibration_text
from radargui.model.errors import ProcessingError, worded
from radargui.model.setup import Setup
from radargui.processing.long_recording import read_for_processing

if TYPE_CHECKING:
    from radargui.calibration.calibrate import Calibrated
    from radargui.calibration.known_path import Trajectory
    from radargui.calibration.rough_fit import KnownRecording

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
    clock
        Instead of the path files': shared where their times are those of the recordings.
    """

    files: tuple[Path, ...]
    known: tuple[str, ...]
    setup: Setup
    free: tuple[str, ...]
    operator: str = ""
    clock: Literal["free", "shared"] | None = None


Calibrate = Callable[[CalibrationOrder, Progress], Calibration]


def calibrate_files(
    order: CalibrationOrder, progress: Progress, fit: Callable[..., Calibrated] | None = None
) -> Calibration:
    """Return what recordings say about the antennas; nothing is written.

    Parameters
    ----------
    order
        What from.
    progress
        Called with the share done, 0 to 1; what it raises ends the work.
    fit
        Finds the antennas from the recordings; None: as `radargui.calibration.calibrate.calibrate` does.

    Raises
    ------
    RadarGuiError
        A file that cannot be read, or does not fit what is known of it or the setup.
    """
    # the window knows the order from its start on; the estimate behind it takes a second to load
    from radargui.calibration.calibrate import calibrate
    from radargui.calibration.known_path import read_known

    known = {name: None if name == FALL else read_known(Path(name), order.clock) for name in set(order.known)}
    recordings = [_read(file, known[name], order.setup) for file, name in zip(order.files, order.known, strict=True)]
    found = (fit or calibrate)(
        recordings,
        order.setup,
        order.free,
        progress=progress,
        workers=min(len(recordings), os.cpu_count() or 1),
        made_at=datetime.now().astimezone().isoformat(timespec="seconds"),
        operator=order.operator,
    )
    return found.calibration


def _read(path: Path, trajectory: Trajectory | None, setup: Setup) -> KnownRecording:
    """Return a recording with what is known of it; a run knows where its sphere hung."""
    from radargui.calibration.rough_fit import KnownRecording

    brought = own_setup_of(path)
    recording = read_for_processing(path)
    if recording.n_receivers != setup.n_receivers:
        counts = {"pairs": recording.n_receivers, "receivers": setup.n_receivers}
        raise worded(ProcessingError, "pairs_to_calibrate", path=path, **counts)
    with reading(path, "a recording"):
        checksum = sha256_of(path)
    release = (brought or setup).tracer.release_position_m
    name = path.stem if brought is None else f"{path.parent.name}/{path.stem}"
    return KnownRecording(recording, name, checksum, trajectory, release)


def write_calibration(path: Path, calibration: Calibration, *, force: bool = False) -> None:
    """Write a calibration as JSON, in one step.

    Parameters
    ----------
    path
        Its folder is made where it is missing.
    calibration
        What to write.
    force
        Write over a file that is there; else it is kept and the writing refused.

    Raises
    ------
    FileError
        A file is there, the folder cannot be written, or the values do not fit together.
    """
    text = calibration_text(calibration)
    refuse_existing([path], force=force)
    write_whole(path, [text.encode()])


def free_path(folder: Path, made_at: str) -> Path:
    """Return where a calibration made then can be kept beside older ones: calibration-2025-11-03.json, -2, ..."""
    stem = f"calibration-{made_at[:10]}"
    numbered = (folder / (f"{stem}.json" if n == 1 else f"{stem}-{n}.json") for n in range(1, 10_000))
    return next(path for path in numbered if not path.exists())
