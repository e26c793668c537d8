"""The health record of a run: what is kept in its file about how it was recorded."""

from __future__ import annotations

from radargui.acquisition.health import Health
from radargui.acquisition.peaks import Peaks


def health_record(health: Health, peaks: Peaks) -> dict[str, object]:
    """Return a table that JSON can hold; counts are samples of each channel, peaks those since the run was armed.

    Parameters
    ----------
    health
        At the end of the run.
    peaks
        How far reader, writer and live track fell behind at worst.
    """
    rate_hz = health.sample_rate_hz
    return {
        "line": health.line(),
        "sample_rate_hz": rate_hz,
        "read_rate_hz": health.read_rate_hz,
        "samples_read": health.samples_read,
        "samples_lost_by_source": health.samples_lost,
        "gaps_of_source": health.gaps,
        "samples_not_written": health.samples_not_written,
        "backlog_peak_samples": peaks.backlog_samples,
        "writer_queue_peak_samples": peaks.writer_queue_samples,
        "writer_queue_capacity_samples": health.writer_queue_capacity_samples,
        "live_lag_peak_s": None if rate_hz is None or health.live_lag_s is None else peaks.live_lag_samples / rate_hz,
        "live_skipped_samples": health.live_skipped_samples,
        "live_error": None if health.live_error is None else str(health.live_error),
        "disk_left_s": health.disk_left_s,
    }
