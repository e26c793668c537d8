"""Results kept beside the samples of a run; they can always be computed again."""

from __future__ import annotations

import json
import os
from dataclasses import asdict
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from radargui.files import hdf5
from radargui.files import run_layout as layout
from radargui.files.refusal import why
from radargui.files.run_header import is_run
from radargui.files.seal import is_sound, seal
from radargui.files.summary import summarise
from radargui.model.bounce import Bounce, Bounces
from radargui.model.errors import FileError
from radargui.model.result import RunResult

BOUNCE_TYPE = np.dtype(
    [
        ("time_s", "<f8"),
        ("speed_before_m_s", "<f8"),
        ("speed_after_m_s", "<f8"),
        ("e", "<f8"),
        ("u_e", "<f8"),
        ("method", h5py.string_dtype("utf-8", 40)),
        ("valid", "?"),
    ]
)


def write_results(path: Path, result: RunResult) -> None:
    """Store a result beside the samples of a run, in place of an older one.

    The file is written anew under another name and put in place in one step: a crash meanwhile leaves the
    recording as it was, and replaced results do not make the file grow.

    Raises
    ------
    FileError
        The run cannot be read or the folder cannot be written; the recording is as it was.
    """
    partial = path.with_name(path.name + ".part")
    try:
        with hdf5.opened(path, "a run file", is_run) as source:
            _write_anew(source, partial, path, result)
        _replace(partial, path)
    except FileError:
        partial.unlink(missing_ok=True)
        raise


def _write_anew(source: Any, partial: Path, path: Path, result: RunResult) -> None:
    try:
        with h5py.File(partial, "w") as target:
            for key in source.attrs:
                _copy_attribute(source.attrs, target.attrs, key)
            for name in source:
                if name != layout.RESULTS:
                    source.copy(name, target)
            _write(target.create_group(layout.RESULTS), result)
        with partial.open("rb+") as written:
            os.fsync(written.fileno())
    except (OSError, RuntimeError, ValueError, TypeError) as error:
        raise _refused(path, error) from error


def _copy_attribute(source: Any, target: Any, key: str) -> None:
    value = source[key]
    if isinstance(value, bytes):
        hdf5.put_text(target, key, value.decode("utf-8", "replace"))
    else:
        target[key] = value


def _replace(partial: Path, path: Path) -> None:
    try:
        partial.replace(path)
    except OSError as error:
        raise _refused(path, error) from error


def _refused(path: Path, error: Exception) -> FileError:
    return FileError(
        f"{path}: the results cannot be saved: {why(error)} The recording is as it was.",
        reasons=("the disk is full", "another program has the file open"),
        remedy="Process the run again once that is settled.",
    )


def read_summary(path: Path) -> dict[str, object] | None:
    """Return the summary stored with a run (see `summarise`); None where it was not processed yet.

    Raises
    ------
    FileError
        Unreadable, or no run file.
    """
    with hdf5.opened(path, "a run file", is_run) as file:
        if layout.RESULTS not in file:
            return None
        if not is_sound(file[layout.RESULTS].attrs):
            raise FileError(f"{path}: its results are damaged.", remedy="Process the run again.")
        summary = json.loads(hdf5.text(file[layout.RESULTS].attrs, "summary") or "null")
    return summary if isinstance(summary, dict) else None


def _write(group: Any, result: RunResult) -> None:
    summary = summarise(result)
    for key in ("version", "correction", "geometry", "status", "reason"):
        hdf5.put_text(group.attrs, key, str(summary[key]))
    hdf5.put_text(group.attrs, "processed_at", datetime.now(UTC).isoformat(timespec="seconds"))
    hdf5.put_text(group.attrs, "summary", json.dumps(summary))
    hdf5.put_text(group.attrs, "warnings", json.dumps(list(result.warnings)))
    hdf5.put_text(group.attrs, "calibration_uncertainty", json.dumps(result.calibration_uncertainty))
    channels = result.corrected.channels if result.corrected else ()
    hdf5.put_text(group.attrs, "channels", json.dumps([asdict(channel) for channel in channels]))
    seal(group.attrs)
    _write_bounces(group, result.bounces)
    chunk = layout.chunk_length(result.recording.digitisation.sample_rate_hz)
    if result.paths is not None:
        paths = group.create_group("paths")
        _write_columns(paths, result.paths, ("phase_rad", "change_m", "u_m", "valid"), chunk)
    if result.track is not None:
        track = group.create_group("track")
        _write_columns(track, result.track, ("time_s", "position_m", "u_position_m", "valid"), chunk)


def _write_bounces(group: Any, bounces: Bounces) -> None:
    rows = np.array([_row(bounce) for bounce in bounces.impacts], dtype=BOUNCE_TYPE)
    table = group.create_dataset("bounces", data=rows)
    if bounces.free_fall is not None:
        for key, value in asdict(bounces.free_fall).items():
            table.attrs[key] = value


def _row(bounce: Bounce) -> tuple[Any, ...]:
    return (
        bounce.time_s,
        bounce.speed_before_m_s,
        bounce.speed_after_m_s,
        bounce.e,
        bounce.u_e,
        layout.fitted(bounce.method, 40),
        bounce.valid,
    )


def _write_columns(group: Any, values: Any, names: tuple[str, ...], chunk: int) -> None:
    for name in names:
        hdf5.store(group, name, np.asarray(getattr(values, name)), chunk)
