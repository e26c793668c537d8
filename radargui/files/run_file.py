"""The run file read, whole or piece by piece: samples, setup, markers."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from radargui.files import hdf5
from radargui.files import run_layout as layout
from radargui.files.export_facts import ExportFacts
from radargui.files.progress import Progress, silent
from radargui.model.arrays import RawArray
from radargui.model.block import Gap, Marker, are_possible
from radargui.model.errors import FileError
from radargui.model.recording import Recording
from radargui.model.setup import Setup
from radargui.model.setup_file import parse_setup


def read_run(path: Path) -> Recording:
    """Return the recording in a run file, also where it was never closed (see `run_is_complete`).

    Raises
    ------
    FileError
        Unreadable, damaged, or no run file.
    """
    with opened_run(path) as file:
        raw = hdf5.dataset(file, layout.RAW, path, (2,))
        digitisation = layout.read_digitisation(raw, path)
        samples = raw[:] if "crc32" in file.attrs else raw[:, : layout.whole_samples(raw)]
        _want_untouched(file.attrs, samples, path)
        return Recording(
            name=path.stem,
            raw=samples,
            digitisation=digitisation,
            gaps=read_gaps(file, path),
            trigger_index=layout.read_trigger(raw.attrs),
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


def markers_in(file: Any, path: Path) -> tuple[Marker, ...]:
    """Return the notes in an opened run file; FileError where they are damaged."""
    if layout.MARKERS not in file:
        return ()
    rows = hdf5.dataset(file, layout.MARKERS, path, (1,))[:]
    return tuple(Marker(int(row["index"]), hdf5.decoded(row["text"])) for row in rows)


@contextmanager
def opened_run(path: Path) -> Iterator[Any]:
    """Open a run file whose header is sound.

    Raises
    ------
    FileError
        Unreadable, damaged, or no run file.
    """
    with hdf5.opened(path, "a run file", layout.is_run) as file:
        # Where a crash stopped the recording, it may have come between the header and its checksum.
        if _complete(file) and not (hdf5.is_sound(file.attrs) and hdf5.is_sound(file[layout.RAW].attrs)):
            raise FileError(f"{path}: its header is damaged.", remedy="Take the file from a backup.")
        yield file


def _want_untouched(attributes: Any, samples: RawArray, path: Path) -> None:
    if "crc32" not in attributes:
        return
    crcs = hdf5.rows_crc(samples, [0] * samples.shape[0])
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
    gaps = tuple(Gap(int(row["first_index"]), int(row["count"]), hdf5.decoded(row["reason"])) for row in rows)
    if not are_possible(gaps):
        raise FileError(f"{path}: its gap records are damaged.")
    return gaps


PIECE = 1 << 18
"""Samples of each channel that are in memory at a time."""


class RunStream:
    """The samples of an opened run file in pieces, with all that is known of them; see `run_stream`."""

    def __init__(self, file: Any, path: Path, facts: ExportFacts) -> None:
        self._file = file
        self.path = path
        self.facts = facts

    def pieces(self, report: Progress = silent) -> Iterator[RawArray]:
        """Yield the stored samples in order, untouched, shape (n_channels, at most PIECE), checked at the end.

        Parameters
        ----------
        report
            Called with the share done after each piece.

        Raises
        ------
        FileError
            A piece cannot be read, or the whole does not have the checksum that was stored with it.
        """
        raw = self._file[layout.RAW]
        crcs = [0] * raw.shape[0]
        # Whole chunks of the file: each is inflated once only.
        length = max(PIECE // raw.chunks[1], 1) * raw.chunks[1] if raw.chunks else PIECE
        for first in range(0, self.facts.n_samples, length):
            piece = self.part(first, min(first + length, self.facts.n_samples))
            crcs = hdf5.rows_crc(piece, crcs)
            yield piece
            report((first + piece.shape[1]) / self.facts.n_samples)
        attributes = self._file.attrs
        if "crc32" in attributes and crcs != np.ravel(attributes["crc32"]).tolist():
            raise FileError(f"{self.path}: its samples are damaged.", remedy="Take the file from a backup.")

    def part(self, first: int, last: int) -> RawArray:
        """Return the stored samples first:last, untouched.

        Raises
        ------
        FileError
            They cannot be read.
        """
        try:
            return np.asarray(self._file[layout.RAW][:, first:last])
        except (OSError, RuntimeError, ValueError) as error:
            raise FileError(f"{self.path}: its samples are damaged.") from error


@contextmanager
def run_stream(path: Path, session: Mapping[str, str] | None = None) -> Iterator[RunStream]:
    """Open a run file for reading piece by piece.

    Parameters
    ----------
    path
        Run file, also one that was never closed.
    session
        Facts of its session that shall travel with it.

    Raises
    ------
    FileError
        Unreadable, damaged, or no run file.
    """
    with opened_run(path) as file:
        raw = hdf5.dataset(file, layout.RAW, path, (2,))
        facts = ExportFacts(
            name=path.stem,
            digitisation=layout.read_digitisation(raw, path),
            n_samples=int(raw.shape[1]) if "crc32" in file.attrs else layout.whole_samples(raw),
            gaps=read_gaps(file, path),
            trigger_index=layout.read_trigger(raw.attrs),
            started_at=hdf5.text(raw.attrs, "started_at"),
            markers=markers_in(file, path),
            setup_toml=hdf5.text(file.attrs, "setup"),
            session=dict(session or {}),
        )
        yield RunStream(file, path, facts)
