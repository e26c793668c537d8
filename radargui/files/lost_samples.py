"""Where each sample lies when samples before it were lost."""

from __future__ import annotations

from collections.abc import Sequence

from radargui.model.block import Gap

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
        if stored == starts[-1][0]:
            starts.pop()
        starts.append((stored, stored + lost))
    return starts
