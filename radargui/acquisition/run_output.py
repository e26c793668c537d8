"""One run on its way into its file: the blocks kept before its trigger, its samples, gaps and truth, how it ended."""

import logging
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

import numpy as np

from radargui.acquisition.level import RunTally
from radargui.acquisition.run_plan import Ending
from radargui.files.run_writer import RunWriter
from radargui.model.block import Block, Gap
from radargui.model.digitisation import Digitisation
from radargui.model.errors import RadarGuiError
from radargui.model.truth import Truth


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
_MOST_TRUTH_SAMPLES = 20_000_000
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
    trigger_index
        Counted from the run's first sample; None where there is no trigger.

    Attributes
    ----------
    path
        The file.
    first_index, end_index
        Absolute index of the first sample, and after the last one so far.
    count, lost
        Samples of each channel written, and lost between them.
    trigger_index
        As given.
    tally
        What the samples are like.
    """

    def __init__(
        self, file: RunWriter, digitisation: Digitisation, first_index: int, trigger_index: int | None
    ) -> None:
        self._file = file
        self.path = file.path
        self._gaps: list[Gap] = []
        self.first_index = self.end_index = first_index
        self.trigger_index = trigger_index
        self.count = 0
        self.lost = 0
        self.tally = RunTally(digitisation)

    @property
    def gaps(self) -> tuple[Gap, ...]:
        """Samples lost, their indices counted from the run's first sample."""
        return tuple(self._gaps)

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
            self._gaps.append(gap)
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
            truth = _recorded_truth(truth_of, self.first_index, self.count, self._gaps)
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
    if span > _MOST_TRUTH_SAMPLES:
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
