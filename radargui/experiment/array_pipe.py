"""Large arrays through a pipe, into memory that was made for them, without holding Python's lock meanwhile.

`Connection.recv_bytes` takes a new piece of memory for all that is still to come with each piece that has come, and
puts the pieces together under Python's lock. Where memory is dear, as in a virtual machine, the arrays of one result
(100 MB after three seconds of 200 kS/s) then hold up the thread that draws for tenths of a second.
"""

import os
import sys
from collections.abc import Sequence
from multiprocessing.connection import Connection

import numpy as np

_PIECE = 1 << 20
"""Bytes of one message where a pipe knows messages only: copied once more, under the lock, in less than a millisecond.
Chosen by hand."""


def send_arrays(connection: Connection, arrays: Sequence[memoryview]) -> None:
    """Send the bytes of arrays; the other end is told their sizes before.

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
    return [_received(connection, size) for size in sizes]


def _received(connection: Connection, size: int) -> memoryview:
    # not a bytearray: that would fill with zeros, under the lock, what is filled here
    whole = np.empty(size, dtype=np.uint8).data
    left = whole
    while left:
        left = left[_receive(connection, left) :]
    return whole.toreadonly()


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
