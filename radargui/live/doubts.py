"""Find what speaks against a live track: a receiver off its circle, dead, or equal to another."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from radargui.conditioning.fall import vertical_motion
from radargui.conditioning.fall_signs import FallRule
from radargui.conditioning.noise import LEAST_SAMPLES, white_noise_v
from radargui.conditioning.receiver_check import same_channels
from radargui.model.arrays import FloatArray
from radargui.model.gravity import fall_time_s
from radargui.model.setup import Setup

WORST_MISFIT = 0.35
"""In amplitudes, over the last fringes: in 150 motions of the laboratory paths below were wrong by a sixth of a fringe
at the most, and turns were lost above."""
LONG_M, SHORT_M = 0.1, 0.01
"""A receiver whose path changes by less than the second, while that of another one does by the first, shows no motion:
a third of a fringe is what noise and hum make of a dead input. By hand."""
LOUDEST = 0.18
"""Noise of a column in amplitudes, the mean so far in a motion: of eight falls each with echoes of 4 dB at the release
(0.16 to 0.185 at the end), 3 dB (0.18 to 0.20) and 2 dB (0.20 to 0.225) all, seven and four were counted right."""
LEAST_COLUMNS = 200
"""That tell it within a tenth. By hand."""
MOST_COLUMNS = 4000
"""After a second it is known. By hand."""
BLOCKS_COMPARED = 3
"""Of a motion, for one cable on two inputs: each has a fringe or more in it."""
PATH_WINDOW_M, PATH_LEAST_M = 7.848e-3, 0.04904
"""Ways of a fall from rest in half a parabola through paths, and in the fall it has to fit (`FallRule`), 80 and 100 ms
on Earth: what is left of the mismatch ripples paths, and a throw is not known before it ends. By hand."""


class Doubts:
    """Watches a motion while it is followed.

    Parameters
    ----------
    setup
        Antennas, release, wavelength.
    rate_hz
        Of the block means.
    """

    def __init__(self, setup: Setup, rate_hz: float) -> None:
        self._n, self._wavelength_m, self._sign = setup.n_receivers, setup.radar.wavelength_m, setup.radar.phase_sign
        self._falls = FallWatch(setup, rate_hz)
        self.begin()

    def begin(self) -> None:
        """Forget the preceding motion, because another one begins."""
        self._compared = 0
        self._n_heard, self._noise_square = 0, np.zeros(self._n)
        self._forget_ends()
        self._falls.begin()

    def _forget_ends(self) -> None:
        self._ends = np.array([[np.inf], [-np.inf]]).repeat(self._n, axis=1)

    def of(
        self, change_m: FloatArray, radius: FloatArray, misfits: Sequence[float], volts: FloatArray,
        rest_v: FloatArray, noise_v: FloatArray,
    ) -> str:  # fmt: skip
        """Return why the next columns cannot be trusted; empty where nothing speaks against them.

        Parameters
        ----------
        change_m
            Change of path length, shape (n_receivers, n).
        radius
            Of corrected I and Q, in amplitudes, shape (n_receivers, n).
        misfits
            `MapFilter.misfit` of each receiver, after them.
        volts, rest_v
            Block means of the channels, in these columns and at rest, shape (2 n_receivers, n).
        noise_v
            Standard deviation of one of them at rest, shape (2 n_receivers,).
        """
        worst = int(np.argmax(misfits))
        if misfits[worst] > WORST_MISFIT:
            return f"receiver {worst + 1} shows no circle"
        # a fringe or more far off the circle: the four that the misfit remembers would be late
        low, high = change_m.min(axis=1), change_m.max(axis=1)
        far = np.sqrt(((radius - 1.0) ** 2).mean(axis=1))
        if far.max() > WORST_MISFIT and (high - low).max() > self._wavelength_m:
            return f"receiver {int(np.argmax(far)) + 1} shows no circle"
        self._ends = np.stack([np.fmin(self._ends[0], low), np.fmax(self._ends[1], high)])
        span = self._ends[1] - self._ends[0]
        if span.max() > LONG_M:
            self._forget_ends()
            if span.min() < SHORT_M:
                return f"receiver {int(np.argmin(span)) + 1} shows no motion"
        if faint := self._faint(radius):
            return faint
        if backwards := self._falls.push(change_m):
            return f"receiver {backwards[0] + 1} falls upwards: are I and Q swapped?"
        if self._compared < BLOCKS_COMPARED and (high - low).max() > self._wavelength_m:
            self._compared += 1
            for one, other in same_channels(volts, noise_v, rest_v, self._sign):
                return f"receivers {one // 2 + 1} and {other // 2 + 1} have one cable"
        return ""

    def _faint(self, radius: FloatArray) -> str:
        """Return which receivers have too much noise for their fringes to be counted, so far in this motion."""
        count = radius.shape[1]
        if count >= LEAST_SAMPLES and self._n_heard < MOST_COLUMNS:
            self._n_heard += count
            self._noise_square += count * white_noise_v(radius) ** 2
        if self._n_heard < LEAST_COLUMNS:
            return ""
        noise = np.sqrt(self._noise_square / self._n_heard)
        worst = int(np.argmax(noise))
        return f"receiver {worst + 1} is too weak against its noise" if noise[worst] > LOUDEST else ""


class FallWatch:
    """Watches the paths of a track while it is followed, for receivers that show a fall upwards.

    Parameters
    ----------
    setup
        Antennas, release, wavelength.
    rate_hz
        Of the path lengths.
    """

    def __init__(self, setup: Setup, rate_hz: float) -> None:
        self._rule = FallRule(setup, rate_hz, PATH_WINDOW_M, PATH_LEAST_M)
        self._rate_hz, self._rad_per_m = rate_hz, 2.0 * np.pi / setup.radar.wavelength_m
        self._least = round(fall_time_s(PATH_LEAST_M, self._rule.gravity_m_s2) * rate_hz) + 1
        self.begin()

    def begin(self) -> None:
        """Begin another motion. Receivers that fell downwards once are not tested again."""
        self._held = np.empty((0, 0))

    def push(self, change_m: FloatArray) -> tuple[int, ...]:
        """Take the next changes of path length, shape (n_receivers, n); return the receivers that fell upwards."""
        if not self._rule.is_decisive:
            return ()
        held = np.concatenate([self._held, change_m], axis=1) if self._held.size else change_m
        self._held = held[:, -self._least :]
        if held.shape[1] < self._least:
            return ()
        rule = self._rule
        phase = self._rad_per_m * held
        signs = rule.signs(vertical_motion(phase, self._rate_hz, rule.window, rule.rad_per_m, rule.gravity_m_s2))
        # wires are not exchanged while it runs
        rule.is_decisive = signs is not None
        return () if signs is None else tuple(np.flatnonzero(signs.backwards).tolist())
