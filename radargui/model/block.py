"""A block: consecutive samples as they arrive, with the absolute index of the first."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from radargui.model.arrays import IntArray, RawArray


@dataclass(frozen=True, slots=True)
class Gap:
    """Samples that were lost.

    Attributes
    ----------
    first_index
        Absolute index of the first lost sample (counting lost ones too).
    count
        How many samples of each channel were lost.
    reason
        Why, in a few words.
    """

    first_index: int
    count: int
    reason: str = ""


@dataclass(frozen=True, slots=True)
class Marker:
    """An operator's note at a sample (counted from the first, lost samples included)."""

    index: int
    text: str


@dataclass(frozen=True, slots=True)
class Block:
    """Consecutive samples of all channels.

    Attributes
    ----------
    samples
        Shape (n_channels, n), int16 codes or float64 volts; owned by the block, never reused by its maker.
    first_index
        Absolute index of the first sample; time = index / rate.
    gap
        Samples lost just before this block, or None.
    trigger_index
        Absolute index of the edge at which the device started, told with the first block; may lie after it. None where
        the device waited for none.
    """

    samples: RawArray
    first_index: int
    gap: Gap | None = None
    trigger_index: int | None = None

    @property
    def count(self) -> int:
        """Number of samples of each channel."""
        return int(self.samples.shape[1])

    @property
    def end_index(self) -> int:
        """Absolute index after the last sample."""
        return self.first_index + self.count


def absolute_index(first: int, count: int, gaps: Sequence[Gap]) -> IntArray:
    """Return the index, lost samples counted, of the stored samples `first` to `first + count`."""
    index = np.arange(first, first + count, dtype=np.int64)
    # in order: where a gap begins counts what earlier ones lost
    for gap in sorted(gaps, key=lambda gap: gap.first_index):
        index[index >= gap.first_index] += gap.count
    return index


LARGEST_INDEX = 2**53
"""No recording is that long: 28 years at 10 MS/s."""


def are_possible(gaps: Sequence[Gap]) -> bool:
    """Return whether gaps can be those of a recording: none negative or empty, none beyond any recording."""
    return (
        all(0 <= gap.first_index < LARGEST_INDEX and gap.count >= 1 for gap in gaps)
        and sum(gap.count for gap in gaps) < LARGEST_INDEX
    )


def stored_starts(gaps: Sequence[Gap], n_samples: int) -> list[tuple[int, int]]:
    """Return for each gapless stretch the stored number and the absolute index of its first sample."""
    starts, lost = [(0, 0)], 0
    for gap in sorted(gaps, key=lambda gap: gap.first_index):
        stored = gap.first_index - lost
        lost += gap.count
        if stored >= n_samples:
            break
        # two gaps without a sample between them are one
        if stored == starts[-1][0]:
            starts.pop()
        starts.append((stored, stored + lost))
    return starts
