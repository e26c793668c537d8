"""What the samples of one run are like, counted while they are written: extremes, rail values, not a number."""

from __future__ import annotations

import numpy as np

from radargui.acquisition.level import HIGHEST_CODE, LOWEST_CODE
from radargui.model.arrays import FloatArray, IntArray, RawArray
from radargui.model.digitisation import Digitisation


class RunTally:
    """Counts of each channel since it was made.

    Parameters
    ----------
    digitisation
        Names and scale of the channels.
    """

    def __init__(self, digitisation: Digitisation) -> None:
        n = digitisation.n_channels
        self._digitisation = digitisation
        self._lowest: FloatArray = np.full(n, np.inf)
        self._highest: FloatArray = np.full(n, -np.inf)
        self._at_rail: IntArray = np.zeros(n, dtype=np.intp)
        self._unknown: IntArray = np.zeros(n, dtype=np.intp)

    def push(self, samples: RawArray) -> None:
        """Count samples, shape (n_channels, n)."""
        if samples.shape[1] == 0:
            return
        if samples.dtype == np.int16:
            lowest, highest = samples.min(axis=1), samples.max(axis=1)
            for channel in np.flatnonzero((lowest <= LOWEST_CODE) | (highest >= HIGHEST_CODE)):
                row = samples[channel]
                self._at_rail[channel] += int(((row <= LOWEST_CODE) | (row >= HIGHEST_CODE)).sum())
        else:
            lowest, highest = np.fmin.reduce(samples, axis=1), np.fmax.reduce(samples, axis=1)
            self._unknown += (~np.isfinite(samples)).sum(axis=1)
        self._lowest = np.fmin(self._lowest, lowest)
        self._highest = np.fmax(self._highest, highest)

    def channels(self) -> list[dict[str, object]]:
        """Return one plain table a channel: name, lowest_v, highest_v, at_rail, not_a_number."""
        ends = np.stack([self._lowest, self._highest], axis=1)
        known = np.asarray(np.isfinite(ends).all(axis=1))
        volts = np.sort(self._digitisation.volts(np.where(known[:, None], ends, 0.0)), axis=1)
        return [
            {
                "name": name,
                "lowest_v": float(volts[channel, 0]) if known[channel] else None,
                "highest_v": float(volts[channel, 1]) if known[channel] else None,
                "at_rail": int(self._at_rail[channel]),
                "not_a_number": int(self._unknown[channel]),
            }
            for channel, name in enumerate(self._digitisation.channel_names)
        ]
