"""The pre-trigger history: the blocks of the last moments, kept while armed."""

from __future__ import annotations

from collections import deque

from radargui.model.block import Block, Gap


class History:
    """The last `length` samples (lost ones counted) as whole blocks."""

    def __init__(self, length: int) -> None:
        self._length = length
        self._blocks: deque[Block] = deque()

    def push(self, block: Block) -> None:
        """Add a block; forget those that are older than the history is long."""
        self._blocks.append(block)
        oldest = block.end_index - self._length
        while self._blocks[0].end_index <= oldest and len(self._blocks) > 1:
            self._blocks.popleft()

    def since(self, index: int) -> tuple[Block, ...]:
        """Return all samples held from absolute index `index` on; they stay, for the next run may need them too."""
        return tuple(cut(block, index, block.end_index) for block in self._blocks if block.end_index > index)


def cut(block: Block, first: int, last: int) -> Block:
    """Return the part of a block that lies in absolute indices first:last; a gap before it is cut as well."""
    low = min(max(first - block.first_index, 0), block.count)
    high = min(max(last - block.first_index, low), block.count)
    gap = block.gap if low == 0 else None
    if gap is not None and gap.first_index < first:
        end = gap.first_index + gap.count
        gap = Gap(first, end - first, gap.reason) if end > first else None
    return Block(block.samples[:, low:high], block.first_index + low, gap)
