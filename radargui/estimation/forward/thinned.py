"""Bins of which only some are looked at; values of the others lie on straight lines between theirs."""

from __future__ import annotations

import numpy as np

from radargui.model.arrays import ComplexArray


class Thinned:
    """Every `each`-th bin and the last one.

    Called with values there, (..., n_some), it returns those of all bins, (..., n_bins).

    Attributes
    ----------
    bins
        Their numbers, shape (n_some,).
    """

    def __init__(self, n_bins: int, each: int) -> None:
        self.bins = np.unique(np.append(np.arange(0, n_bins, each), n_bins - 1))
        every = np.arange(n_bins)
        self._before = np.clip(np.searchsorted(self.bins, every, side="right") - 1, 0, max(self.bins.size - 2, 0))
        after = np.minimum(self._before + 1, self.bins.size - 1)
        # of a single bin there is no way to the next
        way = np.maximum(self.bins[after] - self.bins[self._before], 1)
        self._share = (every - self.bins[self._before]) / way

    def __call__(self, values: ComplexArray) -> ComplexArray:
        """Return the values of all bins."""
        step = np.diff(values, axis=-1, append=values[..., -1:])
        return np.asarray(values[..., self._before] + self._share * step[..., self._before])
