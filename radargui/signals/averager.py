"""Average consecutive samples: voltages, raw codes, and codes while they arrive."""

from __future__ import annotations

import numpy as np

from radargui.model.arrays import BoolArray, FloatArray, RawArray
from radargui.model.recording import Digitisation


class Averager:
    """Averages blocks of `size` consecutive samples of each channel, however the samples are divided when they arrive.

    Codes are averaged before they are scaled. That is exact where the scaling is a line; the curvature of a device's
    scaling is parts in a million and does not show in a live picture.

    Parameters
    ----------
    digitisation
        Channels and scale of the samples that will be pushed.
    size
        Samples of a block.
    """

    def __init__(self, digitisation: Digitisation, size: int) -> None:
        self._digitisation = digitisation
        self.size = size
        self._last = np.zeros(digitisation.n_channels)
        self.clear()

    @property
    def waiting(self) -> int:
        """Samples that wait for their block to be complete."""
        return int(self._left.shape[1])

    def clear(self) -> None:
        """Forget the samples of the block that is not complete."""
        self._left: RawArray = np.empty((self._digitisation.n_channels, 0))

    def push(self, samples: RawArray) -> FloatArray:
        """Take the next samples, shape (n_channels, n); return the means complete now in volts, (n_channels, m).

        Samples that are not numbers are left out; a block of nothing else repeats the mean before it.
        """
        whole = samples if self._left.shape[1] == 0 else np.concatenate([self._left, samples], axis=1)
        count = whole.shape[1] // self.size
        # a copy: nothing may keep the reader's blocks alive
        self._left = whole[:, count * self.size :].copy()
        if count == 0:
            return np.empty((samples.shape[0], 0))
        blocks = whole[:, : count * self.size].reshape(samples.shape[0], count, self.size)
        if blocks.dtype == np.int16:
            means = self._digitisation.volts(np.asarray(code_means(blocks)))
        else:
            means = self._known_means(np.asarray(blocks, dtype=np.float64))
        # a block without a number shall not look like a motion to zero
        self._last = means[:, -1].copy()
        return means

    def _known_means(self, blocks: FloatArray) -> FloatArray:
        known = np.isfinite(blocks)
        if known.all():
            return np.asarray(self._digitisation.volts(blocks.mean(axis=2)))
        number = known.sum(axis=2)
        means = np.where(known, blocks, 0.0).sum(axis=2) / np.where(number, number, np.nan)
        return held(np.column_stack([self._last, self._digitisation.volts(means)]))[:, 1:]


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


def block_means(values: FloatArray, size: int) -> FloatArray:
    """Return the means of consecutive blocks of `size` samples, (..., n_samples), shape (..., n_samples // size)."""
    *rows, n_samples = values.shape
    blocks = values[..., : n_samples // size * size].reshape(*rows, n_samples // size, size)
    # a product is several times as fast as `mean` over so few
    return np.asarray(blocks @ np.full(size, 1.0 / size))


def blocks_with(flags: BoolArray, size: int) -> BoolArray:
    """Return which blocks of `size` hold any flag, shape (n_channels, n_samples // size)."""
    count = flags.shape[1] // size
    if not flags.any():
        return np.zeros((flags.shape[0], count), dtype=np.bool_)
    return np.asarray(flags[:, : count * size].reshape(flags.shape[0], count, size).any(axis=2))


def code_means(blocks: RawArray) -> FloatArray:
    """Return the means of codes over the last axis of (n_channels, n_blocks, size)."""
    size = blocks.shape[2]
    if size == 1:
        return np.asarray(blocks[:, :, 0], dtype=np.float64)
    # a float32 mean is wrong by parts in ten million, far below the noise, and several times faster than the others
    # codes are numbers: what a BLAS kernel says of lanes beside them is no fault of theirs
    with np.errstate(invalid="ignore"):
        means = blocks.astype(np.float32) @ np.full(size, 1.0 / size, dtype=np.float32)
    return np.asarray(means, dtype=np.float64)
