"""The ring gives volts by absolute index, NaN where samples are missing."""

from __future__ import annotations

import numpy as np
from support.controlled_source import VOLTS_PER_CODE, digitisation

from radargui.acquisition.ring import Ring
from radargui.model.recording import Block, Gap


def ring(length: int = 10) -> Ring:
    return Ring(2, length, np.int16, digitisation(1))


def block(first: int, count: int, *, gap: Gap | None = None) -> Block:
    values = np.arange(first, first + count, dtype=np.int16)
    return Block(np.stack([values, -values]), first, gap)


def test_samples_come_back_as_volts_at_their_absolute_index() -> None:
    a_ring = ring()
    a_ring.append(block(0, 4))
    a_ring.append(block(4, 3))
    span = a_ring.since(5)
    assert span.first_index == 5
    np.testing.assert_allclose(span.volts[0], np.array([5, 6]) * VOLTS_PER_CODE)
    assert a_ring.latest == 7


def test_lost_samples_are_nan() -> None:
    a_ring = ring()
    a_ring.append(block(0, 3))
    a_ring.append(block(5, 2, gap=Gap(3, 2, "overflow")))
    volts = a_ring.since(0).volts / VOLTS_PER_CODE
    np.testing.assert_allclose(volts[1], [0, -1, -2, np.nan, np.nan, -5, -6])


def test_samples_not_there_any_more_are_left_out() -> None:
    a_ring = ring(4)
    a_ring.append(block(0, 6))
    span = a_ring.since(0)
    assert span.first_index == 2
    np.testing.assert_allclose(span.volts[0] / VOLTS_PER_CODE, [2, 3, 4, 5])


def test_a_gap_longer_than_the_ring_leaves_nothing_old_behind() -> None:
    a_ring = ring(4)
    a_ring.append(block(0, 4))
    a_ring.append(block(1000, 1, gap=Gap(4, 996)))
    np.testing.assert_allclose(
        a_ring.since(a_ring.latest - 4).volts[0] / VOLTS_PER_CODE, [np.nan, np.nan, np.nan, 1000]
    )


def test_the_raw_blocks_between_gaps_are_bit_exact() -> None:
    a_ring = ring()
    a_ring.append(block(0, 3))
    a_ring.append(block(5, 2, gap=Gap(3, 2)))
    first, second = a_ring.blocks(1, 7)
    assert (first.first_index, second.first_index) == (1, 5)
    assert first.samples.dtype == np.int16
    assert first.samples[0].tolist() == [1, 2]
    assert second.samples[1].tolist() == [-5, -6]


def test_a_span_is_a_copy_that_later_samples_do_not_change() -> None:
    a_ring = ring(4)
    a_ring.append(block(0, 4))
    span = a_ring.since(0)
    a_ring.append(block(4, 4))
    np.testing.assert_allclose(span.volts[0] / VOLTS_PER_CODE, [0, 1, 2, 3])


def test_volts_stay_volts() -> None:
    a_ring = Ring(2, 8, np.float64)
    a_ring.append(Block(np.array([[0.25, np.nan], [1.0, 2.0]]), 0))
    np.testing.assert_array_equal(a_ring.since(0).volts, [[0.25, np.nan], [1.0, 2.0]])
