"""The health of an acquisition at one moment: rate, losses, queues, levels, disk, errors."""

from __future__ import annotations

from dataclasses import dataclass

from radargui.acquisition.disk import LOW_S
from radargui.acquisition.level import Level
from radargui.acquisition.state import AcquisitionState, RecorderState
from radargui.model.errors import RadarGuiError


@dataclass(frozen=True, slots=True)
class Health:
    """One snapshot; counts are samples of each channel since the start.

    Attributes
    ----------
    state, recorder
        Where acquisition and recorder are; `recorder` is None where nothing is recorded.
    sample_rate_hz
        Rate the source promises; None before it is open.
    read_rate_hz
        Rate at which samples really came, over the last seconds; None before it can be told.
    samples_read
        Samples read.
    samples_lost
        Samples that the source lost before they could be read.
    gaps
        How many times samples were lost.
    backlog_samples
        Samples that wait in the source's own buffer.
    writer_queue_samples, writer_queue_capacity_samples
        Samples that wait for the writer, and how many may.
    samples_not_written
        Samples that were read but not written, because the writer was too slow.
    samples_recorded
        Samples in the run so far.
    live_lag_s
        How far the live track is behind the newest sample; None without live track.
    live_skipped_samples
        Samples that the live track left out to keep up.
    levels
        Peak and clipping of each channel over the last moments.
    disk_free_bytes, disk_left_s
        Space left, and how long a recording could last; None where nothing is recorded.
    live_error
        Why there is no live track any more; the recording is not touched by it.
    error
        Why the acquisition failed.
    """

    state: AcquisitionState
    recorder: RecorderState | None = None
    sample_rate_hz: float | None = None
    read_rate_hz: float | None = None
    samples_read: int = 0
    samples_lost: int = 0
    gaps: int = 0
    backlog_samples: int = 0
    writer_queue_samples: int = 0
    writer_queue_capacity_samples: int = 0
    samples_not_written: int = 0
    samples_recorded: int = 0
    live_lag_s: float | None = None
    live_skipped_samples: int = 0
    levels: tuple[Level, ...] = ()
    disk_free_bytes: int | None = None
    disk_left_s: float | None = None
    live_error: RadarGuiError | None = None
    error: RadarGuiError | None = None

    @property
    def clipped(self) -> tuple[str, ...]:
        """Names of the channels that clip."""
        return tuple(level.name for level in self.levels if level.clipped)

    @property
    def disk_is_low(self) -> bool:
        """Whether less than ten minutes can still be recorded."""
        return self.disk_left_s is not None and self.disk_left_s < LOW_S

    def line(self) -> str:
        """Return the snapshot as one line for the operator."""
        parts = [f"{self.samples_read} samples"]
        if self.read_rate_hz is not None:
            parts.append(f"{self.read_rate_hz / 1e3:.1f} kS/s")
        parts.append(f"{self.samples_lost} lost" if self.samples_lost else "none lost")
        if self.samples_not_written:
            parts.append(f"{self.samples_not_written} not written")
        if self.backlog_samples:
            parts.append(f"backlog {self.backlog_samples}")
        if self.writer_queue_capacity_samples:
            parts.append(f"writer queue {self.writer_queue_samples / self.writer_queue_capacity_samples:.0%}")
        if self.live_lag_s is not None:
            parts.append(f"live {1e3 * self.live_lag_s:.0f} ms behind")
        if self.live_skipped_samples:
            parts.append(f"live skipped {self.live_skipped_samples}")
        if self.clipped:
            parts.append(f"clipping: {' '.join(self.clipped)}")
        if self.disk_left_s is not None:
            low = "LOW DISK: " if self.disk_is_low else ""
            parts.append(f"{low}disk for {_duration(self.disk_left_s)}")
        return ", ".join(parts)


def _duration(seconds: float) -> str:
    if seconds >= 7200.0:
        return f"{seconds / 3600.0:.0f} h"
    return f"{seconds / 60.0:.0f} min" if seconds >= 120.0 else f"{seconds:.0f} s"
