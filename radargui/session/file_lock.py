"""A lock on an open file that the system lets go of when the process ends, however it ends."""

from __future__ import annotations

import errno
import sys

_FAR = 1 << 40
"""Where Windows locks: behind all content, which others can then still read."""
_TAKEN = {errno.EACCES, errno.EAGAIN, errno.EWOULDBLOCK, errno.EDEADLK}

if sys.platform == "win32":
    import msvcrt
    import os

    def _lock(descriptor: int) -> None:
        os.lseek(descriptor, _FAR, os.SEEK_SET)
        msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)

else:
    import fcntl

    def _lock(descriptor: int) -> None:
        # not lockf: that one belongs to the process and is lost when any other descriptor of the file is closed
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)


def try_lock(descriptor: int) -> bool | None:
    """Lock an open file without waiting.

    Returns
    -------
    bool or None
        False where somebody else holds it; None where this file system knows no locks.
    """
    try:
        _lock(descriptor)
    except OSError as error:
        return False if error.errno in _TAKEN else None
    return True
