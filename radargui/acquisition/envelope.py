"""A rolling view of samples, smallest and largest of each pixel column, made from new samples only."""

import numpy as np

from radargui.acquisition.ring import Ring
from radargui.model.arrays import BoolArray, FloatArray, lowest_and_highest


class Envelope:
    """Keeps minimum and maximum of fixed bins of absolute sample indices, so that a peak never hides nor flickers.

    Parameters
    ----------
    n_channels
        Rows.
    window
        Samples that the view is long.
    n_bins
        Bins wanted over the window, about one a pixel.
    """

    def __init__(self, n_channels: int, window: int, n_bins: int) -> None:
        self.bin = max(1, window // max(1, n_bins))
        self._window = window
        self._capacity = window // self.bin + 2
        self._low = np.full((n_channels, self._capacity), np.nan)
        self._high = np.full((n_channels, self._capacity), np.nan)
        self._lost = np.zeros(self._capacity, dtype=np.bool_)
        self._seen = np.full(self._capacity, -1, dtype=np.int64)
        self.end = 0

    def push(self, first_index: int, samples: FloatArray) -> None:
        """Take samples (n_channels, n) from absolute index `first_index` on; NaN were lost."""
        count = samples.shape[1]
        last_index = first_index + count
        if count == 0 or last_index <= self.end:
            return
        if first_index < self.end:
            samples = samples[:, self.end - first_index :]
            first_index = self.end
        bins = np.arange(first_index // self.bin, (last_index - 1) // self.bin + 1)
        low, high = lowest_and_highest(samples, self.bin, first_index)
        lost = lowest_and_highest(np.isnan(samples[0]), self.bin, first_index)[1]
        if bins.size > self._capacity:
            bins, low, high, lost = (a[..., -self._capacity :] for a in (bins, low, high, lost))
        slot = bins % self._capacity
        fresh = self._seen[slot] != bins
        self._low[:, slot] = np.where(fresh, low, np.fmin(self._low[:, slot], low))
        self._high[:, slot] = np.where(fresh, high, np.fmax(self._high[:, slot], high))
        self._lost[slot] = np.where(fresh, lost, self._lost[slot] | lost)
        self._seen[slot] = bins
        self.end = last_index

    def view(self) -> tuple[FloatArray, FloatArray, BoolArray]:
        """Return the window up to the newest sample.

        Returns
        -------
        tuple
            Sample indices shape (2 n,), minimum and maximum of each bin one after the other shape (n_channels, 2 n),
            and whether samples of the bin were lost shape (n,).
        """
        newest = (self.end - 1) // self.bin
        oldest = max(0, (self.end - self._window) // self.bin, newest - self._capacity + 1)
        bins = np.arange(oldest, newest + 1)
        slot = bins % self._capacity
        known = self._seen[slot] == bins
        bins, slot = bins[known], slot[known]
        return (
            np.repeat((bins + 0.5) * self.bin, 2),
            _in_turn(self._low[:, slot], self._high[:, slot]),
            self._lost[slot],
        )


def _in_turn(low: FloatArray, high: FloatArray) -> FloatArray:
    """Return the values of both, shape (n_channels, n) each, one after the other, shape (n_channels, 2 n)."""
    return np.stack([low, high], axis=2).reshape(len(low), -1)


def thin(samples: FloatArray, most: int) -> FloatArray:
    """Return at most `most` evenly spaced columns of samples (n, n_samples), the last one among them."""
    step = max(1, -(-samples.shape[1] // most))
    return samples[:, (samples.shape[1] - 1) % step :: step]


def look(ring: Ring, first: int, last: int, n_bins: int) -> tuple[FloatArray, FloatArray, BoolArray, int]:
    """Return samples first:last of a ring as about `n_bins` bins, each with its lowest and highest.

    Returns
    -------
    tuple
        As `Envelope.view`, and the samples of a bin; where that is 1, each sample stands once.
    """
    size = max(1, (last - first) // max(1, n_bins))
    begin, low, high, lost = ring.extremes(first, last, size)
    bins = np.arange(begin, begin + lost.size)
    return np.repeat((bins + 0.5 * (size > 1)) * size, 2), _in_turn(low, high), lost, size
