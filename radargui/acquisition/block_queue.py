"""The bounded queue between reader and recorder: a put never waits, what does not fit becomes a gap."""

import threading
from collections import deque
from dataclasses import replace

from radargui.model.block import Block, Gap

TOO_SLOW = "the writer was too slow"


class BlockQueue:
    """Blocks on their way to the recorder, at most `capacity` samples of each channel.

    Parameters
    ----------
    capacity
        Samples of each channel; one block is always let in, however long.

    Attributes
    ----------
    capacity
        Samples of each channel that fit.
    depth
        Samples of each channel that wait.
    dropped
        Samples of each channel that did not fit, since the start.
    """

    def __init__(self, capacity: int) -> None:
        self.capacity = capacity
        self._blocks: deque[Block] = deque()
        self._changed = threading.Condition()
        self.depth = 0
        self.dropped = 0
        self._dropped_gap: Gap | None = None
        self._dropped_last: Block | None = None
        self._closed = False

    def put(self, block: Block, *, wait: bool = False) -> bool:
        """Hand over a block; False where there was no room and it is lost.

        Parameters
        ----------
        block
            Follows the block before.
        wait
            Wait for room instead of losing the block: only for a source that loses nothing meanwhile.
        """
        with self._changed:
            if wait:
                self._changed.wait_for(lambda: self._closed or self._has_room(block))
            if self._closed:
                return False
            if not self._has_room(block):
                self.dropped += block.count
                self._dropped_gap = _joined(self._dropped_gap, block, with_samples=True)
                self._dropped_last = Block(block.samples[:, :0].copy(), block.end_index)
                return False
            if self._dropped_gap is not None:
                block = replace(block, gap=_joined(self._dropped_gap, block, with_samples=False))
                self._dropped_gap = None
            self._blocks.append(block)
            self.depth += block.count
            self._changed.notify_all()
            return True

    def get(self, timeout_s: float | None = None) -> Block | None:
        """Return the next block, waiting for it; None where the queue is closed and empty or the time is over."""
        with self._changed:
            self._changed.wait_for(lambda: bool(self._blocks) or self._closed, timeout_s)
            if not self._blocks:
                return None
            block = self._blocks.popleft()
            self.depth -= block.count
            self._changed.notify_all()
            return block

    def close(self) -> None:
        """Let no more in; what waits can still be taken, at last an empty block that tells what was dropped."""
        with self._changed:
            if not self._closed and self._dropped_gap is not None and self._dropped_last is not None:
                self._blocks.append(
                    Block(self._dropped_last.samples, self._dropped_last.first_index, self._dropped_gap)
                )
            self._closed = True
            self._changed.notify_all()

    def clear(self) -> None:
        """Throw away what waits; nobody will take it."""
        with self._changed:
            self._blocks.clear()
            self.depth = 0

    def _has_room(self, block: Block) -> bool:
        return self.depth == 0 or self.depth + block.count <= self.capacity


def _joined(gap: Gap | None, block: Block, *, with_samples: bool) -> Gap:
    """Return one gap over `gap`, the block's own gap and, where dropped, the block itself."""
    first = gap.first_index if gap else (block.gap.first_index if block.gap else block.first_index)
    end = block.end_index if with_samples else block.first_index
    reasons = [TOO_SLOW]
    if gap is not None:
        reasons = gap.reason.split("; ")
    if block.gap is not None and block.gap.reason and block.gap.reason not in reasons:
        reasons.append(block.gap.reason)
    return Gap(first, end - first, "; ".join(reasons))
