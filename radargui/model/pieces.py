"""Pieces of long arrays: work on them stays in the processor's cache, and needs little memory beside its result."""

from __future__ import annotations

from collections.abc import Iterator

_PIECE = 1 << 14


def pieces(count: int) -> Iterator[slice]:
    """Yield slices that cover `count` samples."""
    for first in range(0, count, _PIECE):
        yield slice(first, min(first + _PIECE, count))
