"""Where each sample lies when samples before it were lost."""

from __future__ import annotations

import numpy as np
import pytest

from radargui.model.recording import Gap, absolute_index, are_possible, stored_starts


def test_the_index_jumps_by_what_was_lost() -> None:
    gaps = (Gap(12, 5, "b"), Gap(3, 4, "a"))
    assert absolute_index(0, 10, gaps).tolist() == [0, 1, 2, 7, 8, 9, 10, 11, 17, 18]


@pytest.mark.parametrize(
    ("gaps", "starts"),
    [
        ((), [(0, 0)]),
        ((Gap(3, 4, "a"), Gap(12, 5, "b")), [(0, 0), (3, 7), (8, 17)]),
        ((Gap(0, 4, "before the first sample"),), [(0, 4)]),
        ((Gap(3, 4, "a"), Gap(7, 5, "one after the other")), [(0, 0), (3, 12)]),
        ((Gap(10, 4, "after the last sample"),), [(0, 0)]),
        ((Gap(3, 4, "a"), Gap(5, 2, "inside the one before, of a damaged file")), [(0, 0), (3, 9)]),
    ],
)
def test_each_stretch_begins_where_its_gap_ends_and_none_is_empty(
    gaps: tuple[Gap, ...], starts: list[tuple[int, int]]
) -> None:
    assert stored_starts(gaps, 10) == starts
    index = absolute_index(0, 10, gaps)
    assert all(index[stored] == absolute for stored, absolute in starts)
    assert np.count_nonzero(np.diff(index) != 1) == len(starts) - 1


@pytest.mark.parametrize("gap", [Gap(-1, 1, ""), Gap(0, 0, ""), Gap(2**53, 1, ""), Gap(0, 2**53, "")])
def test_a_gap_that_no_recording_has_is_not_possible(gap: Gap) -> None:
    assert are_possible((Gap(5, 5, ""),))
    assert not are_possible((Gap(5, 5, ""), gap))
