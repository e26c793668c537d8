"""A run file read piece by piece, for recordings that need not fit into memory."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from radargui.files import hdf5
from radargui.files import run_layout as layout
from radargui.files.export_facts import ExportFacts
from radargui.files.progress import Progress, silent
from radargui.files.run_file import markers_in, opened_run, read_gaps
from radargui.files.run_header import read_digitisation, read_trigger, whole_samples
from radargui.files.seal import rows_crc
from radargui.model.arrays import RawArray
from radargui.model.errors import FileError

PIECE = 1 << 18
"""Samples of each channel that are in memory at a time."""


class RunStream:
    """The samples of an opened run file in pieces, with all that is known of them; see `run_stream`."""

    def __init__(self, file: Any, path: Path, facts: ExportFacts) -> None:
        self._file = file
        self.path = path
        self.facts = facts

    def pieces(self, tell: Progress = silent) -> Iterator[RawArray]:
        """Yield the stored samples in order, untouched, shape (n_channels, at most PIECE), checked at the end.

        Parameters
        ----------
        tell
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
            crcs = rows_crc(piece, crcs)
            yield piece
            tell((first + piece.shape[1]) / self.facts.n_samples)
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
            digitisation=read_digitisation(raw, path),
            n_samples=int(raw.shape[1]) if "crc32" in file.attrs else whole_samples(raw),
            gaps=read_gaps(file, path),
            trigger_index=read_trigger(raw.attrs),
            started_at=hdf5.text(raw.attrs, "started_at"),
            markers=markers_in(file, path),
            setup_toml=hdf5.text(file.attrs, "setup"),
            session=dict(session or {}),
        )
        yield RunStream(file, path, facts)
