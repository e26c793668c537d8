"""Signals: named channels as a file of any format holds them, before they become a recording."""

from dataclasses import dataclass, field

from radargui.model.arrays import FloatArray, RawArray
from radargui.model.block import Gap

TIME_NAME = "time_s"
"""A column or variable of this name is the file's own time of each sample."""


@dataclass(frozen=True, slots=True)
class ChannelInfo:
    """What a file says of one channel, without its samples.

    Attributes
    ----------
    name
        As the file has it, and as a channel map names it.
    count
        Number of samples.
    sample_rate_hz
        None where the file does not say.
    unit
        Empty where the file does not say.
    """

    name: str
    count: int
    sample_rate_hz: float | None = None
    unit: str = ""


@dataclass(frozen=True, slots=True)
class Signal:
    """Samples of one channel.

    Attributes
    ----------
    name
        As the file has it.
    samples
        Shape (n_samples,), int16 codes or float64 values in `unit`.
    scaling
        Coefficients c_k of value = sum c_k code^k; None for values.
    unit
        Unit of the values; empty where unknown.
    """

    name: str
    samples: RawArray = field(repr=False)
    scaling: tuple[float, ...] | None = None
    unit: str = ""


@dataclass(frozen=True, slots=True)
class Signals:
    """Channels read from one file, in the order they were asked for.

    Attributes
    ----------
    signals
        The channels.
    sample_rate_hz
        As the file's header says; None where it does not.
    time_s
        The file's own time of each sample, shape (n_samples,); None where it has none.
    gaps
        Lost samples that the file tells of.
    channel_skew_s
        Delay of each channel against the one before; None where the file does not say.
    started_at
        ISO 8601 date and time of the first sample; empty where unknown.
    device
        What digitised, for people.
    trigger_index
        Index of the trigger, lost samples counted, or None.
    """

    signals: tuple[Signal, ...]
    sample_rate_hz: float | None = None
    time_s: FloatArray | None = field(default=None, repr=False)
    gaps: tuple[Gap, ...] = ()
    channel_skew_s: float | None = None
    started_at: str = ""
    device: str = ""
    trigger_index: int | None = None
