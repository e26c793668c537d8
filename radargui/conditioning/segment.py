"""The segment with motion: where the voltages move more than their noise, and by more than a hum (method 2, Motion)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from radargui.conditioning.hum import HARMONICS, MAINS_HZ, without_mains
from radargui.conditioning.noise import activity, block_means, block_size, window_blocks
from radargui.model.arrays import BoolArray, FloatArray, order_statistics, runs_of


@dataclass(frozen=True, slots=True)
class MotionSettings:
    """When voltages are called moving; chosen by hand on noise, hums, drifts and slow pendulums (test_segment).

    Attributes
    ----------
    threshold
        Motion shakes the block means this many times harder than the quiet part does (in variance).
    not_quiet
        A lowest activity above this share of the highest is motion throughout, not a quiet part.
    least_motion_s
        A shorter stir is a spike.
    slow_block_s
        Averaging for a motion too slow to be seen within 20 ms; eight such blocks make a window.
    circle_pool_s, circle_block_s
        Means in which a slow circle is sought: short ones for the hum to be taken off, longer ones against noise.
    two_turns_rad, one_turn_rad
        A circle counts with three quarters of a turn in two receivers, or so much in one and half a turn in all.
    sure_turn_rad
        Twice round is sure.
    spread, spread_if_sure
        Largest standard deviation of the radius, in radii, of such circles: a drift makes bends and lines.
    least_radius
        In standard deviations of a block mean.
    hum_purity
        A line at the mains frequency that turns less than this one way is a hum, else a motion at that Doppler.
    """

    threshold: float = 8.0
    not_quiet: float = 0.05
    least_motion_s: float = 0.01
    slow_block_s: float = 0.025
    circle_pool_s: float = 0.0005
    circle_block_s: float = 0.005
    two_turns_rad: float = 1.5 * np.pi
    one_turn_rad: float = np.pi
    sure_turn_rad: float = 4.0 * np.pi
    spread: float = 0.2
    spread_if_sure: float = 0.45
    least_radius: float = 6.0
    hum_purity: float = 0.8


@dataclass(frozen=True, slots=True)
class Motion:
    """From the first to the last motion in a stretch of samples.

    Attributes
    ----------
    first, last
        Samples first:last.
    window_s
        Span within which the voltages were seen to shake: the motion may begin half of it after `first`.
    """

    first: int
    last: int
    window_s: float


SETTINGS = MotionSettings()
_LEAST_SAMPLES = 16  # two of the shortest windows (`window_blocks`); as many means tell a circle. Chosen by hand


def find_motion(volts: FloatArray, sample_rate_hz: float, noise_v: FloatArray) -> Motion | None:
    """Find the samples with motion (Rech & Huang 2019, section III, step 1).

    Motion is where the voltages move more within 20 ms than in the quiet part of the record, and more than their
    white noise; a hum of the mains is not motion. Where nothing does, but I and Q run along a circle, windows ten times
    as long are looked at.

    Parameters
    ----------
    volts
        Finite, shape (2 n_receivers, n_samples).
    sample_rate_hz
        Rate of each channel.
    noise_v
        White noise of each channel, shape (2 n_receivers,).

    Returns
    -------
    Motion or None
        None where nothing moves.
    """
    if volts.shape[1] < _LEAST_SAMPLES:
        return None
    size, rate_hz = block_size(sample_rate_hz), sample_rate_hz
    level = activity(volts, sample_rate_hz, noise_v)
    moving = _moving(level, volts, sample_rate_hz, noise_v)
    if moving is None and turns_slowly(volts, sample_rate_hz, noise_v):
        size = max(1, round(SETTINGS.slow_block_s * sample_rate_hz))
        rate_hz = sample_rate_hz / size
        level = activity(block_means(volts, size), rate_hz, noise_v / np.sqrt(size))
        moving = np.asarray(level > SETTINGS.threshold)
    if moving is None or not moving.any():
        return None
    blocks = np.flatnonzero(moving)
    # a motion that is cut off by the end of the record has no rest after it
    at_end = blocks[-1] == level.size - 1
    last = volts.shape[1] if at_end else (int(blocks[-1]) + 1) * size
    window_s = window_blocks(rate_hz) * block_size(rate_hz) / rate_hz
    return Motion(int(blocks[0]) * size, last, window_s)


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


def without_blips(moving: BoolArray, least: int) -> BoolArray:
    """Return `moving`, shape (n_blocks,), without runs shorter than `least` blocks."""
    out = moving.copy()
    for begin, end in runs_of(moving):
        if end - begin < least:
            out[begin:end] = False
    return out


def turns_slowly(volts: FloatArray, sample_rate_hz: float, noise_v: FloatArray) -> bool:
    """Return whether I and Q run along circles: in two receivers three quarters of a turn, or in one and half in all.

    A drift of the offsets makes lines and bends, which do not run round a centre at one distance in several receivers
    at once, nor twice round even a rough circle in one; a hum is taken off first. Parameters as in `find_motion`.
    """
    size = max(1, round(SETTINGS.circle_pool_s * sample_rate_hz))
    means, rate_hz = block_means(volts, size), sample_rate_hz / size
    for frequency in MAINS_HZ:
        # the straight line stays: of a slow motion it is a part
        means = without_mains(means, rate_hz, frequency, line=False)
    further = max(1, round(SETTINGS.circle_block_s * rate_hz))
    means = block_means(means, further)
    if means.shape[1] < _LEAST_SAMPLES:
        return False
    pairs = zip(means[0::2], means[1::2], noise_v[0::2] / np.sqrt(size * further), strict=True)
    circles = [_turn(i, q, SETTINGS.least_radius * float(noise)) for i, q, noise in pairs]
    if any(turn >= SETTINGS.sure_turn_rad and spread <= SETTINGS.spread_if_sure for turn, spread in circles):
        return True
    turns = sorted((turn if spread <= SETTINGS.spread else 0.0 for turn, spread in circles), reverse=True)
    enough = SETTINGS.two_turns_rad
    return turns[0] >= enough and (turns[-1] >= SETTINGS.one_turn_rad or turns[1] >= enough)


def _turn(i: FloatArray, q: FloatArray, least_radius: float) -> tuple[float, float]:
    """Return the angle run through round the best circle, and the radii's spread; no angle within the noise."""
    design = np.stack([2.0 * i, 2.0 * q, np.ones_like(i)], axis=1)
    # linear in the centre: a rough circle is all that is asked
    (a, b, _), *_ = np.linalg.lstsq(design, i * i + q * q, rcond=None)
    # an arc of a drift has any centre, far away or near: how evenly it is kept tells a circle
    radius = np.hypot(i - a, q - b)
    size = float(radius.mean())
    if size < least_radius:
        return 0.0, np.inf
    return float(np.ptp(np.unwrap(np.arctan2(q - b, i - a)))), float(radius.std()) / size


def _moving(level: FloatArray, volts: FloatArray, sample_rate_hz: float, noise: FloatArray) -> BoolArray | None:
    low, high = order_statistics(level, 0.05, 0.99).tolist()
    # white noise alone makes one: less is chance
    quiet = max(1.0, low)
    if quiet > SETTINGS.not_quiet * high:
        if high < SETTINGS.threshold or _is_hum(volts, sample_rate_hz, noise):
            return None
        quiet = 1.0
    moving = level > SETTINGS.threshold * quiet
    least = max(1, round(SETTINGS.least_motion_s * sample_rate_hz / block_size(sample_rate_hz)))
    moving = without_blips(moving, least)
    # one wild sample shakes every window that holds it: what lasts no longer than a window is no motion by itself
    return moving if without_blips(moving, window_blocks(sample_rate_hz) + least).any() else None


def _is_hum(volts: FloatArray, sample_rate_hz: float, noise: FloatArray) -> bool:
    size = max(1, round(sample_rate_hz / 2000.0))
    means, rate = block_means(volts, size), sample_rate_hz / size
    for frequency in MAINS_HZ:
        rest = without_mains(means, rate, frequency)
        if float(np.percentile(activity(rest, rate, noise / np.sqrt(size)), 99.0)) < SETTINGS.threshold:
            return _stands(means, rate, frequency, SETTINGS.hum_purity)
    return False


def _stands(means: FloatArray, rate: float, frequency: float, purity: float) -> bool:
    """Whether the strongest line at a multiple of the mains stands (hum) rather than turns one way (steady motion)."""
    z = means[0::2] + 1j * means[1::2]
    z = z - z.mean(axis=1, keepdims=True)
    cycles = frequency * np.arange(means.shape[1]) / rate
    turn = np.exp(-2j * np.pi * np.arange(1, HARMONICS + 1)[:, None] * cycles) / cycles.size
    ahead, back = np.abs(z @ turn.T), np.abs(z @ turn.conj().T)
    strongest = int(np.argmax((ahead + back).sum(axis=0)))
    ahead, back = ahead[:, strongest], back[:, strongest]
    one_way = np.abs(ahead - back) / np.maximum(ahead + back, 1e-30)
    return bool(np.median(one_way) < purity)
