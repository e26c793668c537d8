"""Which way the phases turn in a fall: a receiver whose phase turns the other way has its wires, or sign, exchanged."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from radargui.conditioning.averager import block_means
from radargui.conditioning.conditioned import Conditioned
from radargui.conditioning.fall import (
    ACCELERATION,
    LARGEST_MISFIT_RAD,
    LEAST_SPEED,
    RATE_HZ,
    phase_parabolas,
    window_of,
)
from radargui.geometry.path_length import path_gradient, place_antennas
from radargui.model.arrays import BoolArray, FloatArray, median, runs_of
from radargui.model.gravity import NOMINAL_GRAVITY_M_S2
from radargui.model.setup import Setup

LEAST_S = 0.06
"""All phases have to turn with a free fall's acceleration for so long, whatever their signs."""
FIRST_S = 0.3
"""Of the motion that is looked at first: a fall from half a metre."""
LEAST_RECEIVERS = 3
"""Of fewer the phases may turn so by chance: nothing is then said."""
LEAST_ALONG = 0.5
"""Of the path's change with the height: an antenna below the sphere and one above hardly see it fall."""
MOST_APART = 1.5
"""Between the accelerations of the receivers, and their speeds, along the vertical; wrong tilts leave so much."""


@dataclass(frozen=True, slots=True)
class FallSigns:
    """What the phases say of the fall in a recording.

    Attributes
    ----------
    backwards
        Which receivers' phases turn as if the sphere fell upwards, one a receiver.
    times_g
        What all are accelerated with, over g, where nothing falls with that; None where they fall, or say nothing.
    """

    backwards: tuple[bool, ...]
    times_g: float | None = None


def fall_signs(conditioned: Conditioned, setup: Setup) -> FallSigns:
    """Return which receivers' phases turn the wrong way in a fall that all show.

    The second derivative of each phase over that of the path of a falling sphere, -g dL/dz, is one in any flight, up or
    down, whatever the mismatch: where it is minus one, Q leads where it should follow. A motion in which all turn as
    they should for a moment contradicts nothing.

    Parameters
    ----------
    conditioned
        Signals, the setup's sign applied.
    setup
        Antennas, release, wavelength.
    """
    nothing = FallSigns((False,) * conditioned.n_receivers)
    place = np.array(setup.tracer.release_position_m)[:, None]
    along = -path_gradient(place, place_antennas(setup))[:, 2, 0]
    size = max(1, round(conditioned.sample_rate_hz / RATE_HZ))
    rate_hz = conditioned.sample_rate_hz / size
    n_means, window = conditioned.n_samples // size, window_of(rate_hz)
    if len(along) < LEAST_RECEIVERS or along.min() < LEAST_ALONG or n_means < 2 * window:
        return nothing
    per_m = 2.0 * np.pi / setup.radar.wavelength_m * along[:, None]
    # nearly every drop shows at its beginning that nothing is wrong: the rest need not be looked at
    begin = max(0, min(conditioned.segment.first // size - window, n_means - 2 * window))
    for part in (slice(begin, begin + max(2 * window, round(FIRST_S * rate_hz))), slice(0, n_means)):
        means = block_means(conditioned.volts[:, part.start * size : part.stop * size], size)
        share, together = _accelerations(means, rate_hz, per_m)
        falls = together & ((np.abs(share) > ACCELERATION[0]) & (np.abs(share) < ACCELERATION[1])).all(axis=0)
        turned = share < 0.0
        if (falls & ~turned.any(axis=0)).any():
            return nothing
    least = LEAST_S * rate_hz - window
    if falls.any():
        patterns = np.unique(turned[:, falls], axis=1).T
        longest = [_longest(falls & (turned == one[:, None]).all(axis=0)) for one in patterns]
        best = int(np.argmax(longest))
        return FallSigns(tuple(patterns[best].tolist())) if longest[best] >= least else nothing
    even = together & ~turned.any(axis=0)
    if _longest(even) < least:
        return nothing
    begin, end = max(runs_of(even), key=lambda run: run[1] - run[0])
    return FallSigns(nothing.backwards, float(median(share[:, begin:end])))


def _accelerations(means_v: FloatArray, rate_hz: float, rad_per_m: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Return each receiver's acceleration along the vertical over g, and where all have about one of it and one speed.

    Means of I1, Q1, I2, ... at the rate; windows as of `phase_parabolas`, shapes (n_receivers, n) and (n,).
    """
    found = [phase_parabolas(pair, rate_hz, window_of(rate_hz)) for pair in means_v.reshape(-1, 2, means_v.shape[1])]
    speed = np.stack([one.speed_rad_s for one in found]) / rad_per_m
    share = np.stack([one.bend_rad_s2 for one in found]) / (NOMINAL_GRAVITY_M_S2 * rad_per_m)
    smooth = (np.stack([one.misfit_rad for one in found]) < LARGEST_MISFIT_RAD).all(axis=0)
    # one acceleration and one speed, whatever their signs: what moves sideways shows each receiver another
    return share, smooth & (np.abs(speed) > LEAST_SPEED).all(axis=0) & _alike(speed) & _alike(share)


def _alike(values: FloatArray) -> BoolArray:
    """Return where the receivers' values, (n_receivers, n), have about one size."""
    sizes = np.abs(values)
    return np.asarray(sizes.max(axis=0) < MOST_APART * sizes.min(axis=0))


def _longest(where: BoolArray) -> int:
    return int(np.diff(runs_of(where)).max(initial=0))
