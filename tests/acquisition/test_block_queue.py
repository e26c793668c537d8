"""The queue to the recorder never makes the reader wait and tells what it had to drop."""

from __future__ import annotations

import threading

import numpy as np

from radargui.acquisition.stream import TOO_SLOW, BlockQueue
from radargui.model.recording import Block, Gap


def block(first: int, count: int = 10, gap: Gap | None = None) -> Block:
    return Block(np.zeros((2, count), dtype=np.int16), first, gap)


def test_blocks_come_out_in_order() -> None:
    queue = BlockQueue(100)
    for first in (0, 10, 20):
        assert queue.put(block(first))
    assert queue.depth == 30
    assert [taken.first_index for _ in range(3) if (taken := queue.get())] == [0, 10, 20]
    assert queue.depth == 0


def test_a_full_queue_drops_and_tells_it_before_the_next_block() -> None:
    queue = BlockQueue(20)
    queue.put(block(0))
    queue.put(block(10))
    assert not queue.put(block(20))
    assert not queue.put(block(30))
    assert queue.dropped == 20
    queue.get()
    assert queue.put(block(40))
    queue.get()
    taken = queue.get()
    assert taken is not None
    assert taken.gap == Gap(20, 20, TOO_SLOW)


def test_a_gap_of_the_source_and_dropped_blocks_become_one_gap_with_both_reasons() -> None:
    queue = BlockQueue(10)
    queue.put(block(0))
    queue.put(block(15, gap=Gap(10, 5, "overflow")))
    queue.get()
    queue.put(block(30, gap=Gap(25, 5, "overflow")))
    taken = queue.get()
    assert taken is not None
    assert taken.gap == Gap(10, 20, f"{TOO_SLOW}; overflow")


def test_what_was_dropped_last_is_told_by_an_empty_block_at_the_end() -> None:
    queue = BlockQueue(10)
    queue.put(block(0))
    queue.put(block(10))
    queue.close()
    queue.get()
    last = queue.get()
    assert last is not None
    assert (last.count, last.first_index, last.gap) == (0, 20, Gap(10, 10, TOO_SLOW))
    assert queue.get() is None


def test_a_block_longer_than_the_queue_is_still_let_in() -> None:
    queue = BlockQueue(5)
    assert queue.put(block(0, 50))


def test_a_closed_queue_takes_nothing_and_counts_nothing() -> None:
    queue = BlockQueue(50)
    queue.close()
    assert not queue.put(block(0))
    assert queue.dropped == 0


def test_a_patient_put_waits_for_room() -> None:
    queue = BlockQueue(10)
    queue.put(block(0))
    putter = threading.Thread(target=lambda: queue.put(block(10), wait=True))
    putter.start()
    first, second = queue.get(20.0), queue.get(20.0)
    putter.join()
    assert first is not None
    assert second is not None
    assert second.first_index == 10
    assert queue.dropped == 0


def test_closing_frees_a_patient_put() -> None:
    queue = BlockQueue(10)
    queue.put(block(0))
    answers: list[bool] = []
    putter = threading.Thread(target=lambda: answers.append(queue.put(block(10), wait=True)))
    putter.start()
    queue.close()
    putter.join(20.0)
    assert answers == [False]
