"""A recording: all samples of one run and what is needed to read them."""

from dataclasses import dataclass, field, replace

import numpy as np

from radargui.model.arrays import BoolArray, FloatArray, IntArray, RawArray
from radargui.model.block import Gap, absolute_index
from radargui.model.digitisation import Digitisation


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
        Why not the whole is used, for people.
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

    def volts(self) -> FloatArray:
        """Return the samples as volts, shape (n_channels, n_samples)."""
        return self.digitisation.volts(self.raw)

    def clipped(self) -> BoolArray:
        """Return where a channel sits at the end of its range, shape (n_channels, n_samples)."""
        # volts do not tell where the range of the device ended
        if self.raw.dtype == np.int16:
            return np.asarray((self.raw <= -32768) | (self.raw >= 32767))
        return np.zeros(self.raw.shape, dtype=np.bool_)
