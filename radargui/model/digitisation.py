"""How voltages became samples: channels, rate, scale, multiplexer skew."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from radargui.model.arrays import FloatArray, RawArray
from radargui.model.daq import Daq

SkewFrom = Literal["file", "setup", "assumed 0"]


@dataclass(frozen=True, slots=True)
class Digitisation:
    """What is needed to read raw samples as volts at known times.

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
            out[channel] = np.polynomial.polynomial.polyval(samples[channel].astype(np.float64), coefficients)
        return out

    def full_scale_v(self) -> FloatArray | None:
        """Return lowest and highest voltage a code can stand for, shape (n_channels, 2); None for volts."""
        if self.scaling is None:
            return None
        ends = np.repeat(np.array([[-32768, 32767]], dtype=np.int16), self.n_channels, axis=0)
        return self.volts(ends)


@dataclass(frozen=True, slots=True)
class ChannelSkew:
    """The multiplexer's delay that is taken for true, and who tells it.

    Attributes
    ----------
    delay_s
        Delay of channel k against channel k - 1.
    known_from
        file: the samples came with it (or the device told it); setup: `daq.channel_skew_s`; assumed 0: neither tells.
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
