"""Results kept beside the samples of a run; they can always be computed again."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, astuple
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import DTypeLike

from radargui import __version__
from radargui.files import hdf5
from radargui.files import run_layout as layout
from radargui.files.bounce_table import put_bounces
from radargui.files.rewriting import copy_attribute, rewritten
from radargui.files.run_header import is_run
from radargui.files.run_health import health_in, put_health
from radargui.files.seal import is_sound, seal
from radargui.files.stored_front_ends import PRIOR
from radargui.files.stored_results import keep_earlier
from radargui.files.summary import summarise, summary_in
from radargui.files.thumbnail import put_thumbnail
from radargui.model.errors import FileError
from radargui.model.result import RunResult
from radargui.model.setup import Setup
from radargui.model.setup_file import dump_setup

_UNITS = {"rad": "rad", "m": "m", "s": "s"}


def write_results(path: Path, result: RunResult, *, health: Mapping[str, object] | None = None) -> None:
    """Store a result beside the samples of a run, in place of an older one, whose figures are kept (`stored_results`).

    The file is written anew under another name and put in place in one step: a crash meanwhile leaves the
    recording as it was, and replaced results do not make the file grow.

    Parameters
    ----------
    path
        Run file.
    result
        What the run gave.
    health
        Facts to add to the health record of the run.

    Raises
    ------
    FileError
        The run cannot be read, is being recorded, or the folder cannot be written; the recording is as it was.
    """
    with rewritten(path, "the results cannot be saved") as (source, target):
        _want_ended(source.attrs, path)
        for key in source.attrs:
            copy_attribute(source.attrs, target.attrs, key)
        for name in source:
            if name != layout.RESULTS:
                source.copy(name, target)
        keep_earlier(source, target, (__version__, dump_setup(result.setup)))
        _write(target.create_group(layout.RESULTS), result, source.attrs.get("crc32"))
        if health is not None:
            put_health(target, {**(health_in(source) or {}), **health})


def _want_ended(attributes: Any, path: Path) -> None:
    """Refuse a file that a recorder may still be writing: what it writes from now on would be lost."""
    if hdf5.number(attributes, "complete") == 0.0 and "crc32" not in attributes:
        raise FileError(
            f"{path}: its recording has not ended.",
            reasons=("it is being recorded", "the program was stopped while it was recorded"),
            remedy="If nothing records it any more, finish it first: radargui recover.",
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
        return summary_in(file[layout.RESULTS]) or None


def results_are_current(path: Path, setup: Setup) -> bool:
    """Return whether a run holds sound, final results that this version made of its samples with this setup.

    Raises
    ------
    FileError
        Unreadable, or no run file.
    """
    with hdf5.opened(path, "a run file", is_run) as file:
        if layout.RESULTS not in file or not is_sound(file[layout.RESULTS].attrs):
            return False
        summary = summary_in(file[layout.RESULTS])
        return bool(summary) and not summary.get("preliminary") and are_made_of(file, setup)


def are_made_of(file: Any, setup: Setup) -> bool:
    """Return whether this version made the results in an opened run file, of the samples in it, with this setup."""
    attributes = file[layout.RESULTS].attrs
    crc = np.ravel(attributes.get("raw_crc32", ()))
    return (
        hdf5.text(attributes, "version") == __version__
        and hdf5.number(attributes, "format_version") == layout.RESULTS_VERSION
        and hdf5.text(attributes, "setup") == dump_setup(setup)
        and crc.size > 0
        and crc.tolist() == np.ravel(file.attrs.get("crc32", ())).tolist()
    )


def _write(group: Any, result: RunResult, raw_crc32: Any) -> None:
    summary = summarise(result)
    group.attrs["format_version"] = layout.RESULTS_VERSION
    if raw_crc32 is not None:
        group.attrs["raw_crc32"] = raw_crc32
    for key in ("version", "correction", "geometry", "status", "reason"):
        hdf5.put_text(group.attrs, key, str(summary[key]))
    hdf5.put_text(group.attrs, "setup", dump_setup(result.setup))
    hdf5.put_text(group.attrs, "processed_at", datetime.now(UTC).isoformat(timespec="seconds"))
    hdf5.put_text(group.attrs, "summary", json.dumps(summary))
    hdf5.put_text(group.attrs, "warnings", json.dumps(list(result.warnings)))
    budget = None if result.uncertainty_budget is None else asdict(result.uncertainty_budget)
    hdf5.put_text(group.attrs, "uncertainty_budget", json.dumps(budget))
    channels = result.corrected.channels if result.corrected else ()
    hdf5.put_text(group.attrs, "channels", json.dumps([asdict(channel) for channel in channels]))
    prior = None if result.front_end_prior is None else asdict(result.front_end_prior)
    hdf5.put_text(group.attrs, PRIOR, json.dumps(prior))
    excerpt = result.recording.excerpt
    hdf5.put_text(group.attrs, "excerpt", json.dumps(None if excerpt is None else asdict(excerpt)))
    group.attrs["first_sample"] = 0 if excerpt is None else excerpt.first_stored
    if result.segment is not None:
        group.attrs["segment"] = astuple(result.segment)
    seal(group.attrs)
    put_bounces(group, result.bounces)
    _write_values(group, result, layout.chunk_length(result.recording.digitisation.sample_rate_hz))
    put_thumbnail(group, result)


def _write_values(group: Any, result: RunResult, chunk: int) -> None:
    if result.corrected is not None:
        # for display, as the phase, which the path lengths give in full
        _write_columns(group.require_group("corrected"), result.corrected, ("i", "q"), chunk, np.float32)
    if result.paths is not None:
        paths = group.require_group("paths")
        _write_columns(paths, result.paths, ("phase_rad",), chunk, np.float32)
        _write_columns(paths, result.paths, ("change_m", "u_m", "valid"), chunk)
        if result.paths.piece is not None:
            _write_columns(paths, result.paths, ("piece",), chunk, np.int32)
    if result.track is not None:
        track = group.require_group("track")
        _write_columns(track, result.track, ("time_s", "position_m", "u_position_m", "valid"), chunk)
        if result.track.u_combined_m is not None:
            _write_columns(track, result.track, ("u_combined_m",), chunk)


def _write_columns(group: Any, values: Any, names: tuple[str, ...], chunk: int, dtype: DTypeLike | None = None) -> None:
    for name in names:
        unit = _UNITS.get(name.rpartition("_")[2], "1")
        hdf5.store(group, name, np.asarray(getattr(values, name), dtype), chunk, unit=unit)
