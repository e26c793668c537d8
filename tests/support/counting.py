"""Work for other cores: a module of its own, which a process can import."""

from __future__ import annotations

import os
import signal

PARTS = 4
"""Pieces of work from which on other processes are begun."""


def process_of(piece: int) -> tuple[int, int]:
    """Return a piece with the process that was asked; less than nothing is a fault."""
    if piece < 0:
        raise ZeroDivisionError
    return piece, os.getpid()


def killed_beside(here: int) -> int:
    """Return the process that does this; any but `here` is killed by it."""
    if os.getpid() != here:
        os.kill(os.getpid(), signal.SIGKILL)
    return here
