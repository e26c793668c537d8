"""Arrays from one process to another: all of them, in memory of their own and no more, and what a closed end says."""

from __future__ import annotations

import multiprocessing
import pickle
import threading
import tracemalloc
from collections.abc import Iterator
from multiprocessing.connection import Connection

import numpy as np
import pytest

from radargui.experiment.processing_apart import received_arrays, send_arrays

SIZES = (0, 1, 1000, 5_000_000, 17)


@pytest.fixture
def ends() -> Iterator[tuple[Connection, Connection]]:
    ours, theirs = multiprocessing.get_context("spawn").Pipe()
    yield ours, theirs
    ours.close()
    theirs.close()


def test_arrays_of_any_size_come_as_they_were_and_cannot_be_written_to(ends: tuple[Connection, Connection]) -> None:
    ours, theirs = ends
    arrays = [np.random.default_rng(size).integers(0, 256, size, dtype=np.uint8) for size in SIZES]
    sender = threading.Thread(target=send_arrays, args=(theirs, [pickle.PickleBuffer(one).raw() for one in arrays]))
    sender.start()
    found = received_arrays(ours, SIZES)
    sender.join()
    assert [bytes(one) for one in found] == [one.tobytes() for one in arrays]
    assert all(one.readonly for one in found)


def test_a_large_array_takes_its_own_memory_once_while_it_comes(ends: tuple[Connection, Connection]) -> None:
    ours, theirs = ends
    size = 32_000_000
    sender = threading.Thread(target=send_arrays, args=(theirs, [np.zeros(size, dtype=np.uint8).data]))
    tracemalloc.start()
    try:
        before = tracemalloc.get_traced_memory()[0]
        sender.start()
        (found,) = received_arrays(ours, [size])
        most = tracemalloc.get_traced_memory()[1] - before
    finally:
        tracemalloc.stop()
    sender.join()
    assert len(found) == size
    assert most < size + 4_000_000


def test_an_end_that_is_closed_before_all_has_come_is_an_error(ends: tuple[Connection, Connection]) -> None:
    ours, theirs = ends
    theirs.send_bytes(b"half of it")
    theirs.close()
    with pytest.raises((EOFError, OSError)):
        received_arrays(ours, [2000])
