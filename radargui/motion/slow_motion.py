"""Slow motion under noise: too slow to shake the voltages within 20 ms, yet it turns the phase."""

from __future__ import annotations

import numpy as np

from radargui.model.arrays import FloatArray
from radargui.motion.mains import MAINS_HZ, without_mains
from radargui.motion.noise import block_means

POOL_S, BLOCK_S = 0.0005, 0.005
LEAST_TURN_RAD = 1.5 * np.pi
LEAST_IN_ALL_RAD = np.pi
SURE_TURN_RAD = 4.0 * np.pi
LARGEST_SPREAD, LARGEST_SPREAD_IF_SURE = 0.2, 0.45
LEAST_RADIUS = 6.0
"""In standard deviations of a block mean."""


def turns_slowly(volts: FloatArray, sample_rate_hz: float, noise_v: FloatArray) -> bool:
    """Return whether I and Q run along circles: in two receivers three quarters of a turn, or in one and half in all.

    A drift of the offsets makes lines and bends, which do not run round a centre at one distance in several receivers
    at once, nor twice round even a rough circle in one; a hum is taken off first.

    Parameters
    ----------
    volts
        Finite, shape (2 n_receivers, n_samples).
    sample_rate_hz
        Rate of each channel.
    noise_v
        White noise of each channel, shape (2 n_receivers,).
    """
    size = max(1, round(POOL_S * sample_rate_hz))
    means, rate_hz = block_means(volts, size), sample_rate_hz / size
    for frequency in MAINS_HZ:
        means = without_mains(means, rate_hz, frequency, line=False)
    further = max(1, round(BLOCK_S * rate_hz))
    means = block_means(means, further)
    if means.shape[1] < 16:
        return False
    pairs = zip(means[0::2], means[1::2], noise_v[0::2] / np.sqrt(size * further), strict=True)
    circles = [_turn(i, q, float(noise)) for i, q, noise in pairs]
    if any(turn >= SURE_TURN_RAD and spread <= LARGEST_SPREAD_IF_SURE for turn, spread in circles):
        return True
    turns = sorted((turn if spread <= LARGEST_SPREAD else 0.0 for turn, spread in circles), reverse=True)
    return turns[0] >= LEAST_TURN_RAD and (turns[-1] >= LEAST_IN_ALL_RAD or turns[1] >= LEAST_TURN_RAD)


def _turn(i: FloatArray, q: FloatArray, noise: float) -> tuple[float, float]:
    """Return the angle run through round the best circle, and the radii's spread; no angle within the noise."""
    design = np.stack([2.0 * i, 2.0 * q, np.ones_like(i)], axis=1)
    (a, b, _), *_ = np.linalg.lstsq(design, i * i + q * q, rcond=None)
    radius = np.hypot(i - a, q - b)
    size = float(radius.mean())
    if size < LEAST_RADIUS * noise:
        return 0.0, np.inf
    return float(np.ptp(np.unwrap(np.arctan2(q - b, i - a)))), float(radius.std()) / size
