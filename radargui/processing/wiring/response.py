"""How hard each channel answers in each step of the wiring check."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from radargui.model.arrays import BoolArray, FloatArray

DEAD = 0.1
"""A channel that answers less than this share of the others, everywhere, is dead."""
LEAST = 3.0
"""A channel answers where it shakes this many times harder than in quiet."""


@dataclass(frozen=True, slots=True)
class WiringSamples:
    """What was measured; all arrays (n_channels, n), volts, at `rate_hz`; NaN where samples were lost.

    Attributes
    ----------
    rate_hz
        After averaging.
    quiet, away
        Nothing moves; the tracer moves away.
    waves
        A hand in front of each receiver.
    clipped
        Share of the samples that sat at an end of the range, over all steps, shape (n_channels,).
    """

    rate_hz: float
    quiet: FloatArray
    away: FloatArray
    waves: tuple[FloatArray, ...]
    clipped: FloatArray


def shake_v(volts: FloatArray) -> FloatArray:
    """Return the standard deviation of each channel in V, shape (n_channels,); 0 where there are no samples."""
    known = volts[:, np.isfinite(volts).all(axis=0)]
    return np.asarray(known.std(axis=1)) if known.shape[1] else np.zeros(volts.shape[0])


def responses_v(samples: WiringSamples) -> tuple[FloatArray, FloatArray]:
    """Return how hard each channel answers beyond its quiet level: sqrt(std^2 - quiet^2).

    Returns
    -------
    tuple
        When the tracer moves away, shape (n_channels,), and for each wave, shape (n_receivers, n_channels), in V.
    """
    quiet = shake_v(samples.quiet)
    steps = np.array([shake_v(step) for step in (samples.away, *samples.waves)])
    beyond = np.sqrt(np.clip(steps**2 - quiet**2, 0.0, None))
    beyond[steps < LEAST * quiet] = 0.0
    return beyond[0], beyond[1:]


def dead_channels(away_v: FloatArray, waves_v: FloatArray) -> BoolArray:
    """Return which channels answer to nothing, shape (n_channels,); parameters as `responses_v` returns them."""
    strongest = waves_v.max(axis=0, initial=0.0)
    return np.asarray((away_v <= DEAD * _typical(away_v)) & (strongest <= DEAD * _typical(strongest)))


def _typical(values: FloatArray) -> float:
    """Return the upper median: with half of the channels dead it is still one that lives."""
    return float(np.sort(values)[values.size // 2])
