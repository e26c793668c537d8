"""Pieces of long arrays: work on them stays in the processor's cache, and needs little memory beside its result."""

from __future__ import annotations

from collections.abc import Iterator

_PIECE = 1 << 14


def pieces(count: int, size: int = _PIECE) -> Iterator[slice]:
    """Yield slices of at most `size` that cover `count` samples."""
    for first in range(0, count, size):
        yield slice(first, min(first + size, count))
