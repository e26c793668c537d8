"""Which antenna each channel belongs to, from how it answered to a hand in front of each."""

from __future__ import annotations

import numpy as np
from scipy.optimize import linear_sum_assignment

from radargui.model.arrays import BoolArray, FloatArray, IntArray

CLEAR = 1.4
"""A channel answers clearly to an antenna when it does so this many times more than to any other."""

_FLOOR = 1e-3
_ROUNDS = 50


def owners(waves_v: FloatArray, dead: BoolArray) -> tuple[IntArray, BoolArray]:
    """Return the antenna of each channel, two channels an antenna, and whether that is clear.

    Neither the gain of a channel nor how hard the hand was waved matters: the logarithms of the answers are freed of
    the mean of each channel and of each wave before channels are given to antennas (the assignment with the largest
    sum). A channel that is dead or not clear keeps the place that it should have, where that is left.

    Parameters
    ----------
    waves_v
        Answers, shape (n_receivers, n_channels).
    dead
        Which channels answer to nothing, shape (n_channels,).

    Returns
    -------
    tuple
        Receivers counted from 0, shape (n_channels,), and True where it is clear.
    """
    n_receivers, n_channels = waves_v.shape
    expected = np.arange(n_channels) // 2
    if n_receivers == 1:
        return expected, ~dead
    score = _contrast(waves_v, ~dead)
    score[:, dead] = 0.0
    channels = np.arange(n_channels)
    biased = score.copy()
    biased[expected, channels] += 0.5 * np.log(CLEAR)
    rows, columns = linear_sum_assignment(np.repeat(biased, 2, axis=0), maximize=True)
    owner = np.empty(n_channels, dtype=np.intp)
    owner[columns] = rows // 2
    others = score.copy()
    others[owner, channels] = -np.inf
    clear = score[owner, channels] - others.max(axis=0) >= np.log(CLEAR)
    return owner, clear & ~dead


def _contrast(waves_v: FloatArray, alive: BoolArray) -> FloatArray:
    """Return log answers without the means of channels and of waves, shape (n_receivers, n_channels)."""
    scale = waves_v.max(initial=0.0) or 1.0
    score = np.log(np.maximum(waves_v / scale, _FLOOR))
    for _ in range(_ROUNDS if alive.any() else 0):
        score -= score.mean(axis=0)
        score -= score[:, alive].mean(axis=1, keepdims=True)
    return score
