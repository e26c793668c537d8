"""Find receivers whose phase turns the wrong way in a fall: their wires or `phase_sign` are exchanged.

Recordings are tested by their voltages, live tracks by their paths.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from radargui.model.arrays import BoolArray, median, runs_of
from radargui.model.finding import Finding, refuse, warn
from radargui.model.gravity import expected_gravity_m_s2, fall_time_s
from radargui.model.setup import Setup
from radargui.signals.averager import block_means
from radargui.signals.conditioned import Conditioned
from radargui.signals.fall import (
    ACCELERATION,
    RATE_HZ,
    WINDOW_M,
    VerticalMotion,
    longest_run,
    min_speed_m_s,
    radians_fallen,
    turning_phases,
    vertical_motion,
    window_of,
)

MIN_M = 0.01765
"""All phases have to turn with a free fall's acceleration for as long as a fall from rest takes for this, whatever
their signs: 60 ms on Earth."""
FIRST_M = 0.4414
"""Of the motion as much is looked at first as a fall from so high takes."""
MIN_RECEIVERS = 3
"""Of fewer the phases may turn so by chance: nothing is then said."""
MIN_ALONG = 0.5
"""Of the path's change with the height: an antenna below the sphere and one above hardly see it fall."""
MAX_APART = 1.5
"""Between the accelerations of the receivers, and their speeds, along the vertical; wrong tilts leave so much."""


@dataclass(frozen=True, slots=True)
class FallSigns:
    """What the phases say of the fall in a recording.

    Attributes
    ----------
    backwards
        Which receivers' phases turn as if the sphere fell upwards, one a receiver.
    times_g
        The acceleration that all receivers show, divided by g, if it is not that of a fall; None if it is, or if they
        show none.
    """

    backwards: tuple[bool, ...]
    times_g: float | None = None


class FallRule:
    """Decides which receivers' phases turn the wrong way in a fall that all of them show.

    The second derivative of each phase over that of the path of a falling sphere, -g dL/dz, is one in any flight, up or
    down, whatever the mismatch. Where it is minus one, Q leads where it should follow. If all phases turn as they
    should for a moment, nothing is said.

    Parameters
    ----------
    setup
        Antennas, release, wavelength.
    rate_hz
        Of the phases.
    half_m, min_m
        Ways of a fall from rest, as `WINDOW_M` and `MIN_M`.

    Attributes
    ----------
    window
        Samples of a parabola.
    rad_per_m
        Change of each phase for a metre of fall, shape (n_receivers, 1).
    gravity_m_s2
        Of the setup's site.
    is_decisive
        Whether the receivers stand so that their phases show a fall clearly enough to be judged.
    """

    def __init__(self, setup: Setup, rate_hz: float, half_m: float = WINDOW_M, min_m: float = MIN_M) -> None:
        self.gravity_m_s2 = expected_gravity_m_s2(setup.site)
        self.window, self.rad_per_m = window_of(rate_hz, self.gravity_m_s2, half_m), radians_fallen(setup)
        self._least = fall_time_s(min_m, self.gravity_m_s2) * rate_hz - self.window
        self._min_m_s = min_speed_m_s(self.gravity_m_s2)
        self._nothing = FallSigns((False,) * setup.n_receivers)
        least = 2.0 * np.pi / setup.radar.wavelength_m * MIN_ALONG
        self.is_decisive = setup.n_receivers >= MIN_RECEIVERS and bool(self.rad_per_m.min() >= least)

    def signs(self, found: VerticalMotion) -> FallSigns | None:
        """Return what phases say, in windows of the rule, signs as the setup has them; None where all fall rightly."""
        share, together = found.times_g, _together(found, self._min_m_s)
        falls = together & ((np.abs(share) > ACCELERATION[0]) & (np.abs(share) < ACCELERATION[1])).all(axis=0)
        turned = share < 0.0
        if (falls & ~turned.any(axis=0)).any():
            return None
        if falls.any():
            patterns = np.unique(turned[:, falls], axis=1).T
            longest = [longest_run(falls & (turned == one[:, None]).all(axis=0)) for one in patterns]
            best = int(np.argmax(longest))
            return FallSigns(tuple(patterns[best].tolist())) if longest[best] >= self._least else self._nothing
        even = together & ~turned.any(axis=0)
        if longest_run(even) < self._least:
            return self._nothing
        begin, end = max(runs_of(even), key=lambda run: run[1] - run[0])
        return FallSigns(self._nothing.backwards, float(median(share[:, begin:end])))


def _together(found: VerticalMotion, least_m_s: float) -> BoolArray:
    """Return where all receivers have about one acceleration and one speed along the vertical, shape (n,)."""
    speed = np.abs(found.speed_m_s)
    together = (found.fits & (speed > least_m_s)).all(axis=0)
    # whatever their signs: what moves sideways shows each receiver another
    for sizes in (speed, np.abs(found.times_g)):
        together &= sizes.max(axis=0) < MAX_APART * sizes.min(axis=0)
    return np.asarray(together)


def fall_signs(conditioned: Conditioned, setup: Setup) -> FallSigns:
    """Return which receivers' phases turn the wrong way in a recording.

    Parameters
    ----------
    conditioned
        Signals, the setup's sign applied.
    setup
        Antennas, release, wavelength.
    """
    nothing = FallSigns((False,) * conditioned.n_receivers)
    size = max(1, round(conditioned.sample_rate_hz / RATE_HZ))
    rate_hz = conditioned.sample_rate_hz / size
    rule = FallRule(setup, rate_hz)
    n_means, window = conditioned.n_samples // size, rule.window
    if not rule.is_decisive or n_means < 2 * window:
        return nothing
    # nearly every drop shows at its beginning that nothing is wrong: the rest need not be looked at
    begin = max(0, min(conditioned.segment.first // size - window, n_means - 2 * window))
    found = None
    for part in (
        slice(begin, begin + max(2 * window, round(fall_time_s(FIRST_M, rule.gravity_m_s2) * rate_hz))),
        slice(0, n_means),
    ):
        means = block_means(conditioned.volts[:, part.start * size : part.stop * size], size)
        phase = turning_phases(means, rate_hz)
        motion = vertical_motion(phase, rate_hz, window, rule.rad_per_m, rule.gravity_m_s2)
        found = rule.signs(motion)
        if found is None:
            break
    return nothing if found is None else found


def wired_wrongly(conditioned: Conditioned, setup: Setup) -> tuple[tuple[Finding | None, ...], Finding | None]:
    """Return why a receiver is none, one a receiver, with the faults found before; and what is wrong with the clock.

    In a fall that all receivers show none may show that the sphere falls upwards: refused before anything is measured,
    for three receivers of which one is turned round may still find a motion that fits them.
    """
    signs = fall_signs(conditioned, setup)
    if all(signs.backwards):
        sign = -setup.radar.phase_sign
        firsts = (number == 0 for number in range(conditioned.n_receivers))
        return tuple(refuse("phase_sign_wrong", phase_sign=sign, is_first=first) for first in firsts), None
    clock = None
    if signs.times_g is not None:
        clock = warn("clock_wrong", times_g=signs.times_g, factor=math.sqrt(signs.times_g))
    found = zip(conditioned.faults, signs.backwards, strict=True)
    return tuple(fault or (refuse("phase_reversed") if is_turned else None) for fault, is_turned in found), clock
