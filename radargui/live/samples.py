"""Prepare the samples of the live track: average to a few kilohertz, take the skew out, keep the index."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from radargui.model.arrays import BoolArray, FloatArray, IntArray, RawArray, runs_of
from radargui.model.daq import Daq
from radargui.model.front_end import with_phase_sign
from radargui.model.recording import Digitisation, channel_skew
from radargui.signals.averager import Averager

LIVE_RATE_HZ = 4000.0
"""Block means at this rate still follow a Doppler of several hundred Hz."""


@dataclass(frozen=True, slots=True)
class Means:
    """Block means.

    Attributes
    ----------
    volts
        At the time of channel 0, the wiring's sign applied, shape (n_channels, n).
    index
        Absolute sample index of each block's middle, shape (n,).
    """

    volts: FloatArray
    index: IntArray

    @property
    def count(self) -> int:
        """Columns."""
        return int(self.index.size)

    def part(self, first: int, last: int | None) -> Means:
        """Return columns first:last; counted from the end where negative."""
        return Means(self.volts[:, first:last], self.index[first:last])

    def thinned(self, step: int) -> Means:
        """Return each `step`-th column, the last one among them."""
        return Means(self.volts[:, ::-step][:, ::-1], self.index[::-step][::-1])

    def joined(self, more: Means) -> Means:
        """Return these and those that follow."""
        return Means(np.concatenate([self.volts, more.volts], axis=1), np.concatenate([self.index, more.index]))


class LiveSamples:
    """Makes block means of raw samples as they come.

    Parameters
    ----------
    digitisation
        How the samples to be pushed were taken.
    daq
        Tells the multiplexer skew where the samples come without it.
    phase_sign
        Of the wiring.

    Attributes
    ----------
    rate_hz
        Block means per second.
    """

    def __init__(self, digitisation: Digitisation, daq: Daq, phase_sign: int) -> None:
        self._n_channels, self._sign = digitisation.n_channels, phase_sign
        # a mean of n samples has 1 / sqrt(n) of their noise, and its low-pass is far above any Doppler of a drop
        self._averager = Averager(digitisation, max(1, round(digitisation.sample_rate_hz / LIVE_RATE_HZ)))
        self.rate_hz = digitisation.sample_rate_hz / self._averager.size
        delay_s = np.arange(digitisation.n_channels) * channel_skew(digitisation, daq).delay_s
        # in means: how far back on the line the value at the time of channel 0 lies
        self._share = (delay_s * self.rate_hz)[:, None]
        self._next_index = 0
        self._before: FloatArray | None = None
        self._n_unknown = 0

    def jump(self, first_index: int | None) -> int:
        """Note where the next samples begin; return how many before them are missing."""
        lost = 0 if first_index is None else first_index - self._next_index - self._averager.waiting
        if first_index is None or lost == 0:
            return 0
        self._averager.clear()
        self._next_index = first_index
        # across a gap there is no line to interpolate on
        self._before = None
        return lost

    def unknown(self, samples: RawArray) -> int:
        """Return the longest stretch of the next samples in which a channel gives no numbers, as told so far."""
        if samples.dtype == np.int16 or samples.shape[1] == 0:
            return 0
        known: BoolArray = np.asarray(np.isfinite(samples).all(axis=0))
        if known.all():
            self._n_unknown = 0
            return 0
        runs = runs_of(np.logical_not(known))
        lengths = runs[:, 1] - runs[:, 0]
        if runs[0, 0] == 0:
            lengths[0] += self._n_unknown
        self._n_unknown = 0 if known[-1] else int(lengths[-1])
        return int(lengths.max())

    def push(self, samples: RawArray) -> Means:
        """Take the next samples, shape (n_channels, n), and return the means that are complete now.

        The multiplexer samples channel k later by k times the skew. Its value at the time of channel 0 is interpolated
        linearly between two means.
        """
        means = with_phase_sign(self._averager.push(samples), self._sign)
        size, count = self._averager.size, means.shape[1]
        index = self._next_index + np.arange(count, dtype=np.intp) * size + size // 2
        self._next_index += count * size
        if count:
            # the very first mean has none before it: its own value is the best guess
            before = means[:, :1] if self._before is None else self._before
            earlier = np.concatenate([before, means[:, :-1]], axis=1)
            self._before = means[:, -1:]
            means = means * (1.0 - self._share) + earlier * self._share
        return Means(means, index)

    def nothing(self) -> Means:
        """Return no means at all."""
        return Means(np.empty((self._n_channels, 0)), np.empty(0, dtype=np.intp))
