"""The conditioned signals: one stretch without gaps, with all that is measured before a correction."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from radargui.model.arrays import BoolArray, FloatArray
from radargui.model.finding import Finding
from radargui.model.result import Segment
from radargui.physics.path_length import MIN_RECEIVERS
from radargui.signals.doppler import Doppler

if TYPE_CHECKING:
    # loads what only one or two receivers need
    from radargui.signals.echo import Echo


_BY_CHANNEL = ("volts", "at_one_time_v", "usable", "opened", "noise_v", "delay_s")
_BY_RECEIVER = ("doppler", "echoes", "faults")


@dataclass(frozen=True, slots=True)
class Conditioned:
    """The signals and measurements that every correction and estimate starts from.

    Later steps do not measure them again.

    The sign of the wiring is already applied (`with_phase_sign`): from here on a longer path turns the phase forward.

    Attributes
    ----------
    samples
        Stored samples of the recording that these are.
    size
        How many of those each sample here is the mean of (`signals/band.py`).
    time_s
        Of channel 0, shape (n_samples,).
    volts
        I1, Q1, I2, ... finite, hum and tones taken off, wiring's sign applied, shape (2 n_receivers, n_samples).
    at_one_time_v
        The same with the multiplexer's delay taken off: all channels interpolated to the time of channel 0.
    usable
        False where a channel is clipped, open or was not a number, shape (2 n_receivers, n_samples).
    opened
        Where it looks open and nothing else is wrong with it, same shape.
    noise_v
        Standard deviation of each channel's white noise, shape (2 n_receivers,), above zero.
    segment
        Of these samples the motion and the rest before it: until `segment.rest_last` the tracer rests for sure.
    onset_s
        Last time at which the tracer still appears to rest; -inf if the stretch begins in motion.
    rest_end_s
        Until here the tracer rests for sure; the first sample's time where the stretch begins in motion.
    doppler
        Lines of each receiver's frames: in the motion, of one or two receivers in all samples; samples count from the
        first of these.
    echoes
        Each receiver's echo as far as it can be followed by itself; None where it cannot, and with three receivers,
        whose position determines more.
    faults
        Why a receiver cannot be used, one value a receiver; None where nothing speaks against it.
    delay_s
        Delay of each channel against channel 0 (multiplexer skew), shape (2 n_receivers,).
    sample_rate_hz
        Of each channel.
    phase_sign
        Sign that the wiring had.
    pauses
        First and last of these samples of each rest between two motions in the segment.
    clock
        That all phases turn too fast or too slow for a fall; None where they do not.
    further
        When each other motion of the recording begins and ends, in s: these signals are those of one of several.
    """

    samples: slice
    size: int
    time_s: FloatArray = field(repr=False)
    volts: FloatArray = field(repr=False)
    at_one_time_v: FloatArray = field(repr=False)
    usable: BoolArray = field(repr=False)
    opened: BoolArray = field(repr=False)
    noise_v: FloatArray
    segment: Segment
    onset_s: float
    rest_end_s: float
    doppler: tuple[Doppler, ...] = field(repr=False)
    echoes: tuple[Echo | None, ...] = field(repr=False)
    faults: tuple[Finding | None, ...]
    delay_s: FloatArray
    sample_rate_hz: float
    phase_sign: int
    pauses: tuple[tuple[int, int], ...] = ()
    clock: Finding | None = None
    further: tuple[tuple[float, float], ...] = ()

    @property
    def n_receivers(self) -> int:
        """Number of IQ pairs."""
        return int(self.volts.shape[0]) // 2

    def of_receivers(self, numbers: Sequence[int]) -> Conditioned:
        """Return the same of some receivers, numbered from 0."""
        channels = [2 * number + part for number in numbers for part in (0, 1)]
        some: dict[str, Any] = {name: getattr(self, name)[channels] for name in _BY_CHANNEL}
        some |= {name: tuple(getattr(self, name)[number] for number in numbers) for name in _BY_RECEIVER}
        return replace(self, **some)

    def without(self, number: int, begin_s: float, end_s: float) -> Conditioned:
        """Return the same with samples of a receiver, numbered from 0, between two times marked unusable."""
        usable = self.usable.copy()
        usable[2 * number : 2 * number + 2, slice(*np.searchsorted(self.time_s, [begin_s, end_s]))] = False
        return replace(self, usable=usable)

    @property
    def closed(self) -> Conditioned:
        """The same with nothing taken for an open channel."""
        return replace(self, usable=self.usable | self.opened, opened=np.zeros_like(self.opened))

    @property
    def valid(self) -> BoolArray:
        """Where both channels of a receiver can be used and its echo is there, shape (n_receivers, n_samples)."""
        out = np.asarray(self.usable[0::2] & self.usable[1::2])
        # the slow beginning after a rest is not led: there the path itself is judged
        if self.segment.has_rest:
            return out
        for row, echo in zip(out, self.echoes, strict=True):
            if echo is not None:
                row &= echo.leads
            elif self.n_receivers < MIN_RECEIVERS:
                # no line was ever clear: before and after what shook the voltages a target may move below the noise
                row[: self.segment.first] = row[self.segment.last :] = False
        return out

    @property
    def n_samples(self) -> int:
        """Number of samples of each channel."""
        return int(self.time_s.size)

    @property
    def unusable_share(self) -> FloatArray:
        """Share of each receiver's samples that cannot be used, shape (n_receivers,)."""
        return np.asarray((~self.usable).reshape(self.n_receivers, 2, -1).any(axis=1).mean(axis=1))
