"""The segment with motion, and the rest before it."""

from __future__ import annotations

import numpy as np

from radargui.model.arrays import BoolArray, FloatArray
from radargui.model.segment import Segment
from radargui.motion.activity import activity, block_size
from radargui.motion.mains import MAINS_HZ, without_mains
from radargui.motion.noise import block_means, white_noise_v
from radargui.motion.slow_motion import turns_slowly

THRESHOLD = 8.0
"""Motion shakes the block means this many times harder than the quiet part does (in variance, squared)."""
NOT_QUIET = 0.05
"""A lowest activity above this share of the highest is motion throughout, not a quiet part."""
LEAST_MOTION_S = 0.01
SLOW_BLOCK_S = 0.025
"""Averaging for a motion too slow to be seen within 20 ms; eight such blocks make a window."""
REST_MARGIN_S = 0.02
"""Kept free between the rest and the motion: a fall begins slowly."""
LEAST_REST_S = 0.05


def find_segment(volts: FloatArray, sample_rate_hz: float, noise_v: FloatArray | None = None) -> Segment | None:
    """Find the segment with motion (Rech & Huang 2019, section III, step 1).

    Motion is where the voltages move more within 20 ms than in the quiet part of the record, and more than their
    white noise; a hum of the mains is not motion. Where nothing does, but I and Q run along a circle, windows ten times
    as long are looked at.

    Parameters
    ----------
    volts
        Shape (n_channels, n_samples); NaN are held.
    sample_rate_hz
        Rate of each channel.
    noise_v
        `floor_of_noise` of these volts where it is known already, shape (n_channels,).

    Returns
    -------
    Segment or None
        None where nothing moves.
    """
    if volts.shape[1] < 16:
        return None
    volts = held(volts)
    noise = floor_of_noise(volts) if noise_v is None else noise_v
    size = block_size(sample_rate_hz)
    level = activity(volts, sample_rate_hz, noise)
    moving = _moving(level, volts, sample_rate_hz, noise)
    if moving is None and turns_slowly(volts, sample_rate_hz, noise):
        size = max(1, round(SLOW_BLOCK_S * sample_rate_hz))
        level = activity(block_means(volts, size), sample_rate_hz / size, noise / np.sqrt(size))
        moving = np.asarray(level > THRESHOLD)
    if moving is None or not moving.any():
        return None
    blocks = np.flatnonzero(moving)
    first, last = int(blocks[0]) * size, (int(blocks[-1]) + 1) * size
    if blocks[-1] == level.size - 1:
        last = volts.shape[1]
    rest_last = first - round(REST_MARGIN_S * sample_rate_hz)
    if rest_last < LEAST_REST_S * sample_rate_hz:
        rest_last = 0
    return Segment(first, last, 0, rest_last)


def held(volts: FloatArray) -> FloatArray:
    """Return the voltages with non-finite samples replaced by the one before (the first finite one at the start)."""
    bad = ~np.isfinite(volts)
    if not bad.any():
        return volts
    out = volts.copy()
    for channel, wrong in zip(out, bad, strict=True):
        good = np.flatnonzero(~wrong)
        if good.size == 0:
            channel[:] = 0.0
            continue
        place = np.maximum(np.searchsorted(good, np.arange(channel.size), side="right") - 1, 0)
        channel[:] = channel[good[place]]
    return out


def floor_of_noise(volts: FloatArray) -> FloatArray:
    """Return the white noise of each channel, never below a millionth of what the channel does."""
    noise = white_noise_v(volts)
    span = np.ptp(volts, axis=1)
    return np.asarray(np.maximum(noise, np.maximum(1e-6 * span, 1e-12)))


def _moving(level: FloatArray, volts: FloatArray, sample_rate_hz: float, noise: FloatArray) -> BoolArray | None:
    high = float(np.percentile(level, 99.0))
    quiet = max(1.0, float(np.percentile(level, 5.0)))
    if quiet > NOT_QUIET * high:
        if high < THRESHOLD or _is_hum(volts, sample_rate_hz, noise):
            return None
        quiet = 1.0
    moving = level > THRESHOLD * quiet
    moving = without_blips(moving, max(1, round(LEAST_MOTION_S * sample_rate_hz / block_size(sample_rate_hz))))
    return moving if moving.any() else None


def _is_hum(volts: FloatArray, sample_rate_hz: float, noise: FloatArray) -> bool:
    size = max(1, round(sample_rate_hz / 2000.0))
    means, rate = block_means(volts, size), sample_rate_hz / size
    for frequency in MAINS_HZ:
        rest = without_mains(means, rate, frequency)
        if float(np.percentile(activity(rest, rate, noise / np.sqrt(size)), 99.0)) < THRESHOLD:
            return _stands(means, rate, frequency)
    return False


def _stands(means: FloatArray, rate: float, frequency: float) -> bool:
    """Whether the line at the mains frequency stands (hum) rather than turns one way (steady motion)."""
    turn = np.exp(-2j * np.pi * frequency * np.arange(means.shape[1]) / rate)
    z = means[0::2] + 1j * means[1::2]
    z = z - z.mean(axis=1, keepdims=True)
    ahead, back = np.abs((z * turn).mean(axis=1)), np.abs((z * turn.conj()).mean(axis=1))
    purity = np.abs(ahead - back) / np.maximum(ahead + back, 1e-30)
    return bool(np.median(purity) < 0.8)


def without_blips(moving: BoolArray, least: int) -> BoolArray:
    """Return `moving` without runs shorter than `least` blocks."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], moving.astype(np.int8), [0]])))
    out = moving.copy()
    for begin, end in edges.reshape(-1, 2):
        if end - begin < least:
            out[begin:end] = False
    return out
