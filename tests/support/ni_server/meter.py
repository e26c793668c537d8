"""What the stand-in server counts while it streams: a reader's delay as the driver sees it."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass
class Meter:
    """Counts of all tasks of a server.

    Attributes
    ----------
    reads, samples
        Reads answered, and samples of each channel given.
    longest_backlog_s
        The longest that an acquired sample waited when a read came; by the rate of its task.
    overwritten
        How often the buffer was overwritten.
    started_at_s
        Marks of the pace at which tasks were started.
    """

    reads: int = 0
    samples: int = 0
    longest_backlog_s: float = 0.0
    overwritten: int = 0
    started_at_s: list[float] = field(default_factory=list)
