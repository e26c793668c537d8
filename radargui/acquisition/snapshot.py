"""Puts the health of an acquisition together from its parts."""

from __future__ import annotations

from radargui.acquisition.health import Health
from radargui.acquisition.recorder import Recorder
from radargui.acquisition.state import AcquisitionState
from radargui.acquisition.stream import Stream
from radargui.model.errors import RadarGuiError


def snapshot(
    state: AcquisitionState,
    stream: Stream | None,
    recorder: Recorder | None,
    live_error: RadarGuiError | None,
    error: RadarGuiError | None,
) -> Health:
    """Return the health now; `stream` is None before the source is open."""
    free = None if recorder is None else recorder.disk_free_bytes
    recording = None if recorder is None else recorder.state
    recorded = 0 if recorder is None else recorder.count
    if stream is None:
        return Health(state, recorder=recording, disk_free_bytes=free, live_error=live_error, error=error)
    reading, queue, worker = stream.reading, stream.queue, stream.worker
    return Health(
        state=state,
        recorder=recording,
        sample_rate_hz=stream.digitisation.sample_rate_hz,
        read_rate_hz=reading.rate_hz(),
        samples_read=reading.samples_read,
        samples_lost=reading.samples_lost,
        gaps=reading.gaps,
        backlog_samples=reading.backlog,
        writer_queue_samples=0 if queue is None else queue.depth,
        writer_queue_capacity_samples=0 if queue is None else queue.capacity,
        samples_not_written=0 if queue is None else queue.dropped,
        samples_recorded=recorded,
        live_lag_s=stream.live_lag_s(),
        live_skipped_samples=0 if worker is None else worker.skipped,
        levels=stream.levels(),
        disk_free_bytes=free,
        disk_left_s=None if free is None or recorder is None else _left_s(free, recorder, stream),
        live_error=live_error,
        error=error,
    )


def _left_s(free: int, recorder: Recorder, stream: Stream) -> float:
    return max(free - recorder.minimum_free_bytes, 0) / stream.bytes_per_second()
