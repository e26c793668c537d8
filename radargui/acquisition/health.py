"""The health of an acquisition, shown and stored with a run: rate, losses, queues, levels, disk, errors."""

import math
from dataclasses import dataclass, replace

import numpy as np

from radargui.acquisition.recorder import Recorder
from radargui.acquisition.ring import Ring
from radargui.acquisition.run_output import LOW_S, Level, levels
from radargui.acquisition.run_plan import AcquisitionState, Ending
from radargui.acquisition.stream import Peaks, Stream
from radargui.model.errors import RadarGuiError
from radargui.model.recording import Digitisation
from radargui.model.words import counted, percent
from radargui.signals.noise import MIN_SAMPLES, white_noise_v

_LAG_ALARM_S = 0.5
"""From here on a hand sees that the picture comes later."""
_QUEUE_ALARM = 0.5
"""Half full: the disk is too slow, and the other half is what is left before samples are lost."""
_RATE_TOLERANCE = 0.02
"""The rate is measured over half a second of blocks of 20 ms: it is not known better."""


@dataclass(frozen=True, slots=True)
class Status:
    """What the threads of an acquisition have to say of it; replaced as a whole, so that whoever looks sees one moment.

    Attributes
    ----------
    state
        Where it is.
    stream
        Where the samples go; None before the source is open.
    ending
        Why it is to end, STOPPED or END_OF_DATA, as was said first; None while it is not.
    live_error
        Why there is no live track any more.
    error
        Why it failed.
    """

    state: AcquisitionState = AcquisitionState.IDLE
    stream: Stream | None = None
    ending: Ending | None = None
    live_error: RadarGuiError | None = None
    error: RadarGuiError | None = None


@dataclass(frozen=True, slots=True)
class Health:
    """One snapshot; counts are samples of each channel since the start.

    Attributes
    ----------
    state
        Where the acquisition is.
    sample_rate_hz
        Rate the source promises; None before it is open.
    read_rate_hz
        Rate at which samples really came, over the last seconds; None before it is known.
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
    live_lag_s
        How far the live track is behind the newest sample; None without live track.
    live_skipped_samples
        Samples that the live track left out to keep up.
    levels
        Peak and clipping of each channel over the last moments.
    disk_free_bytes, disk_left_s
        Space left, and how long a recording could last; None where nothing is recorded.
    lost_file
        Which run file was taken away while it was written, and where the recording goes on; empty where none.
    hardly_seen
        While armed, why a fall may not start the run, in one sentence with what to do; empty where it would.
    live_error
        Why there is no live track any more; the recording is not touched by it.
    error
        Why the acquisition failed.
    """

    state: AcquisitionState
    sample_rate_hz: float | None = None
    read_rate_hz: float | None = None
    samples_read: int = 0
    samples_lost: int = 0
    gaps: int = 0
    backlog_samples: int = 0
    writer_queue_samples: int = 0
    writer_queue_capacity_samples: int = 0
    samples_not_written: int = 0
    live_lag_s: float | None = None
    live_skipped_samples: int = 0
    levels: tuple[Level, ...] = ()
    disk_free_bytes: int | None = None
    disk_left_s: float | None = None
    lost_file: str = ""
    hardly_seen: str = ""
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

    @property
    def figures(self) -> dict[str, tuple[str, bool]]:
        """Rate, losses, backlog, queue and lag, by name: in words, empty where there are none, and whether that is bad.

        The rate can be bad only while samples come in, and after a first second.
        """
        promised, real, lag = self.sample_rate_hz, self.read_rate_hz, self.live_lag_s
        slow = promised is not None and real is not None and abs(real - promised) > _RATE_TOLERANCE * promised
        counts = self.state is AcquisitionState.RUNNING and self.samples_read > (promised or 0.0)
        capacity = self.writer_queue_capacity_samples
        full = self.writer_queue_samples / max(1, capacity)
        gaps = f" in {counted(self.gaps, 'gap')}" if self.gaps else ""
        late = "" if lag is None else f"live {1e3 * lag:.0f} ms behind"
        lost = (
            f"{self.samples_lost} lost{gaps}" if self.samples_lost else "none lost",
            f"{self.samples_not_written} not written" if self.samples_not_written else "",
        )
        skipped = f"live skipped {self.live_skipped_samples}" if self.live_skipped_samples else ""
        return {
            "rate": ("" if real is None else f"{real / 1e3:.1f} kS/s", slow and counts),
            "lost": (_joined(*lost), self.samples_lost + self.samples_not_written > 0),
            "backlog": (f"backlog {self.backlog_samples}" if self.backlog_samples else "", False),
            "queue": (f"writer queue {percent(full)}" if capacity else "", full > _QUEUE_ALARM),
            "lag": (_joined(late, skipped), lag is not None and lag > _LAG_ALARM_S),
        }

    def line(self) -> str:
        """Return the snapshot as one line for the operator."""
        low = "LOW DISK: " if self.disk_is_low else ""
        parts = (
            f"{self.samples_read} samples",
            *(words for words, _ in self.figures.values()),
            f"clipping: {' '.join(self.clipped)}" if self.clipped else "",
            "" if self.disk_left_s is None else f"{low}disk for {duration(self.disk_left_s)}",
        )
        return ". ".join(filter(None, (_joined(*parts), self.hardly_seen.rstrip("."))))


def _joined(*parts: str) -> str:
    return ", ".join(filter(None, parts))


def hardly_seen(why: str) -> str:
    """Return what an operator is told whose recorder is armed in vain; `why`: see `Recorder.objection`."""
    if not why:
        return ""
    return (
        f"A fall may not start the run: {why}. Look whether the sphere hangs and transmitter and amplifiers are on, "
        "find what disturbs, or lower recording.threshold."
    )


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
        "sample_rate_hz": rate_hz,
        "read_rate_hz": health.read_rate_hz,
        "samples_read": health.samples_read,
        "samples_lost_by_source": health.samples_lost,
        "gaps_of_source": health.gaps,
        "samples_not_written": health.samples_not_written,
        "backlog_peak_samples": peaks.backlog_samples,
        "writer_queue_peak_samples": peaks.writer_queue_samples,
        "writer_queue_capacity_samples": health.writer_queue_capacity_samples,
        # the live track is no result: how far behind it was explains what the operator saw
        "live_lag_peak_s": None if rate_hz is None or health.live_lag_s is None else peaks.live_lag_samples / rate_hz,
        "live_skipped_samples": health.live_skipped_samples,
        "live_error": None if health.live_error is None else str(health.live_error),
        "disk_left_s": health.disk_left_s,
    }


def snapshot(status: Status, recorder: Recorder | None) -> Health:
    """Return the health now; `recorder` is None where nothing is recorded."""
    stream = status.stream
    free, lost_file = (None, "") if recorder is None else (recorder.disk_free_bytes, recorder.lost_file)
    why = "" if recorder is None else recorder.objection
    health = Health(
        status.state,
        disk_free_bytes=free,
        lost_file=lost_file,
        hardly_seen=hardly_seen(why),
        live_error=status.live_error,
        error=status.error,
    )
    if stream is None:
        return health
    reading, queue, worker, rate_hz = stream.reading, stream.queue, stream.worker, stream.digitisation.sample_rate_hz
    counts = reading.counts
    # as if nothing were compressed: rather warned too early
    room = None if recorder is None or free is None else max(free - recorder.minimum_free_bytes, 0)
    return replace(
        health,
        disk_left_s=None if room is None else room / stream.bytes_per_second(),
        writer_queue_samples=queue.depth if queue else 0,
        writer_queue_capacity_samples=queue.capacity if queue else 0,
        samples_not_written=queue.dropped if queue else 0,
        live_lag_s=worker.lag / rate_hz if worker else None,
        live_skipped_samples=worker.skipped if worker else 0,
        sample_rate_hz=rate_hz,
        read_rate_hz=reading.rate_hz(),
        samples_read=counts.read,
        samples_lost=counts.lost,
        gaps=counts.gaps,
        backlog_samples=reading.backlog,
        levels=stream.levels(),
    )


def duration(seconds: float) -> str:
    """Return how long that is, in words: `35 h`, `12 min`, `90 s`."""
    if seconds >= 7200.0:
        return f"{seconds / 3600.0:.0f} h"
    return f"{seconds / 60.0:.0f} min" if seconds >= 120.0 else f"{seconds:.0f} s"


MAX_SAMPLES = 1 << 16
"""Of each channel: noise is known to 0.5 % then, and a board of 1 MS/s costs no more than one of 60 kS/s."""


@dataclass(frozen=True, slots=True)
class ChannelFacts:
    """One channel.

    Attributes
    ----------
    level
        As the health line has it.
    offset_v
        Mean.
    noise_v
        Standard deviation of the white noise, as every correction takes it; NaN where too few samples tell it.
    rms_v
        Root mean square of the voltage, noise and all.
    drift_v
        Mean of the last tenth of the samples less that of the first: at rest a drift, else a motion.
    """

    level: Level
    offset_v: float
    noise_v: float
    rms_v: float = math.nan
    drift_v: float = math.nan


def snr_db(i: ChannelFacts, q: ChannelFacts) -> float:
    """Return the signal-to-noise ratio of a receiver's voltages, 10 log10(A^2 / (2 sigma^2)); NaN where unknown.

    A^2 is the mean of I^2 + Q^2 less the noise: the echo, and what stands still in the room or the mixer.
    """
    noise = i.noise_v**2 + q.noise_v**2
    signal = i.rms_v**2 + q.rms_v**2 - noise
    return 10.0 * math.log10(signal / noise) if signal > 0.0 and noise > 0.0 else math.nan


def channel_facts(ring: Ring, digitisation: Digitisation, count: int) -> tuple[ChannelFacts, ...]:
    """Return what each channel shows over the last `count` samples of a ring; none where there are no samples."""
    end = ring.latest
    blocks = ring.blocks(max(0, end - min(count, MAX_SAMPLES)), end)
    if not blocks:
        return ()
    samples = np.concatenate([block.samples for block in blocks], axis=1)
    known = np.isfinite(samples).all(axis=0)
    # sixth differences go over no gap
    longest = digitisation.volts(max(blocks, key=lambda block: block.count).samples)
    longest = longest[:, np.isfinite(longest).all(axis=0)]
    is_enough = longest.shape[1] >= MIN_SAMPLES
    noise = white_noise_v(longest) if is_enough else np.full(digitisation.n_channels, np.nan)
    volts = digitisation.volts(samples[:, known]) if known.any() else np.full((noise.size, 1), np.nan)
    tenth = max(1, volts.shape[1] // 10)
    drift = volts[:, -tenth:].mean(axis=1) - volts[:, :tenth].mean(axis=1)
    columns = volts.mean(axis=1), noise, np.sqrt((volts**2).mean(axis=1)), drift
    return tuple(map(ChannelFacts, levels(samples, digitisation), *(one.tolist() for one in columns)))
