"""Motion too slow for the trigger: means of 0.1 s against those of the last half second, while they come."""

from __future__ import annotations

from collections import deque

import numpy as np

from radargui.model.arrays import FloatArray

BLOCK_S = 0.02
"""Between two means."""
MEAN_S = 0.1
"""Whole periods of 50 and of 60 Hz: no hum is in the means. A hand, up to 10 Hz of Doppler, still is."""
WINDOW_S = 0.4
"""In it a hand of 2 cm/s goes half a fringe; what is slower by far is a drift of the electronics. By hand."""
CONFIRM_S = 0.08
"""A drop is fast by then: the trigger tells better when it began. By hand."""
MEMORY_S = 30.0
"""The quiet level is that of so long; chosen by hand."""
QUIET_PERCENTILE = 20.0
LEAST_NOISE = 0.01
"""Of the loudest channel's variance: an input that is shorted shows one code, and another once an hour. By hand."""
LEAST_SIGMAS = 2.0
"""Times the noise of one sample that a motion changes the means by, at the least (root mean square): an echo of 20 dB
has ten times that noise, and what shakes or drifts by less is no place. By hand."""
LEAST_RATE_HZ = 4e4
"""One sample's noise at this rate at the most: a faster device has louder samples, and echoes as before."""
LONGEST_S = 20.0
"""What goes on for longer is the new quiet, a lamp or a fan. By hand."""
LATE_S = MEAN_S + WINDOW_S + CONFIRM_S
"""A motion that is told now began so long ago at the most."""


class SlowMotion:
    """Causal detector of motion that the trigger of a drop does not see: with 24 dB at 2 kS/s all below 0.3 m/s.

    Activity is the variance of means within 0.4 s, in units of what white noise gives them, mean over channels; motion
    starts where it exceeds `threshold` squared times its quiet level, and ends below half of the threshold.

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
    """

    def __init__(self, rate_hz: float, sample_rate_hz: float, threshold: float) -> None:
        self._size = max(1, round(BLOCK_S * rate_hz))
        block_s = self._size / rate_hz
        self._start = threshold**2
        self._least = LEAST_SIGMAS**2 * MEAN_S * min(sample_rate_hz, LEAST_RATE_HZ)
        self._together = max(1, round(MEAN_S / block_s))
        self._window = max(4, round(WINDOW_S / block_s))
        self._confirm, self._longest = (max(1, round(span / block_s)) for span in (CONFIRM_S, LONGEST_S))
        self._levels: deque[float] = deque(maxlen=max(8, round(MEMORY_S / block_s)))
        self.clear()

    def clear(self) -> None:
        """Begin anew, at rest: samples before the next ones are missing, or belong to another rest."""
        self._left: FloatArray | None = None
        self._means: deque[FloatArray] = deque(maxlen=self._window)
        self._noises: deque[FloatArray] = deque(maxlen=self._window)
        self._blocks: deque[FloatArray] = deque(maxlen=self._together)
        self._above = 0
        self.moving = False

    def push(self, volts: FloatArray) -> bool:
        """Take the next samples, shape (n_channels, n); return whether something moves after them."""
        whole = volts if self._left is None else np.concatenate([self._left, volts], axis=1)
        count = whole.shape[1] // self._size
        self._left = whole[:, count * self._size :]
        for block in np.split(whole[:, : count * self._size], count, axis=1) if count else ():
            # third differences: what moves slowly is not in them; 20 = 1 + 9 + 9 + 1
            self._noises.append((np.diff(block, 3, axis=1) ** 2).mean(axis=1) / (20.0 * self._size * self._together))
            self._blocks.append(block.mean(axis=1))
            if len(self._blocks) == self._together:
                self._means.append(np.mean(self._blocks, axis=0))
            if len(self._means) == self._window:
                self._judge(self._activity())
        return self.moving

    def _activity(self) -> float:
        noise = np.mean(self._noises, axis=0)
        largest = float(noise.max())
        if not np.isfinite(largest) or largest <= 0.0:
            return 1.0
        return float((np.var(self._means, axis=0) / np.maximum(noise, LEAST_NOISE * largest)).mean())

    def _judge(self, level: float) -> None:
        quiet = max(1.0, float(np.percentile(self._levels, QUIET_PERCENTILE))) if self._levels else 1.0
        least = max(self._start * quiet, self._least)
        self._above = self._above + 1 if level > (0.25 * least if self.moving else least) else 0
        if self._above > self._longest:
            self._levels.clear()
            self._above = 0
        if self._above == 0:
            self._levels.append(level)
        # what moves as the first samples come is the first quiet, until there is a better one
        self.moving = self._above > 0 if self.moving else self._above >= self._confirm
