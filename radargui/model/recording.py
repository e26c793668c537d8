"""A recording: blocks as they arrive, how voltages became samples, and the samples of a run with its truth."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from operator import attrgetter
from typing import Literal

import numpy as np

from radargui.model.arrays import BoolArray, FloatArray, IntArray, RawArray, pieces
from radargui.model.daq import Daq


@dataclass(frozen=True, slots=True)
class Gap:
    """Samples that were lost.

    Attributes
    ----------
    first_index
        Absolute index of the first lost sample (counting lost ones too).
    count
        How many samples of each channel were lost.
    reason
        Why, in a few words.
    """

    first_index: int
    count: int
    reason: str = ""


@dataclass(frozen=True, slots=True)
class Marker:
    """An operator's note at a sample (counted from the first, lost samples included)."""

    index: int
    text: str


@dataclass(frozen=True, slots=True)
class Block:
    """Consecutive samples of all channels.

    Attributes
    ----------
    samples
        Shape (n_channels, n), int16 codes or float64 volts; owned by the block, never reused by its maker.
    first_index
        Absolute index of the first sample; time = index / rate.
    gap
        Samples lost just before this block, or None.
    trigger_index
        Absolute index of the edge at which the device started, reported with the first block; may lie after it. None
        where the device waited for none.
    """

    samples: RawArray
    first_index: int
    gap: Gap | None = None
    trigger_index: int | None = None

    @property
    def count(self) -> int:
        """Number of samples of each channel."""
        return int(self.samples.shape[1])

    @property
    def end_index(self) -> int:
        """Absolute index after the last sample."""
        return self.first_index + self.count


def absolute_index(first: int, count: int, gaps: Sequence[Gap]) -> IntArray:
    """Return the index, lost samples counted, of the stored samples `first` to `first + count`."""
    index = np.arange(first, first + count, dtype=np.int64)
    # in order: where a gap begins counts what earlier ones lost
    for gap in sorted(gaps, key=attrgetter("first_index")):
        index[index >= gap.first_index] += gap.count
    return index


LARGEST_INDEX = 2**53
"""No recording is that long: 28 years at 10 MS/s."""


def are_possible(gaps: Sequence[Gap]) -> bool:
    """Return whether gaps can be those of a recording: none negative or empty, none beyond any recording."""
    return (
        all(0 <= gap.first_index < LARGEST_INDEX and gap.count >= 1 for gap in gaps)
        and sum(gap.count for gap in gaps) < LARGEST_INDEX
    )


def stored_starts(gaps: Sequence[Gap], n_samples: int) -> list[tuple[int, int]]:
    """Return for each gapless stretch the stored number and the absolute index of its first sample."""
    starts, lost = [(0, 0)], 0
    for gap in sorted(gaps, key=attrgetter("first_index")):
        # gaps of a damaged file may overlap: the samples stay in order
        stored = max(gap.first_index - lost, starts[-1][0])
        lost += gap.count
        if stored >= n_samples:
            break
        # two gaps without a sample between them are one
        if stored == starts[-1][0]:
            starts.pop()
        starts.append((stored, stored + lost))
    return starts


def at_rail(samples: RawArray) -> BoolArray:
    """Return which samples sat at the end of the converter's range; none of those that are volts."""
    # volts do not tell where the range of the device ended, and most recordings never reach it
    if samples.dtype != np.int16 or not samples.size or (samples.max() < 32767 and samples.min() > -32768):
        return np.zeros(samples.shape, dtype=np.bool_)
    return np.asarray((samples <= -32768) | (samples >= 32767))


SkewFrom = Literal["file", "setup", "assumed 0"]


@dataclass(frozen=True, slots=True)
class Digitisation:
    """How raw samples become volts at known times.

    Attributes
    ----------
    channel_names
        One name a channel in storage order: I1, Q1, I2, Q2, ...
    sample_rate_hz
        Samples per second of each channel.
    scaling
        Per channel the coefficients c_k of volts = sum c_k code^k; None where samples are volts already.
    channel_skew_s
        Channel k is sampled k times this later than channel 0 (0 for simultaneous sampling); None where the samples
        come without it, as from most files of others: `channel_skew` then asks the setup.
    unit
        Unit after scaling.
    device
        What digitised, for people: product, serial number or "simulated".
    """

    channel_names: tuple[str, ...]
    sample_rate_hz: float
    scaling: tuple[tuple[float, ...], ...] | None = None
    channel_skew_s: float | None = None
    unit: str = "V"
    device: str = ""

    @property
    def n_channels(self) -> int:
        """Number of channels."""
        return len(self.channel_names)

    @property
    def n_receivers(self) -> int:
        """Number of IQ pairs."""
        return len(self.channel_names) // 2

    def volts(self, samples: RawArray) -> FloatArray:
        """Return samples (n_channels, n) as volts, volts = sum c_k code^k per channel."""
        if self.scaling is None:
            return np.asarray(samples, dtype=np.float64)
        out = np.empty(samples.shape, dtype=np.float64)
        # each input of a board is calibrated by itself
        for channel, coefficients in enumerate(self.scaling):
            # by Horner's rule, in place
            row, codes = out[channel], np.asarray(samples[channel], dtype=np.float64)
            *lower, highest = coefficients
            row[...] = highest if not lower else codes * highest + lower.pop()
            for coefficient in reversed(lower):
                row *= codes
                row += coefficient
        return out

    def full_scale_v(self) -> FloatArray | None:
        """Return lowest and highest voltage a code can stand for, shape (n_channels, 2); None for volts."""
        if self.scaling is None:
            return None
        ends = np.repeat(np.array([[-32768, 32767]], dtype=np.int16), self.n_channels, axis=0)
        return self.volts(ends)


@dataclass(frozen=True, slots=True)
class ChannelSkew:
    """The multiplexer's delay that is used, and its origin.

    Attributes
    ----------
    delay_s
        Delay of channel k against channel k - 1.
    known_from
        file: the samples came with it (or the device stated it); setup: `daq.channel_skew_s`; assumed 0: neither does.
    """

    delay_s: float
    known_from: SkewFrom


def channel_skew(digitisation: Digitisation, daq: Daq) -> ChannelSkew:
    """Return the delay between neighbouring channels: what came with the samples, else the setup's, else 0."""
    # what the device said while it sampled goes before what somebody wrote later
    if digitisation.channel_skew_s is not None:
        return ChannelSkew(digitisation.channel_skew_s, "file")
    # a default is no knowledge: only what was written counts
    if "channel_skew_s" in daq.model_fields_set:
        return ChannelSkew(daq.channel_skew_s, "setup")
    return ChannelSkew(0.0, "assumed 0")


def iq_names(n_receivers: int) -> tuple[str, ...]:
    """Return the canonical channel names I1, Q1, ... of `n_receivers` pairs."""
    return tuple(f"{part}{number}" for number in range(1, n_receivers + 1) for part in "IQ")


@dataclass(frozen=True, slots=True)
class Truth:
    """Exact motion of the simulated tracer at the times of channel 0.

    Attributes
    ----------
    position_m
        Shape (3, n_samples).
    path_m
        Shape (n_receivers, n_samples).
    impact_time_s
        Shape (n_impacts,), from the first sample.
    """

    position_m: FloatArray
    path_m: FloatArray
    impact_time_s: FloatArray


@dataclass(frozen=True, slots=True)
class Excerpt:
    """Where the samples of an excerpt lie in the whole recording.

    Attributes
    ----------
    first_stored, last_stored
        It holds the stored samples first:last of the whole.
    first_index
        Number of samples before it, lost ones counted.
    of_samples
        Stored samples of each channel of the whole recording.
    reason
        Why only a part is used, for people.
    """

    first_stored: int
    last_stored: int
    first_index: int
    of_samples: int
    reason: str


@dataclass(frozen=True, slots=True)
class Recording:
    """Raw samples of one run.

    Attributes
    ----------
    name
        Stem of the file it came from.
    raw
        Shape (n_channels, n_samples), int16 codes or float64 volts, without the lost samples.
    digitisation
        Channels, rate, scale, skew.
    gaps
        Lost samples; a gap's `first_index` counts from the recording's first sample, lost samples included.
    file_time_s
        The file's own time of each sample, shape (n_samples,); None where time = index / rate.
    trigger_index
        Index of the trigger (t = 0 of the run), or None; of an excerpt too, it counts from the whole's first sample.
    started_at
        ISO 8601 date and time of the first sample (of the whole), with the offset from UTC where it is known; empty
        where nothing is known.
    excerpt
        Set where these samples are a part of a longer recording; gaps then count from the part's first sample, times
        and indices from the whole's.
    """

    name: str
    raw: RawArray
    digitisation: Digitisation
    gaps: tuple[Gap, ...] = ()
    file_time_s: FloatArray | None = field(default=None, repr=False)
    trigger_index: int | None = None
    started_at: str = ""
    excerpt: Excerpt | None = None

    @property
    def n_samples(self) -> int:
        """Number of samples of each channel that were read."""
        return int(self.raw.shape[1])

    @property
    def n_receivers(self) -> int:
        """Number of IQ pairs."""
        return self.digitisation.n_receivers

    def index(self) -> IntArray:
        """Return the index of each sample, shape (n_samples,), lost samples counted."""
        index = absolute_index(0, self.n_samples, self.gaps)
        return index if self.excerpt is None else index + self.excerpt.first_index

    def time_s(self) -> FloatArray:
        """Return the time of each sample in s, shape (n_samples,): the file's own, else index / rate."""
        # the file may know better: its clock, not a rate with few digits
        if self.file_time_s is not None:
            return self.file_time_s
        return self.index() / self.digitisation.sample_rate_hz

    def gaps_of_whole(self) -> tuple[Gap, ...]:
        """Return the gaps with indices as `index` counts them: of an excerpt too, from the whole's first sample."""
        # an excerpt keeps the clock of the whole: results of both can be laid over one another
        before = 0 if self.excerpt is None else self.excerpt.first_index
        return tuple(replace(gap, first_index=gap.first_index + before) for gap in self.gaps)

    def stretches(self) -> Iterator[tuple[slice, int]]:
        """Yield the runs of stored samples between which nothing was lost, each with the index of its first sample."""
        starts = stored_starts(self.gaps, self.n_samples)
        for (first, index), (last, _) in pairwise([*starts, (self.n_samples, 0)]):
            if last > first:
                yield slice(first, last), index

    def blocks(self, length: int) -> Iterator[Block]:
        """Yield the samples in blocks of at most `length`, each gapless and with the gap before it, where one is."""
        reasons = {gap.first_index: gap.reason for gap in reversed(self.gaps)}
        end_index = 0
        for stretch, index in self.stretches():
            gap = Gap(end_index, index - end_index, reasons.get(end_index, "")) if index > end_index else None
            first, count = stretch.start, stretch.stop - stretch.start
            end_index = index + count
            for part in pieces(count, length):
                yield Block(self.raw[:, first + part.start : first + part.stop], index + part.start, gap)
                gap = None

    def volts(self) -> FloatArray:
        """Return the samples as volts, shape (n_channels, n_samples)."""
        return self.digitisation.volts(self.raw)

    def clipped(self) -> BoolArray:
        """Return where a channel sits at the end of its range, shape (n_channels, n_samples)."""
        return at_rail(self.raw)


def as_excerpt(part: Recording, gaps: Sequence[Gap], first: int, of_samples: int, reason: str) -> Recording:
    """Return samples that begin at stored sample `first` of a recording with its gaps there and their place in it.

    Parameters
    ----------
    part
        The samples, gaps left out.
    gaps
        Of the whole recording.
    first, of_samples, reason
        As in `Excerpt`.
    """
    # gaps count lost samples as well, the file stores none of them
    first_index, last_index = (int(absolute_index(n, 1, gaps)[0]) for n in (first, first + part.n_samples - 1))
    inside = sorted((gap for gap in gaps if first_index < gap.first_index < last_index), key=attrgetter("first_index"))
    return replace(
        part,
        gaps=tuple(replace(gap, first_index=gap.first_index - first_index) for gap in inside),
        excerpt=Excerpt(first, first + part.n_samples, first_index, of_samples, reason),
    )
