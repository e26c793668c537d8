"""Slow motion under noise: too slow to shake the voltages within 20 ms, yet it turns the phase."""

from __future__ import annotations

import numpy as np

from radargui.model.arrays import FloatArray
from radargui.motion.mains import MAINS_HZ, without_mains
from radargui.motion.noise import block_means

BLOCK_S = 0.005
LEAST_TURN_RAD = 1.5 * np.pi
LARGEST_SPREAD = 0.35
LEAST_RADIUS = 6.0
"""In standard deviations of a block mean."""


def turns_slowly(volts: FloatArray, sample_rate_hz: float, noise_v: FloatArray) -> bool:
    """Return whether I and Q run along a circle in every receiver, three quarters of a turn or more.

    A drift of the offsets makes lines and bends, which do not run round a centre at one distance in all receivers at
    once; a hum is taken off first.

    Parameters
    ----------
    volts
        Finite, shape (2 n_receivers, n_samples).
    sample_rate_hz
        Rate of each channel.
    noise_v
        White noise of each channel, shape (2 n_receivers,).
    """
    size = max(1, round(BLOCK_S * sample_rate_hz))
    means = block_means(volts, size)
    if means.shape[1] < 16:
        return False
    for frequency in MAINS_HZ:
        means = without_mains(means, sample_rate_hz / size, frequency, line=False)
    pairs = zip(means[0::2], means[1::2], noise_v[0::2] / np.sqrt(size), strict=True)
    return all(_round(i, q, float(noise)) for i, q, noise in pairs)


def _round(i: FloatArray, q: FloatArray, noise: float) -> bool:
    design = np.stack([2.0 * i, 2.0 * q, np.ones_like(i)], axis=1)
    (a, b, _), *_ = np.linalg.lstsq(design, i * i + q * q, rcond=None)
    radius = np.hypot(i - a, q - b)
    size = float(radius.mean())
    if size < LEAST_RADIUS * noise or float(radius.std()) > LARGEST_SPREAD * size:
        return False
    return float(np.ptp(np.unwrap(np.arctan2(q - b, i - a)))) >= LEAST_TURN_RAD
