"""Arrays from one process to another: all of them, in memory of their own and no more, and what a closed end says."""

from __future__ import annotations

import errno
import multiprocessing
import os
import pickle
import sys
import threading
import time
import tracemalloc
from collections.abc import Iterator
from multiprocessing.connection import Connection
from pathlib import Path

import numpy as np
import pytest

from radargui.experiment.processing_apart import received_arrays, send_arrays

SIZES = (0, 1, 1000, 5_000_000, 17)


def no_memory(_name: str) -> int:
    """Share no memory, as a system that has none left."""
    raise OSError(errno.ENOMEM, "Cannot allocate memory")


@pytest.fixture(params=["as the system likes best", "through the pipe"], autouse=True)
def way(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> str:
    if request.param == "through the pipe":
        monkeypatch.setattr(os, "memfd_create", no_memory, raising=False)
    return str(request.param)


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
    theirs.send(False)
    theirs.send_bytes(b"half of it")
    theirs.close()
    with pytest.raises((EOFError, OSError)):
        received_arrays(ours, [2000])


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere arrays go through the pipe")
def test_arrays_that_find_no_shared_memory_go_through_the_pipe(
    ends: tuple[Connection, Connection], monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: object) -> int:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.pwrite", full)
    ours, theirs = ends
    send_arrays(theirs, [memoryview(b"a few"), memoryview(b"bytes")])
    assert [bytes(one) for one in received_arrays(ours, [5, 5])] == [b"a few", b"bytes"]


@pytest.mark.skipif(sys.platform != "linux", reason="memory is shared on Linux only")
def test_shared_memory_is_given_back_once_its_last_array_has_gone(
    ends: tuple[Connection, Connection], way: str
) -> None:
    def shared() -> int:
        return sum("radargui-arrays" in str(one.resolve()) for one in Path("/proc/self/fd").iterdir())

    before = shared()
    arrays = [np.arange(1 << 16), np.arange(5)]
    sender = threading.Thread(target=send_arrays, args=(ends[0], [memoryview(one).cast("B") for one in arrays]))
    sender.start()
    taken = received_arrays(ends[1], [one.nbytes for one in arrays])
    sender.join()
    last = np.frombuffer(taken.pop(), dtype=int)
    del taken
    assert (shared() > before) == (way != "through the pipe")
    assert list(last) == [0, 1, 2, 3, 4]
    del last
    # given back by a thread of its own
    ends_s = time.monotonic() + 10.0
    while shared() != before:
        assert time.monotonic() < ends_s
