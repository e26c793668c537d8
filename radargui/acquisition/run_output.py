"""Write one run to the disk: free space, levels of its channels, the blocks before it, its file."""

import logging
import shutil
import tempfile
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

import numpy as np

from radargui.acquisition.run_plan import Ending
from radargui.files.run_writer import RunWriter
from radargui.model.arrays import FloatArray, IntArray, RawArray
from radargui.model.errors import FileError, RadarGuiError, worded
from radargui.model.recording import Block, Digitisation, Gap, Truth, at_rail

MINIMUM_FREE_BYTES = 200_000_000
"""Stays free for closing the run and storing its results; chosen by hand."""
LOW_S = 600.0
"""Recording time left at which the operator is warned: enough to end a series in order; chosen by hand."""


def free_bytes(folder: Path) -> int | None:
    """Return the free bytes of the disk that holds `folder`; None where nobody knows."""
    with suppress(OSError):
        return shutil.disk_usage(folder).free
    return None


def want_writable(folder: Path) -> None:
    """Make sure that files can be made in a folder, before anything is recorded.

    Raises
    ------
    FileError
        None can be made there.
    """
    try:
        with tempfile.TemporaryFile(dir=folder, prefix=".writable-") as probe:
            probe.write(b"0")
    except OSError as error:
        raise worded(FileError, "no_writable_folder", folder=folder, why=error.strerror or error) from None


@dataclass(frozen=True, slots=True)
class Level:
    """Level of one channel over recent samples.

    Attributes
    ----------
    name
        Channel.
    lowest_v, highest_v
        Extremes in volts.
    full_scale_v
        Largest voltage a code can stand for; None where samples are volts.
    clipped
        Whether a sample sat at the end of the range.
    """

    name: str
    lowest_v: float
    highest_v: float
    full_scale_v: float | None
    clipped: bool

    @property
    def peak_v(self) -> float:
        """Largest absolute voltage."""
        return max(abs(self.lowest_v), abs(self.highest_v))


def levels(samples: RawArray, digitisation: Digitisation) -> tuple[Level, ...]:
    """Return the level of each channel of raw samples, shape (n_channels, n); none where n is 0."""
    if samples.shape[1] == 0:
        return ()
    extremes = _extremes(samples)
    # a negative slope of the scaling turns lowest and highest round
    volts = np.sort(digitisation.volts(extremes), axis=1).tolist()
    full_scale = digitisation.full_scale_v()
    largest = [None] * len(volts) if full_scale is None else np.abs(full_scale).max(axis=1).tolist()
    return tuple(
        Level(name, low, high, most, bool(at_end.any()))
        for name, (low, high), most, at_end in zip(
            digitisation.channel_names, volts, largest, at_rail(extremes), strict=True
        )
    )


def _extremes(samples: RawArray) -> RawArray:
    """Return the lowest and the highest sample of each channel, shape (n_channels, 2)."""
    ends: RawArray = np.stack([np.fmin.reduce(samples, axis=1), np.fmax.reduce(samples, axis=1)], axis=1)
    return ends


class RunTally:
    """Counts of each channel since it was made.

    Parameters
    ----------
    digitisation
        Names and scale of the channels.
    """

    def __init__(self, digitisation: Digitisation) -> None:
        n = digitisation.n_channels
        self._digitisation = digitisation
        self._ends: FloatArray = np.tile([np.inf, -np.inf], (n, 1))
        self._at_rail: IntArray = np.zeros(n, dtype=np.intp)
        self._unknown: IntArray = np.zeros(n, dtype=np.intp)

    def push(self, samples: RawArray) -> None:
        """Count samples, shape (n_channels, n)."""
        if samples.shape[1] == 0:
            return
        ends = _extremes(samples)
        # only channels that reach the rail are counted sample by sample
        for channel in np.flatnonzero(at_rail(ends).any(axis=1)):
            self._at_rail[channel] += int(at_rail(samples[channel]).sum())
        if samples.dtype != np.int16:
            self._unknown += (~np.isfinite(samples)).sum(axis=1)
        self._ends = np.stack([np.fmin(self._ends[:, 0], ends[:, 0]), np.fmax(self._ends[:, 1], ends[:, 1])], axis=1)

    def channels(self) -> list[dict[str, object]]:
        """Return one plain table a channel: name, lowest_v, highest_v, at_rail, not_a_number."""
        known = np.asarray(np.isfinite(self._ends).all(axis=1))
        volts = np.sort(self._digitisation.volts(np.where(known[:, None], self._ends, 0.0)), axis=1)
        return [
            {
                "name": name,
                "lowest_v": float(volts[channel, 0]) if known[channel] else None,
                "highest_v": float(volts[channel, 1]) if known[channel] else None,
                "at_rail": int(self._at_rail[channel]),
                "not_a_number": int(self._unknown[channel]),
            }
            for channel, name in enumerate(self._digitisation.channel_names)
        ]


class History:
    """The last `length` samples (lost ones counted) as whole blocks."""

    def __init__(self, length: int) -> None:
        self._length = length
        self._blocks: deque[Block] = deque()

    def push(self, block: Block) -> None:
        """Add a block; forget those that are older than the history is long."""
        self._blocks.append(block)
        oldest = block.end_index - self._length
        # whole blocks: the one in which the history begins is kept too
        while self._blocks[0].end_index <= oldest and len(self._blocks) > 1:
            self._blocks.popleft()

    def since(self, index: int) -> tuple[Block, ...]:
        """Return all samples held from absolute index `index` on; they stay, for the next run may need them too."""
        return tuple(cut(block, index, block.end_index) for block in self._blocks if block.end_index > index)


def cut(block: Block, first: int, last: int) -> Block:
    """Return the part of a block that lies in absolute indices first:last; a gap before it is cut as well."""
    low = min(max(first - block.first_index, 0), block.count)
    high = min(max(last - block.first_index, low), block.count)
    gap = block.gap if low == 0 else None
    if gap is not None and gap.first_index < first:
        end = gap.first_index + gap.count
        gap = Gap(first, end - first, gap.reason) if end > first else None
    return Block(block.samples[:, low:high], block.first_index + low, gap)


_logger = logging.getLogger(__name__)
_MAX_TRUTH_SAMPLES = 20_000_000
"""Truth of so many samples is 1 GB (six numbers of 8 bytes each): more would not fit beside the rest."""

TruthOf = Callable[[int, int], Truth | None]
"""`Source.truth`: absolute index of the first sample and count, lost samples counted."""
OpenRun: TypeAlias = Callable[..., RunWriter]
"""Makes the file of a run of a digitisation, `started_at` and `trigger_index` named; `Session.new_run` is one."""


@dataclass(frozen=True, slots=True)
class FinishedRun:
    """A run whose file is closed.

    Attributes
    ----------
    number
        Counted from 1 within the recorder, candidates that were set aside included.
    path
        The file.
    ending
        Why it ended.
    first_index, end_index
        Absolute indices of its first sample and after its last.
    count
        Samples of each channel written.
    set_aside
        Why it is no run that was wanted; empty where it is one.
    is_last
        Whether nothing is recorded after it.
    health
        How the recording went, as it is in the file.
    """

    number: int
    path: Path
    ending: Ending
    first_index: int
    end_index: int
    count: int
    set_aside: str
    is_last: bool
    health: Mapping[str, object]


class RunOutput:
    """Writes the samples of one run, counted in absolute indices.

    Parameters
    ----------
    file
        The file, open.
    digitisation
        Of the samples.
    first_index
        Absolute index of the first sample.

    Attributes
    ----------
    path
        The file.
    first_index, end_index
        Absolute index of the first sample, and after the last one so far.
    count, lost
        Samples of each channel written, and lost between them.
    gaps
        Where they were lost, indices counted from the run's first sample.
    tally
        What the samples are like.
    """

    def __init__(self, file: RunWriter, digitisation: Digitisation, first_index: int) -> None:
        self._file = file
        self.path = file.path
        self.gaps: list[Gap] = []
        self.first_index = self.end_index = first_index
        self.count = 0
        self.lost = 0
        self.tally = RunTally(digitisation)

    def write(self, block: Block, last_index: int | None) -> None:
        """Write what of a block lies before `last_index` (None: all of it).

        Raises
        ------
        FileError
            The file cannot be written.
        """
        part = block if last_index is None else cut(block, self.first_index, last_index)
        if not part.count and part.gap is None:
            return
        # a file counts from its own first sample, not from the start of the acquisition
        gap = part.gap and Gap(part.gap.first_index - self.first_index, part.gap.count, part.gap.reason)
        self._file.write(Block(part.samples, part.first_index - self.first_index, gap))
        self.tally.push(part.samples)
        self.count += part.count
        self.end_index = max(self.end_index, part.end_index)
        if gap is not None:
            self.gaps.append(gap)
            self.lost += gap.count

    def complete(self, truth_of: TruthOf | None, health: Mapping[str, object], *, whole: bool) -> None:
        """Write truth and health and close the file, which is closed also where one of them fails.

        Parameters
        ----------
        truth_of
            Asks the source.
        health
            How the recording went.
        whole
            Whether it ended in order.

        Raises
        ------
        FileError
            The file cannot be written.
        """
        try:
            truth = _recorded_truth(truth_of, self.first_index, self.count, self.gaps)
            if truth is not None:
                self._file.write_truth(truth)
            self._file.write_health(health)
        # closed also where truth or health fails: the samples are what cannot be had again
        finally:
            self._file.close(complete=whole)

    def abandon(self) -> None:
        """Close the file after a failure, keeping what was written; never raises."""
        try:
            self._file.close(complete=False)
        except (RadarGuiError, OSError):
            _logger.exception("The run file could not be closed after a failure")


def _recorded_truth(truth_of: TruthOf | None, first_index: int, count: int, gaps: Sequence[Gap]) -> Truth | None:
    """Return the truth beside `count` recorded samples; None where the source knows none.

    Parameters
    ----------
    truth_of
        Asks the source.
    first_index
        Absolute index of the run's first sample.
    count
        Samples recorded.
    gaps
        Samples lost, their indices counted from the run's first sample.
    """
    if truth_of is None or count == 0:
        return None
    span = count + sum(gap.count for gap in gaps)
    if span > _MAX_TRUTH_SAMPLES:
        _logger.warning("The run is too long for its truth to be stored")
        return None
    truth = truth_of(first_index, span)
    if truth is None or not gaps:
        return truth
    # the file holds no lost samples; neither does its truth
    kept = np.ones(span, dtype=np.bool_)
    for gap in gaps:
        kept[gap.first_index : gap.first_index + gap.count] = False
    return Truth(truth.position_m[:, kept], truth.path_m[:, kept], truth.impact_time_s)
