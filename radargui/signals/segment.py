"""Find the part of a recording that moves: where the voltages change by more than noise and hum."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from radargui.model.arrays import BoolArray, FloatArray, runs_of
from radargui.signals.averager import block_means
from radargui.signals.ellipse import circle_through
from radargui.signals.hum import MAINS_HZ, without_mains
from radargui.signals.rows import held_beyond, pairs_of


@dataclass(frozen=True, slots=True)
class MotionSettings:
    """When voltages are called moving; chosen by hand on noise, hums, drifts and slow pendulums (test_segment).

    Attributes
    ----------
    threshold
        Least ratio of the variance of block means to that of the quiet part, in a motion.
    not_quiet
        If the lowest activity exceeds this share of the highest, everything is motion and there is no quiet part.
    min_motion_s
        A motion lasts at least so long; what is shorter is a spike.
    slow_block_s
        Averaging for a motion too slow to be seen within 20 ms; eight such blocks make a window.
    circle_block_s
        Means in which a slow circle is sought, longer than those of which the hum is taken off, against noise.
    two_turns_rad, one_turn_rad
        Turns with which a circle counts: three quarters of a turn in two receivers, or so much in one and half a turn
        in all.
    sure_turn_rad
        A receiver that turns this far is enough by itself.
    spread, spread_if_sure
        Largest standard deviation of the radius of such circles, in radii: a drift makes bends and lines.
    min_radius
        Least radius, in standard deviations of a block mean.
    pause_s
        Two motions with at least so much rest between them are two: cut in the middle, each has a rest of a quarter of
        a second, which is enough to be one (`short_s` of the onset). No flight of a bouncing sphere stands still so
        long.
    """

    threshold: float = 8.0
    not_quiet: float = 0.05
    min_motion_s: float = 0.01
    slow_block_s: float = 0.025
    circle_block_s: float = 0.005
    two_turns_rad: float = 1.5 * np.pi
    one_turn_rad: float = np.pi
    sure_turn_rad: float = 4.0 * np.pi
    spread: float = 0.2
    spread_if_sure: float = 0.45
    min_radius: float = 6.0
    pause_s: float = 0.5


@dataclass(frozen=True, slots=True)
class Motion:
    """From the first to the last motion in a stretch of samples.

    Attributes
    ----------
    first, last
        Samples first:last.
    window_s
        Length of the window in which the voltages were seen to move: the motion may begin half a window after `first`.
    pauses
        First and last sample of each rest of at least `pause_s` between two motions in it.
    """

    first: int
    last: int
    window_s: float
    pauses: tuple[tuple[int, int], ...] = ()


SETTINGS = MotionSettings()
MIN_SAMPLES = 16  # two of the shortest windows (`window_blocks`); as many means tell a circle. Chosen by hand


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
    if volts.shape[1] < MIN_SAMPLES:
        return None
    size = block_size(sample_rate_hz)
    # a mean of n samples has a noise smaller by sqrt(n)
    means, rate_hz, noise_v = block_means(volts, size), sample_rate_hz / size, noise_v / np.sqrt(size)
    level = activity(means, rate_hz, noise_v)
    moving = moving_blocks(level, rate_hz)
    motions = motions_apart(moving, rate_hz)
    if not moving.any() and turns_slowly(means, rate_hz, noise_v):
        further = max(1, round(SETTINGS.slow_block_s * rate_hz))
        longer = block_means(means, further)
        size, rate_hz = size * further, rate_hz / further
        level = activity(longer, rate_hz, noise_v / np.sqrt(further))
        moving = np.asarray(level > SETTINGS.threshold)
    if not moving.any():
        return None
    blocks = np.flatnonzero(moving)
    # a motion that is cut off by the end of the record has no rest after it
    at_end = blocks[-1] == level.size - 1
    last = volts.shape[1] if at_end else (int(blocks[-1]) + 1) * size
    rests = tuple((one[1] * size, other[0] * size) for one, other in pairwise(motions))
    return Motion(int(blocks[0]) * size, last, window_blocks(rate_hz) / rate_hz, rests)


BLOCK_S = 0.0005
"""Averaging that still follows a Doppler of several hundred Hz."""
WINDOW_S = 0.02
"""Long enough to see the slow start of a fall, short enough to tell when."""


def block_size(sample_rate_hz: float) -> int:
    """Return how many samples one block of the activity averages."""
    return max(1, round(BLOCK_S * sample_rate_hz))


def window_blocks(rate_hz: float) -> int:
    """Return how many blocks one window of the activity holds; they come at the rate."""
    return max(8, round(WINDOW_S * rate_hz))


def activity(means_v: FloatArray, rate_hz: float, noise_v: FloatArray) -> FloatArray:
    """Return the variance of block means in a sliding window over the variance that white noise gives them.

    About 1 where nothing moves; pooled over the channels, each in units of its own noise.

    Parameters
    ----------
    means_v
        Finite, shape (n_channels, n_blocks).
    rate_hz
        Blocks a second.
    noise_v
        White noise of a mean of each channel, shape (n_channels,), above zero.

    Returns
    -------
    FloatArray
        One value a block, shape (n_blocks,); the window is centred on it.
    """
    means, window = means_v / noise_v[:, None], window_blocks(rate_hz)
    if means.shape[1] <= window:
        # a record shorter than a window has one activity
        return np.full(means.shape[1], float(means.var(axis=1).mean()) if means.size else 0.0)
    return sliding_variance(means, window)


def sliding_variance(values: FloatArray, window: int) -> FloatArray:
    """Return the variance in a centred window, ends held, mean over the channels of `values` (n_channels, n): (n,)."""
    n_channels, n = values.shape
    centred = values - values.mean(axis=1, keepdims=True)
    total = np.zeros((n_channels + 1, n + 1))
    np.cumsum(centred, axis=1, out=total[1:, 1:])
    # of the squares only their sum over the channels counts
    np.cumsum(np.einsum("cn,cn->n", centred, centred), out=total[0, 1:])
    mean = (total[:, window:] - total[:, :-window]) / window
    variance = (mean[0] - np.einsum("cn,cn->n", mean[1:], mean[1:])) / n_channels
    return np.maximum(held_beyond(variance, window // 2, n), 0.0)


def moving_blocks(level: FloatArray, rate_hz: float) -> BoolArray:
    """Return which blocks move, by the activity of all blocks of a record; shapes (n_blocks,)."""
    # a twentieth of the record is quiet in every one that is not motion throughout; a spike does not last
    low, high = np.sort(level)[[round(0.05 * (level.size - 1)), -min(_shortest(rate_hz), level.size)]].tolist()
    # white noise alone makes one: less is chance
    quiet = max(1.0, low)
    if quiet > SETTINGS.not_quiet * high:
        quiet = 1.0 if high > SETTINGS.threshold else np.inf
    moving = without_blips(level > SETTINGS.threshold * quiet, round(SETTINGS.min_motion_s * rate_hz))
    return moving & bool(motions_apart(moving, rate_hz))


def _shortest(rate_hz: float) -> int:
    """Return of how many blocks a motion is: one wild sample shakes every window that holds it."""
    return window_blocks(rate_hz) + max(1, round(SETTINGS.min_motion_s * rate_hz))


def without_blips(moving: BoolArray, least: int) -> BoolArray:
    """Return `moving`, shape (n_blocks,), without runs shorter than `least` blocks."""
    out = moving.copy()
    for begin, end in runs_of(moving):
        if end - begin < least:
            out[begin:end] = False
    return out


def motions_apart(moving: BoolArray, rate_hz: float, pause_s: float = SETTINGS.pause_s) -> list[tuple[int, int]]:
    """Return the first block of each motion and the one after its last; between two there is so much rest."""
    runs = runs_of(moving)
    apart = np.flatnonzero(runs[1:, 0] - runs[:-1, 1] >= pause_s * rate_hz) + 1
    motions = [one for one in np.split(runs, apart) if np.ptp(one, axis=1).max(initial=0) >= _shortest(rate_hz)]
    return [(int(one[0, 0]), int(one[-1, 1])) for one in motions]


def turns_slowly(means_v: FloatArray, rate_hz: float, noise_v: FloatArray) -> bool:
    """Return whether I and Q run along circles: in two receivers three quarters of a turn, or in one and half in all.

    A drift of the offsets makes lines and bends, which do not run round a centre at one distance in several receivers
    at once, nor twice round even a rough circle in one; a hum is taken off first. Parameters as in `activity`.
    """
    for frequency in MAINS_HZ:
        # the straight line stays: of a slow motion it is a part
        means_v = without_mains(means_v, rate_hz, frequency, line=False)
    further = max(1, round(SETTINGS.circle_block_s * rate_hz))
    means = block_means(means_v, further)
    if means.shape[1] < MIN_SAMPLES:
        return False
    min_v = SETTINGS.min_radius / np.sqrt(further) * noise_v[0::2]
    circles = [_turn(means[pair], float(least)) for pair, least in zip(pairs_of(means), min_v, strict=True)]
    if any(turn >= SETTINGS.sure_turn_rad and spread <= SETTINGS.spread_if_sure for turn, spread in circles):
        return True
    turns = sorted((turn if spread <= SETTINGS.spread else 0.0 for turn, spread in circles), reverse=True)
    enough = SETTINGS.two_turns_rad
    return turns[0] >= enough and (turns[-1] >= SETTINGS.one_turn_rad or turns[1] >= enough)


def _turn(pair_v: FloatArray, min_radius: float) -> tuple[float, float]:
    """Return the angle run through round the best circle, and the radii's spread; no angle within the noise."""
    # an arc of a drift has any centre, far away or near: how evenly it is kept tells a circle
    circle = circle_through(pair_v)
    if circle.amplitude_v < min_radius:
        return 0.0, np.inf
    x, y = circle.apply(pair_v)
    return float(np.ptp(np.unwrap(np.arctan2(y, x)))), float(np.hypot(x, y).std())
