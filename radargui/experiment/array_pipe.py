"""Send large arrays from one process to another without holding Python's lock, on Linux without copying.

`Connection.recv_bytes` takes a new piece of memory for all that is still to come with each piece that has come, and
puts the pieces together under Python's lock. Where memory is dear, as in a virtual machine, the arrays of one result
(144 MB after three seconds of 6 x 200 kS/s) then hold up the thread that draws for tenths of a second.
"""

import mmap
import os
import sys
import weakref
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from itertools import accumulate
from multiprocessing.connection import Connection

import numpy as np

_PIECE = 1 << 20
"""Bytes of one message where a pipe knows messages only: copied once more, under the lock, in less than a millisecond.
Chosen by hand."""
_ALIGNED = 64
"""Arrays begin at multiples of so many bytes in shared memory, as numpy lays out its own."""


def send_arrays(connection: Connection, arrays: Sequence[memoryview]) -> None:
    """Send the bytes of arrays; the other end gets their sizes before.

    Parameters
    ----------
    connection
        One end of a pipe; nothing else is sent meanwhile.
    arrays
        Flat, of single bytes, as `pickle.PickleBuffer.raw` gives them.

    Raises
    ------
    OSError
        The other end is closed.
    """
    memory: int | None = None
    if sys.platform == "linux":
        memory = _shared(arrays)
    connection.send(memory is not None)
    if sys.platform == "linux" and memory is not None:
        _hand_over(connection, memory)
        return
    for array in arrays:
        left = array
        while left:
            left = left[_send(connection, left) :]


def received_arrays(connection: Connection, sizes: Sequence[int]) -> list[memoryview]:
    """Return the bytes of arrays that `send_arrays` sends, not to be written to.

    Parameters
    ----------
    connection
        The other end.
    sizes
        Bytes of each array.

    Raises
    ------
    EOFError, OSError
        The other end was closed before all had come.
    """
    if connection.recv() and sys.platform == "linux":
        whole = _taken_over(connection, sum(map(_room, sizes)))
        return [whole[end - _room(size) :][:size] for size, end in zip(sizes, _ends(sizes), strict=True)]
    return [_received(connection, size) for size in sizes]


def _room(size: int) -> int:
    return -(-size // _ALIGNED) * _ALIGNED


def _ends(sizes: Sequence[int]) -> list[int]:
    return list(accumulate(map(_room, sizes)))


def _received(connection: Connection, size: int) -> memoryview:
    # not a bytearray: that would fill with zeros, under the lock, what is filled here
    whole = np.empty(size, dtype=np.uint8).data
    left = whole
    while left:
        left = left[_receive(connection, left) :]
    return whole.toreadonly()


if sys.platform == "linux":
    from multiprocessing.reduction import recv_handle, send_handle

    _GIVING_BACK = ThreadPoolExecutor(1)

    def _shared(arrays: Sequence[memoryview]) -> int | None:
        """Return memory without a name that holds the arrays; None: there is not enough, or none to be had."""
        sizes = [array.nbytes for array in arrays]
        if not sum(sizes):
            return None
        try:
            memory = os.memfd_create("radargui-arrays")
        except OSError:
            return None
        try:
            os.ftruncate(memory, sum(map(_room, sizes)))
            for array, end in zip(arrays, _ends(sizes), strict=True):
                place, left = end - _room(array.nbytes), array
                while left:
                    count = os.pwrite(memory, left, place)
                    place, left = place + count, left[count:]
        except OSError:
            os.close(memory)
            return None
        return memory

    def _hand_over(connection: Connection, memory: int) -> None:
        try:
            send_handle(connection, memory, None)
        finally:
            os.close(memory)

    def _taken_over(connection: Connection, size: int) -> memoryview:
        """Return shared memory; it is given back, aside, when the last array in it has gone."""
        memory = recv_handle(connection)
        try:
            whole = mmap.mmap(memory, size, prot=mmap.PROT_READ)
        except BaseException:
            os.close(memory)
            raise
        # who lets go of the last array may draw: 144 MB of pages take 30 ms to give back
        weakref.finalize(whole, _GIVING_BACK.submit, os.close, memory).atexit = False
        return memoryview(whole)


if sys.platform == "win32":

    def _send(connection: Connection, data: memoryview) -> int:
        connection.send_bytes(data[:_PIECE])
        return min(len(data), _PIECE)

    def _receive(connection: Connection, room: memoryview) -> int:
        return connection.recv_bytes_into(room)

else:

    def _send(connection: Connection, data: memoryview) -> int:
        return os.write(connection.fileno(), data)

    def _receive(connection: Connection, room: memoryview) -> int:
        count = os.readv(connection.fileno(), [room])
        if count == 0:
            raise EOFError
        return count
