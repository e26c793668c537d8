"""The run file read: samples, setup, markers, and the truth of a simulated run."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from radargui.files import hdf5
from radargui.files import run_layout as layout
from radargui.files.lost_samples import are_possible
from radargui.files.run_header import is_run, read_digitisation, read_trigger, whole_samples
from radargui.files.seal import is_sound, rows_crc
from radargui.model.arrays import RawArray
from radargui.model.block import Gap
from radargui.model.errors import FileError
from radargui.model.recording import Recording
from radargui.model.setup import Setup
from radargui.model.setup_file import parse_setup
from radargui.model.truth import Truth


@dataclass(frozen=True, slots=True)
class Marker:
    """An operator's note at a sample (counted from the first, lost samples included)."""

    index: int
    text: str


def read_run(path: Path) -> Recording:
    """Return the recording in a run file, also where it was never closed (see `run_is_complete`).

    Raises
    ------
    FileError
        Unreadable, damaged, or no run file.
    """
    with opened_run(path) as file:
        raw = hdf5.dataset(file, layout.RAW, path, (2,))
        digitisation = read_digitisation(raw, path)
        samples = raw[:] if "crc32" in file.attrs else raw[:, : whole_samples(raw)]
        _want_untouched(file.attrs, samples, path)
        return Recording(
            name=path.stem,
            raw=samples,
            digitisation=digitisation,
            gaps=read_gaps(file, path),
            trigger_index=read_trigger(raw.attrs),
            started_at=hdf5.text(raw.attrs, "started_at"),
        )


def run_is_complete(path: Path) -> bool:
    """Return whether a run file was closed in order; False after a crash or a failure.

    Raises
    ------
    FileError
        Unreadable, or no run file.
    """
    with opened_run(path) as file:
        return _complete(file)


def read_run_setup(path: Path) -> Setup | None:
    """Return the setup that a run was recorded with; None where it holds none.

    Raises
    ------
    FileError
        Unreadable, or no run file.
    SetupError
        The setup in it is not valid for this version.
    """
    with opened_run(path) as file:
        toml = hdf5.text(file.attrs, "setup")
    return parse_setup(toml, f"setup in {path}") if toml.strip() else None


def read_markers(path: Path) -> tuple[Marker, ...]:
    """Return the operator's notes in the order they were made.

    Raises
    ------
    FileError
        Unreadable, or no run file.
    """
    with opened_run(path) as file:
        return markers_in(file, path)


def markers_in(file: Any, path: Path) -> tuple[Marker, ...]:
    """Return the notes in an opened run file; FileError where they are damaged."""
    if layout.MARKERS not in file:
        return ()
    rows = hdf5.dataset(file, layout.MARKERS, path, (1,))[:]
    return tuple(Marker(int(row["index"]), _text(row["text"])) for row in rows)


def read_run_truth(path: Path) -> Truth | None:
    """Return what really happened in a simulated run, for tests and tools only; None for real ones.

    Raises
    ------
    FileError
        Unreadable, or no run file.
    """
    with opened_run(path) as file:
        if layout.TRUTH not in file:
            return None
        group = file[layout.TRUTH]
        position, path_m, impacts = (
            np.asarray(hdf5.dataset(group, name, path)[...], dtype=np.float64)
            for name in ("position_m", "path_m", "impact_time_s")
        )
        return Truth(position, path_m, impacts)


@contextmanager
def opened_run(path: Path) -> Iterator[Any]:
    """Open a run file whose header is sound.

    Raises
    ------
    FileError
        Unreadable, damaged, or no run file.
    """
    with hdf5.opened(path, "a run file", is_run) as file:
        # Where a crash stopped the recording, it may have come between the header and its checksum.
        if _complete(file) and not (is_sound(file.attrs) and is_sound(file[layout.RAW].attrs)):
            raise FileError(f"{path}: its header is damaged.", remedy="Take the file from a backup.")
        yield file


def _want_untouched(attributes: Any, samples: RawArray, path: Path) -> None:
    if "crc32" not in attributes:
        return
    crcs = rows_crc(samples, [0] * samples.shape[0])
    if hdf5.number(attributes, "n_samples") != samples.shape[1] or crcs != np.ravel(attributes["crc32"]).tolist():
        raise FileError(f"{path}: its samples are damaged.", remedy="Take the file from a backup.")


def _complete(file: Any) -> bool:
    return bool(hdf5.number(file.attrs, "complete"))


def read_gaps(file: Any, path: Path) -> tuple[Gap, ...]:
    """Return the gap records of an opened run file.

    Raises
    ------
    FileError
        They are damaged.
    """
    if layout.GAPS not in file:
        return ()
    rows = hdf5.dataset(file, layout.GAPS, path, (1,))[:]
    gaps = tuple(Gap(int(row["first_index"]), int(row["count"]), _text(row["reason"])) for row in rows)
    if not are_possible(gaps):
        raise FileError(f"{path}: its gap records are damaged.")
    return gaps


def _text(value: Any) -> str:
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)
