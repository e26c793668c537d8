"""The peaks: how far reader, writer and live track fell behind at worst, since they were asked for last."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(slots=True)
class Peaks:
    """Largest values since `clear`; written by the reader's thread, read by any.

    Attributes
    ----------
    backlog_samples
        Samples that waited in the source's own buffer.
    writer_queue_samples
        Samples that waited for the writer.
    live_lag_samples
        Samples that waited for the live track.
    """

    backlog_samples: int = 0
    writer_queue_samples: int = 0
    live_lag_samples: int = 0

    def note(self, backlog: int, writer_queue: int, live_lag: int) -> None:
        """Take the present values."""
        self.backlog_samples = max(self.backlog_samples, backlog)
        self.writer_queue_samples = max(self.writer_queue_samples, writer_queue)
        self.live_lag_samples = max(self.live_lag_samples, live_lag)

    def clear(self) -> None:
        """Begin anew."""
        self.backlog_samples = self.writer_queue_samples = self.live_lag_samples = 0
