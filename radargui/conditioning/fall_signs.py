"""Which way the phases turn in a fall: a receiver whose phase turns the other way has its wires, or sign, exchanged."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

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
from radargui.model.arrays import BoolArray, FloatArray, runs_of
from radargui.model.gravity import NOMINAL_GRAVITY_M_S2
from radargui.model.setup import Setup

LEAST_S = 0.06
"""All phases have to turn with a free fall's acceleration for so long, whatever their signs."""
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
    means, window = _means(conditioned, size), window_of(rate_hz)
    if len(along) < LEAST_RECEIVERS or along.min() < LEAST_ALONG or means.shape[2] < 2 * window:
        return nothing
    per_m = 2.0 * np.pi / setup.radar.wavelength_m * along[:, None]
    found = [phase_parabolas(pair, rate_hz, window) for pair in means]
    speed = np.stack([one.speed_rad_s for one in found]) / per_m
    share = np.stack([one.bend_rad_s2 for one in found]) / (NOMINAL_GRAVITY_M_S2 * per_m)
    smooth = (np.stack([one.misfit_rad for one in found]) < LARGEST_MISFIT_RAD).all(axis=0)
    # one acceleration and one speed, whatever their signs: what moves sideways shows each receiver another
    together = smooth & (np.abs(speed) > LEAST_SPEED).all(axis=0) & _alike(speed) & _alike(share)
    falls = together & ((np.abs(share) > ACCELERATION[0]) & (np.abs(share) < ACCELERATION[1])).all(axis=0)
    least, turned = LEAST_S * rate_hz - window, share < 0.0
    if (falls & ~turned.any(axis=0)).any():
        return nothing
    if falls.any():
        patterns = np.unique(turned[:, falls], axis=1).T
        longest = [_longest(falls & (turned == one[:, None]).all(axis=0)) for one in patterns]
        best = int(np.argmax(longest))
        return FallSigns(tuple(patterns[best].tolist())) if longest[best] >= least else nothing
    even = together & ~turned.any(axis=0)
    if _longest(even) < least:
        return nothing
    begin, end = max(runs_of(even), key=lambda run: run[1] - run[0])
    return FallSigns(nothing.backwards, float(np.median(share[:, begin:end])))


def _means(conditioned: Conditioned, size: int) -> FloatArray:
    """Return the means of so many samples of each pair, shape (n_receivers, 2, n)."""
    volts, n = conditioned.volts, conditioned.n_samples // size
    return np.asarray(volts[:, : n * size].reshape(-1, 2, n, size).mean(axis=3))


def _alike(values: FloatArray) -> BoolArray:
    """Return where the receivers' values, (n_receivers, n), have about one size."""
    sizes = np.abs(values)
    return np.asarray(sizes.max(axis=0) < MOST_APART * sizes.min(axis=0))


def _longest(where: BoolArray) -> int:
    return int(np.diff(runs_of(where)).max(initial=0))
