"""Tell from samples as they arrive when the tracer starts to move and when it is quiet again.

Tell from the signals alone, within a moment, whether the tracer fell freely or was carried by a hand.
"""

from __future__ import annotations

import math
from bisect import bisect_left, insort
from collections import deque
from dataclasses import dataclass, replace

import numpy as np

from radargui.live.rest_statistics import HUMS, QUIET_PERCENTILE, TOGETHER, Quiet
from radargui.model.arrays import FloatArray, RawArray
from radargui.model.front_end import with_phase_sign
from radargui.model.gravity import expected_gravity_m_s2, fall_time_s
from radargui.model.recording import Digitisation
from radargui.model.setup import Setup
from radargui.signals.averager import Averager, held
from radargui.signals.fall import (
    ACCELERATION,
    RATE_HZ,
    longest_run,
    min_speed_m_s,
    radians_fallen,
    turning_phases,
    vertical_motion,
    window_of,
)
from radargui.signals.noise import white_noise_v
from radargui.signals.segment import block_size, window_blocks

LEARNING_S = 0.1
"""Quiet needed before the trigger can tell motion from rest."""
MEMORY_S = 4.0
"""Span over which the quiet level is remembered: it follows a drift, a short motion does not raise it."""
CONFIRM_S = 0.004
"""Motion lasts at least this long; a spike does not."""


@dataclass(frozen=True, slots=True)
class TriggerState:
    """What the trigger says after a block.

    Attributes
    ----------
    ready
        Whether the quiet level is known: before, motion cannot be seen.
    moving
        Whether the tracer moves now.
    since_index
        Absolute index of the sample with which the present or last motion started; None before the first.
    quiet_since_index
        Absolute index since which it is quiet after a motion; None while it moves.
    """

    ready: bool
    moving: bool
    since_index: int | None
    quiet_since_index: int | None


class MotionTrigger:
    """Causal detector of motion, by the activity of the voltages compared with their quiet level.

    Activity is the variance of 0.5 ms block means within 20 ms, pooled over channels in units of their white noise.
    Motion starts where it exceeds `threshold` squared times its quiet level (robust to drift, which is in that level),
    and ends where it has fallen below half of the threshold. The hum of the mains is removed, because it would raise
    the quiet level and hide a fall. If the voltages at rest show a weak echo, means of 2 ms are used as well (see
    `Quiet`).

    Parameters
    ----------
    digitisation
        Rate and scale of the samples that will be pushed.
    threshold
        How many times harder than in quiet the voltages must shake.

    Attributes
    ----------
    state
        What the trigger said last.
    shaking
        The hardest that the voltages shook within the last samples, in the unit of the threshold: motion is told from
        the threshold on. NaN while the quiet level is not known.
    """

    def __init__(self, digitisation: Digitisation, threshold: float) -> None:
        self._digitisation = digitisation
        rate = digitisation.sample_rate_hz
        self._size = block_size(rate)
        self._window = window_blocks(rate / self._size)
        self._block_s = self._size / rate
        self._threshold = threshold
        # the activity is a variance
        self._rest = Quiet(rate / self._size, self._window, threshold**2)
        self._averager = Averager(digitisation, self._size)
        self._means = np.empty((digitisation.n_channels, 0))
        self._noise_v: FloatArray | None = None
        self._early: list[FloatArray] = []
        # one block in eight is remembered
        self._levels: deque[float] = deque(maxlen=max(4, round(MEMORY_S / self._block_s / 8)))
        # the same values in order: a sort every 4 ms was most of what waiting costs
        self._ordered: list[float] = []
        self._quiet = 1.0
        self._blocks = 0
        self._above = 0
        self.state = TriggerState(ready=False, moving=False, since_index=None, quiet_since_index=None)
        self.shaking = math.nan

    def push(self, samples: RawArray) -> TriggerState:
        """Take the next samples, shape (n_channels, n), and tell the state after them."""
        self._learn_noise(samples)
        new = self._averager.push(samples)
        count = new.shape[1]
        if count == 0:
            return self.state
        self._means = np.concatenate([self._means[:, -(self._window + TOGETHER - 1) :], new], axis=1)
        self._blocks += count
        if self._noise_v is None or self._means.shape[1] < self._window + TOGETHER - 1:
            self._rest.push(new)
            return self.state
        noise_v = self._noise_v / np.sqrt(self._size)
        level = self._rest.levels(self._means, self._blocks, noise_v)
        long = self._rest.long_over_quiet(self._means, self._blocks, noise_v)
        # both end with the newest block
        count, before = min(count, level.size - TOGETHER + 1), self.state.since_index
        longs = np.zeros(count) if long is None else long[-count:]
        self._judge(level[-count:], longs)
        over = np.fmax(self._threshold**2 / self._rest.least(self._quiet) * level[-count:], longs)
        self.shaking = float(np.sqrt(np.fmax.reduce(over))) if self.state.ready else math.nan
        if self.state.moving or self.state.since_index != before:
            shaken = level[-count:]
            self._rest.moves(shaken[shaken > self._rest.min_to_go_on(self._quiet)])
        elif self._rest.push(new) and self._above == 0:
            self._look_at_rest(noise_v)
        return self.state

    @property
    def objection(self) -> str:
        """Why a fall might not be seen, in a few words; empty if it would be seen, or if that is not known yet."""
        seen = self._rest.seen
        if not self._rest.is_weak or seen is None:
            return ""
        times = int(seen * self._threshold)
        harder = f"about {times} times as hard as" if times else "less hard than"
        return (
            f"it would shake the voltages {harder} {self.disturbance} does, and the trigger asks for "
            f"{self._threshold:g} times"
        )

    @property
    def disturbance(self) -> str:
        """What the voltages show at rest besides an echo: noise, or something louder."""
        if self._rest.hum_level:
            return "a hum of the mains"
        return "noise" if self._quiet < HUMS else "a hum or a vibration"

    def relearn(self) -> None:
        """Take the present activity for the quiet level, because it has lasted too long to be a motion."""
        self._levels.clear()
        self._ordered.clear()
        self._quiet = 1.0
        self._rest.forget()
        self._above = 0
        now = self._blocks * self._size
        self.state = replace(self.state, ready=False, moving=False, quiet_since_index=now)

    def _learn_noise(self, samples: RawArray) -> None:
        if self._noise_v is not None:
            return
        self._early.append(held(self._digitisation.volts(samples)))
        if sum(part.shape[1] for part in self._early) >= LEARNING_S * self._digitisation.sample_rate_hz:
            whole = np.concatenate(self._early, axis=1)
            noise = white_noise_v(whole)
            self._noise_v = np.maximum(noise, np.maximum(1e-6 * np.abs(whole).max(axis=1), 1e-9))
            self._early.clear()

    def _look_at_rest(self, noise_v: FloatArray) -> None:
        level = self._rest.look(self._blocks, noise_v)
        if level is None:
            return
        # with another hum taken off, levels from before tell nothing
        self._levels.clear()
        self._ordered.clear()
        for one in level[::8]:
            self._remember(float(one))
        self._quiet = self._quiet_level()

    def _judge(self, levels: FloatArray, longs: FloatArray) -> None:
        first_block, start = self._blocks - levels.size, self._threshold**2
        for offset, (level, long) in enumerate(zip(levels, longs, strict=True)):
            block = first_block + offset
            state = self.state
            quiet = self._quiet
            ready = state.ready or len(self._levels) * 8 * self._block_s >= LEARNING_S
            if not state.moving:
                if block % 8 == 0:
                    # every eighth block: neighbours share most of their window
                    self._remember(float(level))
                    self._quiet = quiet = self._quiet_level()
                moves = level > self._rest.least(quiet) or long > start
                self._above = self._above + 1 if ready and moves else 0
                if self._above * self._block_s >= CONFIRM_S:
                    begin = max(0, (block - self._above + 1) * self._size)
                    self.state = TriggerState(ready, moving=True, since_index=begin, quiet_since_index=None)
                elif ready != state.ready:
                    self.state = replace(state, ready=ready)
            elif level < self._rest.min_to_go_on(quiet) and long < self._rest.long_to_go_on:
                self._above = 0
                begin = (block + 1) * self._size
                self.state = TriggerState(ready, moving=False, since_index=state.since_index, quiet_since_index=begin)

    def _remember(self, level: float) -> None:
        if not math.isfinite(level):
            return
        if len(self._levels) == self._levels.maxlen:
            del self._ordered[bisect_left(self._ordered, self._levels[0])]
        self._levels.append(level)
        insort(self._ordered, level)

    def _quiet_level(self) -> float:
        if not self._ordered:
            return 1.0
        at = 0.01 * QUIET_PERCENTILE * (len(self._ordered) - 1)
        low, share = int(at), at % 1.0
        high = min(low + 1, len(self._ordered) - 1)
        return max(1.0, self._ordered[low] + share * (self._ordered[high] - self._ordered[low]))


MIN_M = 9.93e-3
"""A fall of 2.5 cm is faster than the least speed for as long as a fall from rest takes for this, 45 ms on Earth."""


class FallTest:
    """Searches an interval in which the phases of the receivers turn with the acceleration of a free fall.

    The derivative of z = I + jQ is j phase' A exp(j phase), whatever the offset: its argument turns as the phase
    does while the tracer moves one way. In windows of 30 ms on Earth a parabola is fitted to it; in a free fall, or in
    any flight between bounces, its second derivative is that of the path length, -g dL/dz, over the wavelength.

    Parameters
    ----------
    setup
        Antennas, release, wavelength.
    digitisation
        How the samples to be pushed are taken.
    """

    def __init__(self, setup: Setup, digitisation: Digitisation) -> None:
        rate = digitisation.sample_rate_hz
        self._averager = Averager(digitisation, max(1, round(rate / RATE_HZ)))
        self._rate_hz = rate / self._averager.size
        self._means: list[FloatArray] = []
        self._sign, self._rad_per_m = setup.radar.phase_sign, radians_fallen(setup)
        self._gravity_m_s2 = expected_gravity_m_s2(setup.site)

    def push(self, samples: RawArray) -> None:
        """Take the next samples of the run, shape (n_channels, n)."""
        self._means.append(with_phase_sign(self._averager.push(samples), self._sign))

    def refusal(self) -> str:
        """Return why the run is no drop; empty where a fall is in it."""
        return "" if self.has_fall() else "nothing in it falls freely"

    def has_fall(self) -> bool:
        """Whether all receivers, or all but one where there are three or more, see one free fall."""
        means = np.concatenate(self._means, axis=1) if self._means else np.empty((0, 0))
        window = window_of(self._rate_hz, self._gravity_m_s2)
        if means.shape[1] < 2 * window:
            return False
        phase = turning_phases(means, self._rate_hz)
        one = vertical_motion(phase, self._rate_hz, window, self._rad_per_m, self._gravity_m_s2)
        # the sign tells a fall from a throw, the size from a hand
        falling = one.fits & (one.times_g > ACCELERATION[0]) & (one.times_g < ACCELERATION[1])
        falling &= np.abs(one.speed_m_s) > min_speed_m_s(self._gravity_m_s2)
        wanted = len(falling) if len(falling) < 3 else len(falling) - 1
        # all receivers fall at one time; a cable that is moved does not
        longest = longest_run(falling.sum(axis=0) >= wanted)
        return longest + window >= fall_time_s(MIN_M, self._gravity_m_s2) * self._rate_hz
