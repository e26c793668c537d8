"""The circular buffer holds exactly the last columns, also while it is written."""

from __future__ import annotations

import threading
import tracemalloc

import numpy as np
from hypothesis import given, strategies as st

from radargui.model.arrays import CircularBuffer


@given(st.integers(1, 17), st.lists(st.integers(0, 40), max_size=12), st.integers(-5, 200), st.integers(0, 60))
def test_a_copy_is_what_was_written_as_far_as_it_is_held(length: int, sizes: list[int], first: int, count: int) -> None:
    buffer = CircularBuffer(2, length, np.int64)
    written = np.arange(sum(sizes))
    begin = 0
    for size in sizes:
        buffer.extend(np.stack([written[begin : begin + size], -written[begin : begin + size]]))
        begin += size
    at, columns = buffer.copy(first, first + count)
    expected = [value for value in range(max(0, first), first + count) if begin - length <= value < begin]
    assert columns.tolist() == [expected, [-value for value in expected]]
    assert at == expected[0] if expected else columns.shape[1] == 0
    assert buffer.end == begin


@given(st.integers(1, 9), st.integers(0, 30), st.integers(0, 30))
def test_a_filled_stretch_holds_its_value(length: int, before: int, filled: int) -> None:
    buffer = CircularBuffer(1, length, np.float64)
    buffer.extend(np.ones((1, before)))
    buffer.fill(filled, 5.0)
    _, columns = buffer.copy(0, before + filled)
    expected = ([1.0] * before + [5.0] * filled)[-length:]
    assert columns[0].tolist() == expected


def test_a_copy_made_while_the_writer_laps_it_never_holds_torn_columns() -> None:
    buffer = CircularBuffer(2, 64, np.int64)
    stop = threading.Event()

    def write() -> None:
        index = 0
        while not stop.is_set():
            buffer.extend(np.stack([np.arange(index, index + 7)] * 2))
            index += 7

    writer = threading.Thread(target=write)
    writer.start()
    try:
        for _ in range(3000):
            end = buffer.end
            first, columns = buffer.copy(end - 60, end)
            expected = np.arange(first, first + columns.shape[1])
            assert np.array_equal(columns, np.stack([expected] * 2))
    finally:
        stop.set()
        writer.join()


def test_the_memory_is_allocated_once() -> None:
    buffer, samples = CircularBuffer(2, 1_000_000, np.int16), np.ones((2, 10_000), dtype=np.int16)
    tracemalloc.start()
    try:
        for _ in range(250):
            buffer.extend(samples)
        buffer.fill(10**12, 0)
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    # of the 4 MB that it holds nothing is made anew
    assert peak < 400_000
