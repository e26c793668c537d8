"""Read and write calibration files; a file is read completely or refused, and not overwritten by accident."""

from pathlib import Path

from radargui.files.access import refuse_existing, write_whole
from radargui.model.calibration import Calibration
from radargui.model.calibration_file import calibration_text


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
