"""Tell from the signals alone, within a moment, whether the tracer fell freely or was carried by a hand."""

from __future__ import annotations

import numpy as np

from radargui.conditioning.averager import Averager
from radargui.conditioning.fall import (
    ACCELERATION,
    RATE_HZ,
    least_speed_m_s,
    longest_run,
    radians_fallen,
    turning_phases,
    vertical_motion,
    window_of,
)
from radargui.model.arrays import FloatArray, RawArray
from radargui.model.front_end import with_phase_sign
from radargui.model.gravity import expected_gravity_m_s2, fall_time_s
from radargui.model.recording import Digitisation
from radargui.model.setup import Setup

LEAST_M = 9.93e-3
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
        falling &= np.abs(one.speed_m_s) > least_speed_m_s(self._gravity_m_s2)
        wanted = len(falling) if len(falling) < 3 else len(falling) - 1
        # all receivers fall at one time; a cable that is moved does not
        longest = longest_run(falling.sum(axis=0) >= wanted)
        return longest + window >= fall_time_s(LEAST_M, self._gravity_m_s2) * self._rate_hz
