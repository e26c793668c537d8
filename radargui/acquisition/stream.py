"""The stream: what the reader hands each block to, made when the source is open."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from radargui.acquisition.block_queue import BlockQueue
from radargui.acquisition.level import Level, levels
from radargui.acquisition.live_track import LiveTrack
from radargui.acquisition.live_worker import LONGEST_LAG_S, LiveWorker
from radargui.acquisition.reading import Reading
from radargui.acquisition.ring import Ring
from radargui.model.block import Block
from radargui.model.digitisation import Digitisation
from radargui.model.setup import Setup
from radargui.processing.live import LiveProcessor
from radargui.processing.live_samples import LIVE_RATE_HZ
from radargui.sources.clock import Clock

_LEVEL_S = 0.25
"""The level meter shows so much of the past: several periods of 50 Hz, and quick to the eye; chosen by hand."""
LIVE_MARGIN_S = 4.0
"""The live track of a run is asked for once the run has ended, `LONGEST_LAG_S` late at most; chosen by hand."""
LIVE_DENSITY = 1.5
"""Most estimates for one that the live track means to make: blocks are a whole number of samples."""

MakeProcessor = Callable[[Setup, Digitisation], LiveProcessor]


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


@dataclass(frozen=True, slots=True)
class Stream:
    """Where the samples of one acquisition go.

    Attributes
    ----------
    digitisation
        As the source returned it.
    reading
        Counts, and checks of the source.
    ring
        The last seconds.
    queue
        To the recorder; None where nothing is recorded.
    track, worker
        The live track and what fills it; None without.
    patient
        Whether the reader waits for the recorder where that is too slow.
    peaks
        How far they fell behind at worst.
    """

    digitisation: Digitisation
    reading: Reading
    ring: Ring
    queue: BlockQueue | None
    track: LiveTrack | None
    worker: LiveWorker | None
    patient: bool
    peaks: Peaks = field(default_factory=Peaks)

    def take(self, block: Block) -> None:
        """Hand a block on; the reader's thread only.

        Raises
        ------
        SourceError
            The block does not fit what the source promised.
        """
        self.reading.take(block)
        self.ring.append(block)
        if self.queue is not None:
            self.queue.put(block, wait=self.patient)
        if self.worker is not None:
            self.worker.wake()
        self.peaks.note(
            self.reading.backlog,
            0 if self.queue is None else self.queue.depth,
            0 if self.worker is None else self.worker.lag,
        )

    def close(self) -> None:
        """Tell recorder and live worker that no block follows."""
        if self.queue is not None:
            self.queue.close()
        if self.worker is not None:
            self.worker.finish()

    def levels(self) -> tuple[Level, ...]:
        """Return the level of each channel over the last moments; none where there are no samples."""
        end = self.ring.latest
        blocks = self.ring.blocks(end - math.ceil(_LEVEL_S * self.digitisation.sample_rate_hz), end)
        if not blocks:
            return ()
        return levels(np.concatenate([block.samples for block in blocks], axis=1), self.digitisation)

    def live_lag_s(self) -> float | None:
        """Return how far the live track is behind the newest sample; None without live track."""
        return None if self.worker is None else self.worker.lag / self.digitisation.sample_rate_hz

    def bytes_per_second(self) -> float:
        """Return how fast a file of raw samples grows, not counting its compression."""
        n_bytes = 8 if self.digitisation.scaling is None else 2
        return self.digitisation.n_channels * self.digitisation.sample_rate_hz * n_bytes


def make_stream(
    digitisation: Digitisation,
    setup: Setup,
    *,
    ring_s: float,
    records: bool,
    make_processor: MakeProcessor | None,
    clock: Clock,
    patient: bool,
) -> Stream:
    """Return the stream of a source that is open; all memory it will need is allocated here.

    Parameters
    ----------
    digitisation
        As the source returned it.
    setup
        For the live processor and the length of the queue (`daq.buffer_s`).
    ring_s
        Seconds that ring and live track hold.
    records
        Whether there is a recorder.
    make_processor
        Makes the live processor; None: no live track.
    clock
        For the rate at which samples come.
    patient
        Whether the reader waits for the recorder.
    """
    rate_hz = digitisation.sample_rate_hz
    dtype = np.float64 if digitisation.scaling is None else np.int16
    ring = Ring(digitisation.n_channels, math.ceil(ring_s * rate_hz), dtype, digitisation)
    track = worker = None
    if make_processor is not None:
        limits = setup.recording
        # a whole run, so that it can be compared with its result
        live_s = max(ring_s, limits.pretrigger_s + limits.maximum_s + LIVE_MARGIN_S)
        track = LiveTrack(digitisation.n_receivers, rate_hz, live_s, min(rate_hz, LIVE_DENSITY * LIVE_RATE_HZ))
        longest_lag_s = max(LONGEST_LAG_S, 3.0 * setup.daq.read_interval_s)
        worker = LiveWorker(ring, make_processor(setup, digitisation), track, math.ceil(longest_lag_s * rate_hz))
    return Stream(
        digitisation=digitisation,
        reading=Reading(digitisation, clock),
        ring=ring,
        queue=BlockQueue(math.ceil(setup.daq.buffer_s * rate_hz)) if records else None,
        track=track,
        worker=worker,
        patient=patient,
    )
