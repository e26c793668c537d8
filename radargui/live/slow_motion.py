"""Recognise motion too slow for the trigger: means of 20 ms and 0.1 s against those of the last half second."""

from __future__ import annotations

from collections import deque

import numpy as np

from radargui.live.rest_statistics import QUIET_PERCENTILE
from radargui.model.arrays import FloatArray

BLOCK_S = 0.02
"""Of a mean: a hand, up to 30 Hz of Doppler, is in it, and no hum of 50 Hz."""
TOGETHER = 5
"""Means averaged: a fifth of the noise, and no hum of 60 Hz either."""
WINDOW_S = 0.4
"""In it a hand of 2 cm/s goes half a fringe; what is slower by far is a drift of the electronics. By hand."""
CONFIRM_S = 0.08
"""A drop is fast by then: the trigger tells better when it began. By hand."""
MEMORY_S = 30.0
"""The quiet level is that of so long; chosen by hand."""
EVERY = 16
"""Levels between two looks at all of them."""
LEAST_NOISE = 0.01
"""Of the loudest channel's variance: an input that is shorted shows one code, and another once an hour. By hand."""
LEAST_SIGMAS = 2.0
"""Times the noise of one sample that a motion changes the means by, at the least (root mean square): an echo of 20 dB
has ten times that noise, and what shakes or drifts by less is no place. By hand."""
LEAST_RATE_HZ = 4e4
"""One sample's noise at this rate at the most: a faster device has louder samples, and echoes as before."""
LONGEST_S = 20.0
"""What goes on for longer is the new quiet, a lamp or a fan. By hand."""
LATE_S = BLOCK_S * TOGETHER + WINDOW_S + CONFIRM_S
"""A motion that is told now began so long ago at the most."""


class SlowMotion:
    """Causal detector of motion that the trigger of a drop does not see (below 0.3 m/s with 24 dB at 2 kS/s).

    Activity is the variance of means within 0.4 s, in units of one sample's noise, mean over channels; motion starts
    where that of the short or of the long means exceeds `threshold` squared times its quiet level, which is no less
    than what white noise makes, and ends below half of the threshold.

    Parameters
    ----------
    rate_hz
        Of the samples to be pushed, which are means themselves.
    sample_rate_hz
        Of the device.
    threshold
        How many times harder than in quiet the voltages must change.

    Attributes
    ----------
    moving
        What it said last.
    has_rested
        Whether it was quiet at any time since the first samples.
    """

    def __init__(self, rate_hz: float, sample_rate_hz: float, threshold: float) -> None:
        self._size = max(1, round(BLOCK_S * rate_hz))
        block_s = self._size / rate_hz
        self._samples = block_s * min(sample_rate_hz, LEAST_RATE_HZ)
        self._white = 1.0 / (self._samples * np.array([1.0, TOGETHER]))
        self._threshold = threshold
        self._window = max(4, round(WINDOW_S / block_s))
        self._confirm, self._longest = (max(1, round(span / block_s)) for span in (CONFIRM_S, LONGEST_S))
        self._levels: deque[FloatArray] = deque(maxlen=max(8, round(MEMORY_S / block_s)))
        self._quiet, self._n_judged = self._white, 0
        self.has_rested = False
        self.clear()

    def clear(self) -> None:
        """Begin anew, at rest, because samples are missing or belong to another rest."""
        self._left: FloatArray | None = None
        self._means: deque[FloatArray] = deque(maxlen=self._window + TOGETHER - 1)
        self._noises: deque[FloatArray] = deque(maxlen=self._window)
        self._above = 0
        self.moving = False

    def push(self, volts: FloatArray) -> bool:
        """Take the next samples, shape (n_channels, n); return whether something moves after them."""
        whole = volts if self._left is None else np.concatenate([self._left, volts], axis=1)
        count = whole.shape[1] // self._size
        self._left = whole[:, count * self._size :]
        if count == 0:
            return self.moving
        blocks = whole[:, : count * self._size].reshape(whole.shape[0], count, self._size)
        # third differences: what moves slowly is not in them; 20 = 1 + 9 + 9 + 1
        third = blocks[..., 3:] - blocks[..., :-3] - 3.0 * (blocks[..., 2:-1] - blocks[..., 1:-2])
        noises = np.einsum("cbs,cbs->bc", third, third) / (20.0 * max(1, third.shape[2]) * self._size)
        for noise, mean in zip(noises, blocks.mean(axis=2).T, strict=True):
            self._noises.append(noise)
            self._means.append(mean)
            if len(self._means) == self._means.maxlen:
                self._judge(self._activity())
        return self.moving

    def _activity(self) -> FloatArray:
        """Return the variances of short and of long means, shape (2,)."""
        noise = np.mean(self._noises, axis=0)
        largest = float(noise.max())
        if not np.isfinite(largest) or largest <= 0.0:
            return np.zeros(2)
        means = np.array(self._means)
        total = np.cumsum(np.concatenate([np.zeros((1, means.shape[1])), means]), axis=0)
        long = (total[TOGETHER:] - total[:-TOGETHER]) / TOGETHER
        variance = np.stack([means[-self._window :].var(axis=0), long.var(axis=0)])
        return np.asarray((variance / np.maximum(noise, LEAST_NOISE * largest)).mean(axis=1) / self._samples)

    def _judge(self, level: FloatArray) -> None:
        least = np.maximum(self._threshold**2 * self._quiet, LEAST_SIGMAS**2)
        above = level > (0.25 * least if self.moving else least)
        # a hum of 60 Hz is in the short means: before any quiet nobody knows how much
        self._above = self._above + 1 if above[0 if self.has_rested else 1 :].any() else 0
        if self._above > self._longest:
            self._levels.clear()
            self._above = self._n_judged = 0
        if self._above == 0:
            self.has_rested = True
            self._levels.append(level)
            # now and then: a sort of half a minute is most of what waiting costs
            if self._n_judged % EVERY == 0:
                self._quiet = np.maximum(self._white, np.percentile(self._levels, QUIET_PERCENTILE, axis=0))
            self._n_judged += 1
        # what moves as the first samples come is the first quiet, until there is a better one
        self.moving = self._above > 0 if self.moving else self._above >= self._confirm
