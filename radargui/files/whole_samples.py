"""The samples of a run file that a crash did not keep from the disk."""

from __future__ import annotations

from typing import Any


def whole_samples(raw: Any) -> int:
    """Return how many samples lie before the first chunk that a crash kept from the disk."""
    n_channels, count = raw.shape
    if raw.chunks is None:
        return int(count)
    length = raw.chunks[1]
    if raw.id.get_num_chunks() == n_channels * -(-count // length):
        return int(count)
    for first in range(0, count, length):
        for channel in range(n_channels):
            if raw.id.get_chunk_info_by_coord((channel, first)).byte_offset is None:
                return first
    return int(count)
