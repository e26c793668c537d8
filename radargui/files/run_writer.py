"""Write a run file while samples arrive, so that it survives a crash."""

from __future__ import annotations

import math
import shutil
import threading
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, Unpack

import h5py
import numpy as np

from radargui.files import hdf5, run_layout as layout
from radargui.files.access import why
from radargui.files.overview import OverviewMaker, write_overview
from radargui.files.run_card import put_health
from radargui.files.staged_file import StagedFile, TakenAwayError
from radargui.model.arrays import RawArray
from radargui.model.errors import FileError, FileLostError, worded
from radargui.model.recording import Block, Digitisation, Truth

RESERVE_BYTES = 4_000_000
"""A recording ends when less than this is free on the disk, so that the file can still be closed. Chosen by hand."""


class RunExistsError(FileError):
    """A run file of that name is there already."""


class RunWriter:
    """Writes one run as it is recorded.

    Whole chunks of about half a second are written and flushed, so that a crash loses less than that. `complete` is
    false in the file until `close`. Methods may be called from several threads.

    Parameters
    ----------
    path
        File to make; its folder is there already.
    digitisation
        Channels, rate, scale; int16 codes are stored where it has a scaling, else float64 volts.
    header
        See `run_layout.Header`.

    Attributes
    ----------
    count
        Samples of each channel taken so far, lost ones not counted.

    Raises
    ------
    RunExistsError
        A file of that name is there; it is left alone.
    FileError
        The file cannot be made.
    """

    def __init__(self, path: Path, digitisation: Digitisation, **header: Unpack[layout.Header]) -> None:
        self.path = path
        self.digitisation = digitisation
        # entered again by methods that call each other, as `mark` does `add_marker`
        self._lock = threading.RLock()
        self.count = 0
        self._filled = 0
        self._crcs = [0] * digitisation.n_channels
        self._first_index: int | None = None
        self._next_index = 0
        self._buffer = np.zeros(
            (digitisation.n_channels, layout.chunk_length(digitisation.sample_rate_hz)),
            dtype=np.float64 if digitisation.scaling is None else np.int16,
        )
        self._overview = OverviewMaker(self._buffer.shape[0], self._buffer.dtype)
        self._staged = _create(path)
        try:
            self._file: Any = h5py.File(self._staged, "w")
            with self._guarded() as file:
                layout.write_header(file, digitisation, header)
            self._want_room()
        except FileError:
            path.unlink(missing_ok=True)
            raise

    @property
    def closed(self) -> bool:
        """Whether nothing more can be written."""
        return self._file is None

    def write(self, block: Block) -> None:
        """Append the samples of a block, untouched; indices that are missing before it become a gap record.

        Raises
        ------
        FileError
            The disk is full or failed, the block does not fit this file, or the writer is closed. What was written
            before stays readable.
        FileLostError
            Somebody deleted or cut the file, which is looked at whenever samples go to the disk, twice a second.
        """
        with self._lock:
            self._opened()
            self._check(block)
            if self._first_index is None:
                self._first_index = self._next_index = block.first_index
            if block.first_index > self._next_index:
                self._add_gap(block)
            self._next_index = block.end_index
            self._append(block.samples)

    def add_marker(self, index: int, text: str) -> None:
        """Keep an operator's note at a sample, counted from the first sample written, lost samples included."""
        with self._lock, self._guarded() as file:
            hdf5.append_row(file[layout.MARKERS], (int(index), layout.fitted(text, layout.MARKER_BYTES)))

    def mark(self, text: str) -> int:
        """Keep an operator's note at the sample that comes next, and return its index."""
        with self._lock:
            index = self._next_index - (self._first_index or 0)
            self.add_marker(index, text)
            return index

    def write_truth(self, truth: Truth) -> None:
        """Store what really happened beside a simulated recording; a second call replaces the first."""
        with self._lock, self._guarded() as file:
            if layout.TRUTH in file:
                del file[layout.TRUTH]
            group = file.create_group(layout.TRUTH)
            for name in ("position_m", "path_m", "impact_time_s"):
                values = np.asarray(getattr(truth, name), dtype=np.float64)
                hdf5.store(group, name, values, self._buffer.shape[1], unit=name.rpartition("_")[2])

    def write_health(self, record: Mapping[str, object]) -> None:
        """Store how the recording went, a table that JSON can hold; a second call replaces the first."""
        with self._lock, self._guarded() as file:
            put_health(file, record)

    def close(self, *, complete: bool = True) -> None:
        """Write what is left and close; idempotent.

        Parameters
        ----------
        complete
            False where the recording ended by a failure: the file then says so.

        Raises
        ------
        FileError
            The disk is full or failed; what was flushed before stays readable.
        """
        with self._lock:
            if self._file is None:
                return
            self._write_rows()
            with self._guarded() as file:
                # a picture is drawn from the samples where there is none; what the disk still holds is for the end
                if self._free_bytes() > 2 * RESERVE_BYTES:
                    write_overview(file, self._overview, layout.stored_unit(self.digitisation))
                layout.write_end(file, self.count, self._crcs, complete=complete)
            self._let_go(whole=True)

    def __enter__(self) -> RunWriter:
        return self

    def __exit__(self, _kind: object, error: BaseException | None, _trace: object) -> None:
        try:
            self.close(complete=error is None)
        except FileError as second:
            if error is None:
                raise
            error.add_note(str(second))

    def _check(self, block: Block) -> None:
        samples = block.samples
        if samples.ndim != 2 or samples.shape[0] != self._buffer.shape[0] or samples.dtype != self._buffer.dtype:
            wanted = {"n_channels": self._buffer.shape[0], "wanted": self._buffer.dtype}
            raise worded(FileError, "other_block", path=self.path, dtype=samples.dtype, shape=samples.shape, **wanted)
        if self._first_index is not None and block.first_index < self._next_index:
            raise worded(FileError, "block_again", path=self.path, first=block.first_index, next=self._next_index)

    def _append(self, samples: RawArray) -> None:
        while samples.shape[1]:
            part = samples[:, : self._buffer.shape[1] - self._filled]
            samples = samples[:, part.shape[1] :]
            self._buffer[:, self._filled : self._filled + part.shape[1]] = part
            self._filled += part.shape[1]
            self.count += part.shape[1]
            if self._filled == self._buffer.shape[1]:
                self._write_rows()
                self._want_room()

    def _write_rows(self) -> None:
        if not self._filled:
            return
        with self._guarded() as file:
            raw = file[layout.RAW]
            first = raw.shape[1]
            raw.resize(first + self._filled, axis=1)
            for channel in range(self._buffer.shape[0]):
                raw[channel, first:] = self._buffer[channel, : self._filled]
        self._crcs = hdf5.rows_crc(self._buffer[:, : self._filled], self._crcs)
        self._overview.add(self._buffer[:, : self._filled])
        self._filled = 0

    def _want_room(self) -> None:
        # Stopping while there is room keeps every sample taken so far, and leaves some for the results.
        if self._free_bytes() < RESERVE_BYTES:
            self._let_go()
            raise worded(FileError, "disk_full", path=self.path, kept=self._kept())

    def _free_bytes(self) -> float:
        with suppress(OSError):
            return shutil.disk_usage(self.path.parent).free
        return math.inf

    def _add_gap(self, block: Block) -> None:
        reason = layout.fitted(block.gap.reason if block.gap else "", layout.REASON_BYTES)
        lost = block.first_index - self._next_index
        with self._guarded() as file:
            hdf5.append_row(file[layout.GAPS], (self._next_index - (self._first_index or 0), lost, reason))

    @property
    def _written_s(self) -> float:
        return (self.count - self._filled) / self.digitisation.sample_rate_hz

    def _kept(self) -> str:
        return f"the first {self._written_s:.3g} s of the recording are kept"

    def _opened(self) -> Any:
        if self._file is None:
            raise FileError(f"{self.path} is closed: nothing more can be written to it.")
        return self._file

    @contextmanager
    def _guarded(self) -> Iterator[Any]:
        """Hand out the file and commit; after a failure it stays on the disk as the commit before left it."""
        file = self._opened()
        try:
            yield file
            file.flush()
            self._staged.commit()
        except TakenAwayError as error:
            self._let_go()
            lost = f"its first {self._written_s:.3g} s are not there any more."
            raise FileLostError(f"{self.path} {error} while it was being recorded: {lost}") from None
        except (OSError, RuntimeError, ValueError, TypeError, KeyError) as error:
            self._let_go()
            facts = {"path": self.path, "why": why(error), "kept": self._kept()}
            raise worded(FileError, "run_not_written", **facts) from error

    def _let_go(self, *, whole: bool = False) -> None:
        """Close; unless `whole`, what HDF5 writes while closing stays off the disk."""
        file, self._file = self._file, None
        try:
            if file is not None:
                file.close()
            if whole:
                self._staged.commit()
                self._staged.sync()
        except (OSError, RuntimeError, ValueError):
            # Every sample is on the disk since the commit before.
            return
        finally:
            self._staged.close()


def _create(path: Path) -> StagedFile:
    try:
        return StagedFile(path)
    except FileExistsError:
        raise worded(RunExistsError, "run_exists", path=path) from None
    except OSError as error:
        raise worded(FileError, "run_not_made", path=path, why=why(error)) from None
