"""Take each block from the reader, count it, and hand it to the ring and to the recorder's bounded queue.

The thread that turns samples into a live track.
"""

import math
import threading
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from radargui.acquisition.ring import Ring
from radargui.acquisition.run_output import Level, levels
from radargui.live.processor import LiveProcessor
from radargui.live.samples import LIVE_RATE_HZ
from radargui.live.track import LiveTrack
from radargui.model.errors import SourceError
from radargui.model.recording import Block, Digitisation, Gap
from radargui.model.setup import Setup
from radargui.sources.contract import Clock

LONGEST_LAG_S = 2.0
"""Catching up is many times faster than real time, and a skip loses the track until the next rest."""


class LiveWorker:
    """Turns what the ring gets into a live track, in a thread that calls `run`.

    Parameters
    ----------
    ring
        Where the samples are.
    processor
        Makes the estimates.
    track
        Where they go.
    longest_lag
        When more samples than this wait, all but the newest quarter of them are skipped.
    together
        Least number of samples that are estimated at once: the time for a block hardly depends on its length.
    """

    def __init__(
        self, ring: Ring, processor: LiveProcessor, track: LiveTrack, longest_lag: int, together: int = 1
    ) -> None:
        self._ring = ring
        self._processor = processor
        self._track = track
        self._longest_lag = max(1, min(longest_lag, ring.length // 2))
        self._together = together
        self._next = 0
        self._new = threading.Event()
        self._ended = False
        self._release_at: int | None = None
        self._fallen_at: int | None = None
        self.skipped = 0

    @property
    def lag(self) -> int:
        """Samples that wait to be estimated."""
        return self._ring.latest - self._next

    def wake(self) -> None:
        """Note that the ring has new samples; this never waits."""
        self._new.set()

    def at_release(self, index: int) -> None:
        """Note that the tracer hangs at its release and rests at absolute sample index `index`; from any thread."""
        self._release_at = index

    def fallen(self, index: int) -> None:
        """Note that a drop had ended at absolute sample index `index`; from any thread."""
        self._fallen_at = index

    def finish(self) -> None:
        """Let `run` return soon."""
        self._ended = True
        self._new.set()

    def run(self) -> None:
        """Estimate until `finish`."""
        while not self._ended:
            self._new.wait()
            self._new.clear()
            self.catch_up()

    def catch_up(self) -> None:
        """Estimate what is new in the ring."""
        end = self._ring.latest
        begin = self._next
        if end - begin < self._together and not self._ended:
            return
        if end - begin > self._longest_lag:
            # far ahead at once: a worker that skips a little is late again with the next block
            begin = end - max(1, self._longest_lag // 4)
        blocks = self._ring.blocks(begin, end)
        begin = max(begin, min(self._ring.first, end))
        self.skipped += begin - self._next
        self._next = begin
        for block in blocks:
            self._estimate(block)
        self._next = end

    def _estimate(self, block: Block) -> None:
        # with the samples, not with the clock: the tracer hangs there from this sample on
        if self._release_at is not None and block.end_index > self._release_at:
            self._release_at = None
            self._processor.at_release()
        if self._fallen_at is not None and block.end_index > self._fallen_at:
            self._fallen_at = None
            self._processor.fallen()
        self._track.append(self._processor.push(block.samples, block.first_index))


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
        # of no samples: where the queue goes on, with the gap before it
        self._after_drop: Block | None = None
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
                # lost here is lost like in the driver: a gap in the file, no samples moved together
                gap = _joined(self._after_drop, block, block.end_index)
                self._after_drop = Block(block.samples[:, :0].copy(), block.end_index, gap)
                return False
            if self._after_drop is not None:
                block = replace(block, gap=_joined(self._after_drop, block, block.first_index))
                self._after_drop = None
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
            if not self._closed and self._after_drop is not None:
                self._blocks.append(self._after_drop)
            self._closed = True
            self._changed.notify_all()

    def clear(self) -> None:
        """Throw away what waits; nobody will take it."""
        with self._changed:
            self._blocks.clear()
            self.depth = 0

    def _has_room(self, block: Block) -> bool:
        # one block always fits: a short queue would otherwise lose everything
        return self.depth == 0 or self.depth + block.count <= self.capacity


def _joined(before: Block | None, block: Block, end_index: int) -> Gap:
    """Return what is lost up to `end_index`, with the reasons of what was lost before."""
    lost = [gap for gap in (before.gap if before else None, block.gap) if gap is not None]
    first = lost[0].first_index if lost else block.first_index
    # the writer's own reason first, each once
    reasons = dict.fromkeys([TOO_SLOW, *(reason for gap in lost for reason in gap.reason.split("; ") if reason)])
    return Gap(first, end_index - first, "; ".join(reasons))


_BLOCKS_TIMED = 128
"""The rate is taken over so many: 2.6 s of blocks of 20 ms, steady to the eye; chosen by hand."""
_BACKLOG_S = 0.2
"""The driver is asked so often: a question is a call over the network with a remote device; chosen by hand."""
_SILENCE_S = 1.5
"""A source may wait about a second for a block; silence beyond that lowers the rate."""


class Counts(NamedTuple):
    """Samples of each channel that were read and lost, and in how many gaps; replaced as a whole."""

    read: int = 0
    lost: int = 0
    gaps: int = 0


class Reading:
    """Counts of one reader's thread; other threads may look."""

    def __init__(self, digitisation: Digitisation, clock: Clock) -> None:
        self._digitisation = digitisation
        self._clock = clock
        self._times: deque[tuple[float, int]] = deque(maxlen=_BLOCKS_TIMED)
        self._next = 0
        self.counts = Counts()
        self.backlog = 0
        self._backlog_asked_s = -math.inf

    def take(self, block: Block) -> None:
        """Count a block.

        Raises
        ------
        SourceError
            The block does not fit the digitisation or the samples before it: a fault of the source.
        """
        shape = block.samples.shape
        if len(shape) != 2 or shape[0] != self._digitisation.n_channels:
            raise SourceError(
                f"The source promised {self._digitisation.n_channels} channels and gave a block of shape {shape}"
            )
        if block.first_index < self._next:
            raise SourceError(f"The source gave sample {block.first_index} again after sample {self._next - 1}")
        lost, before = block.first_index - self._next, self.counts
        self.counts = Counts(before.read + block.count, before.lost + lost, before.gaps + bool(lost))
        self._next = block.end_index
        # when they came, not when they were taken: this is what the reader keeps up with
        self._times.append((self._clock.now(), self.counts.read))

    def backlog_is_due(self) -> bool:
        """Whether it is time to ask the source for its backlog again: asking may cost a way over the network."""
        now = self._times[-1][0] if self._times else self._clock.now()
        if now - self._backlog_asked_s < _BACKLOG_S:
            return False
        self._backlog_asked_s = now
        return True

    def rate_hz(self) -> float | None:
        """Return the rate over the last blocks; None before two have come."""
        times = tuple(self._times)
        if len(times) < 2:
            return None
        # a block that was fetched late is no slow sample: of both ends the most punctual one is taken
        part = max(1, len(times) // 3)
        (first_s, first), (last_s, last) = self._punctual(times[:part]), self._punctual(times[-part:])
        # a source that has fallen silent must not show the rate it had
        if self._clock.now() - times[-1][0] > _SILENCE_S:
            last_s, last = self._clock.now(), times[-1][1]
        return (last - first) / (last_s - first_s) if last_s > first_s else None

    def _punctual(self, times: tuple[tuple[float, int], ...]) -> tuple[float, int]:
        """Return when which count was reached, where that was least behind the rate promised."""
        rate_hz = self._digitisation.sample_rate_hz
        return min(times, key=lambda one: one[0] - one[1] / rate_hz)


_LEVEL_S = 0.25
"""The level meter shows so much of the past: several periods of 50 Hz, and quick to the eye; chosen by hand."""
LIVE_MARGIN_S = 4.0
"""The live track of a run is asked for once the run has ended, `LONGEST_LAG_S` late at most; chosen by hand."""
LIVE_BLOCK_S = 0.04
"""Of the live track: a third less work than in blocks of 20 ms, and sooner than the next picture but one."""
LIVE_DENSITY = 1.5
"""Most estimates for one that the live track means to make: blocks are a whole number of samples."""

MakeProcessor = Callable[[Setup, Digitisation], LiveProcessor]


@dataclass(slots=True)
class Peaks:
    """Largest values since it was made; written by the reader's thread, read by any.

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


class Stream:
    """Where the samples of one acquisition go; all memory it will need is allocated when it is made.

    Parameters
    ----------
    digitisation
        As the source that is open returned it.
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
        Whether the reader waits for the recorder where that is too slow.

    Attributes
    ----------
    reading
        Counts, and checks of the source.
    ring
        The last seconds.
    queue
        To the recorder; None where nothing is recorded.
    track, worker
        The live track and what fills it; None without.
    peaks
        How far they fell behind at worst.
    """

    def __init__(
        self,
        digitisation: Digitisation,
        setup: Setup,
        *,
        ring_s: float,
        records: bool,
        make_processor: MakeProcessor | None,
        clock: Clock,
        patient: bool,
    ) -> None:
        rate_hz, self.digitisation, self._patient = digitisation.sample_rate_hz, digitisation, patient
        self.reading, self.peaks = Reading(digitisation, clock), Peaks()
        dtype = np.float64 if digitisation.scaling is None else np.int16
        self.ring = Ring(digitisation.n_channels, math.ceil(ring_s * rate_hz), dtype, digitisation)
        self.queue = BlockQueue(math.ceil(setup.daq.buffer_s * rate_hz)) if records else None
        self.track: LiveTrack | None = None
        self.worker: LiveWorker | None = None
        if make_processor is not None:
            limits = setup.recording
            # a whole run, so that it can be compared with its result
            live_s = max(ring_s, limits.pretrigger_s + limits.maximum_s + LIVE_MARGIN_S)
            density_hz = min(rate_hz, LIVE_DENSITY * LIVE_RATE_HZ)
            self.track = LiveTrack(digitisation.n_receivers, rate_hz, live_s, density_hz)
            longest_lag = math.ceil(max(LONGEST_LAG_S, 3.0 * setup.daq.read_interval_s) * rate_hz)
            together = min(round(LIVE_BLOCK_S * rate_hz), longest_lag)
            self.worker = LiveWorker(self.ring, make_processor(setup, digitisation), self.track, longest_lag, together)

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
            # never waits for the disk on a device: its own buffer would overflow, and lose more
            self.queue.put(block, wait=self._patient)
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

    def bytes_per_second(self) -> float:
        """Return how fast a file of raw samples grows, not counting its compression."""
        n_bytes = 8 if self.digitisation.scaling is None else 2
        return self.digitisation.n_channels * self.digitisation.sample_rate_hz * n_bytes
